"""Data of surfaces on grids: k, p and K(., n) as arrays, their errors in the energies, and refusals."""

import numpy as np
import pytest

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity import (
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    read_grid_data,
)
from isoembed.relativity.energies.smooth_energies import intrinsic_energies
from isoembed.smooth import GridMetric, UncertainFunction, Uncertainty
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.two_metric import angle_frame, area_density

KERR = KerrSchild(1.0, (0.3, 0.0, 0.4))
SURFACE = StarSurface.from_radius(KERR.spheroid(3.0)).data(KERR)
EXACT = intrinsic_energies(SURFACE)


def sampled(data, n=16, m=32):
    """The arguments of `SurfaceData.from_grid`."""
    grid = GridMetric.sampled(data.metric, n, m)
    t, p = np.meshgrid(grid.theta, grid.phi, indexing="ij")
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    e_theta, e_phi = angle_frame(u)
    j = data.normal_momentum(u)
    sin = np.sin(t).ravel()
    return {
        "theta": grid.theta,
        "phi": grid.phi,
        "q": (grid.q_tt, grid.q_tp, grid.q_pp),
        "k": data.mean_curvature(u).reshape(n, m),
        "p": data.momentum(u).reshape(n, m) if data.momentum else None,
        "j": np.reshape([(j * e_theta).sum(1), (j * e_phi).sum(1) * sin], (2, n, m)),
    }


TABLES = sampled(SURFACE)


def in_file(tables):
    q_tt, q_tp, q_pp = tables["q"]
    j_t, j_p = tables["j"]
    rest = {name: tables[name] for name in ("theta", "phi", "k", "p")}
    return {**rest, "q_tt": q_tt, "q_tp": q_tp, "q_pp": q_pp, "j_t": j_t, "j_p": j_p}


def test_functions_of_arrays():
    data = SurfaceData.from_grid(**TABLES, name="r = 3")
    u = np.random.default_rng(3).normal(size=(50, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    for name in ("mean_curvature", "momentum", "normal_momentum"):
        found, exact = getattr(data, name), getattr(SURFACE, name)(u)
        assert np.abs(found(u) - exact).max() <= found.error.pointwise < 1e-4
    assert data.name == "r = 3" and 0.0 < data.relative_error < 1e-8
    energies = intrinsic_energies(data)
    assert abs(energies.hawking.value - EXACT.hawking.value) <= energies.hawking.error < 1e-7


@pytest.mark.parametrize(("noisy", "size"), [("k", 1e-8), ("p", 1e-4), ("k", 1e-2)])
def test_noise_reaches_the_energies(noisy, size):
    ratios = []
    for seed in range(5):
        noise = size * np.random.default_rng(seed).normal(size=TABLES["k"].shape)
        energies = intrinsic_energies(SurfaceData.from_grid(**(TABLES | {noisy: TABLES[noisy] + noise})))
        ratios.append(abs(energies.hawking.value - EXACT.hawking.value) / energies.hawking.error)
        assert energies.area.error < 1e-6
    assert max(ratios) < 1.0 and max(ratios) > 0.01


def test_what_is_not_symmetric_in_a_symmetric_metric_is_integrated():
    """k of a round sphere with a kink across: its integrals need nodes all around."""
    theta, phi = (np.arange(24) + 0.5) * (np.pi / 24), np.arange(48) * (np.pi / 24)
    t, f = np.meshgrid(theta, phi, indexing="ij")
    x = np.sin(t) * np.cos(f)
    k = 2.0 + 0.1 * np.abs(x) ** 3
    data = SurfaceData.from_grid(theta, phi, (np.ones_like(t), 0.0 * t, np.sin(t) ** 2), k)
    energies = intrinsic_energies(data)
    exact = 0.5 * (1.0 - (4.0 + 0.4 / 4.0 + 0.01 / 7.0) / 4.0)  # means of |x|^3 and x^6: 1/4 and 1/7
    assert abs(energies.hawking.value - exact) <= energies.hawking.error < 1e-4


def test_single_precision():
    tables = {
        name: values if name in ("theta", "phi") else np.float32(values) for name, values in TABLES.items()
    }
    energies = intrinsic_energies(SurfaceData.from_grid(**tables))
    for name in ("area", "hawking"):
        found, exact = getattr(energies, name), getattr(EXACT, name)
        assert abs(found.value - exact.value) <= found.error < 1e-5 * exact.value


def test_a_function_of_ones_own_brings_its_errors():
    sphere = KerrNewmanSphere(4.0)
    uncertain = UncertainFunction(sphere.mean_curvature, Uncertainty(1e-3, 1e-5))
    loose = intrinsic_energies(SurfaceData(sphere, uncertain)).hawking
    exact = intrinsic_energies(SurfaceData(sphere, sphere.mean_curvature)).hawking
    assert exact.error < 1e-12 and 1e-5 < loose.error < 1e-3


def test_files_hold_all(tmp_path):
    np.savez(tmp_path / "all.npz", **in_file(TABLES))
    data, given = read_grid_data(tmp_path / "all.npz"), SurfaceData.from_grid(**TABLES)
    u = np.eye(3)
    for name in ("mean_curvature", "momentum", "normal_momentum"):
        np.testing.assert_array_equal(getattr(data, name)(u), getattr(given, name)(u))
    tables = in_file(TABLES)
    del tables["j_t"]
    np.savez(tmp_path / "part.npz", **tables)
    with pytest.raises(ValueError, match="has no j_t, the other component of"):
        read_grid_data(tmp_path / "part.npz")


def test_few_angles_phi_of_a_symmetric_metric_are_noted():
    few = sampled(KerrNewmanSphere(3.0, 1.0, 0.8).data(), 24, 8)
    assert "give one angle phi" in SurfaceData.from_grid(**few).notes[0]
    assert SurfaceData.from_grid(**TABLES).notes == ()


def test_refusals():
    with pytest.raises(InvalidMetric, match=r"^k is uncertain by .* the grid is too coarse$"):
        wild = 0.3 * np.cos(11.0 * TABLES["phi"]) * np.cos(13.0 * TABLES["theta"])[:, None]
        SurfaceData.from_grid(**(TABLES | {"k": TABLES["k"] + wild}))
    with pytest.raises(InvalidMetric, match=r"k has the shape \(32, 16\)"):
        SurfaceData.from_grid(**(TABLES | {"k": TABLES["k"].T}))
    with pytest.raises(InvalidMetric, match=r"p is nan at theta\[2\], phi\[3\]"):
        p = TABLES["p"].copy()
        p[2, 3] = np.nan
        SurfaceData.from_grid(**(TABLES | {"p": p}))
    with pytest.raises(InvalidMetric, match="j has 16 components, not the two for theta and phi"):
        SurfaceData.from_grid(**(TABLES | {"j": TABLES["k"]}))
    with pytest.raises(InvalidMetric, match=r"j has the shape \(2, 32\)"):
        SurfaceData.from_grid(**(TABLES | {"j": [TABLES["k"], TABLES["k"][:2]]}))
    with pytest.raises(InvalidMetric, match="q has 2 components"):
        SurfaceData.from_grid(**(TABLES | {"q": TABLES["q"][:2]}))
    with pytest.raises(
        InvalidParameter, match="the mean_curvature is a ndarray: with a metric that is not on"
    ):
        SurfaceData(KERR_SPHERE, mean_curvature=TABLES["k"])


KERR_SPHERE = KerrNewmanSphere(3.0)


@pytest.mark.parametrize("wrong", [-1e-3, float("nan")])
def test_errors_of_lengths_are_not_negative(wrong):
    with pytest.raises(InvalidParameter, match="must not be negative"):
        SurfaceData(SURFACE.metric, relative_error=wrong)


def test_a_surface_in_other_directions_is_the_same_surface():
    coordinates = SphereMap.linear(np.array([[1.3, 0.2, 0.0], [0.0, 1.0, -0.1], [0.1, 0.0, 0.8]]))
    moved = SURFACE.in_coordinates(coordinates)
    found = intrinsic_energies(moved)
    for one, other in ((found.area, EXACT.area), (found.hawking, EXACT.hawking)):
        assert abs(one.value - other.value) <= 1e-12 * other.value
    nodes, weights = gauss_rule(40, 80)
    J, exact = (
        (weights * area_density(data.metric.tensor(nodes))) @ data.torque(nodes) for data in (moved, SURFACE)
    )
    np.testing.assert_allclose(J, exact, atol=1e-11)
    v = fibonacci_directions(20)
    u = coordinates.forward(v)
    np.testing.assert_array_equal(moved.shape(v), SURFACE.shape(u))
    w = np.cross(v, [0.2, 0.5, -0.4])
    np.testing.assert_allclose(
        np.einsum("ni,ni->n", moved.normal_momentum(v), w),
        np.einsum("ni,nij,nj->n", SURFACE.normal_momentum(u), coordinates.differential(v), w),
        atol=1e-15,
    )
    on_grid = SurfaceData.from_grid(**TABLES)
    again = on_grid.in_coordinates(coordinates)
    assert again.lengths_error == on_grid.lengths_error
    assert again.momentum.error == on_grid.momentum.error and again.notes == on_grid.notes
