"""The curvature that files bring, against that of the metric in use."""

from dataclasses import replace

import numpy as np
import pytest

from isoembed.relativity import (
    AnalyticCallable,
    CoordinateShape,
    CurvatureCheck,
    IsotropicSchwarzschild,
    KerrNewmanHorizon,
    KerrSchild,
    StarSurface,
    embed_series,
    energy_table,
    horizon_data,
    read_horizon,
    read_spectre,
)
from isoembed.relativity.horizons.curvature_check import brought_curvature
from isoembed.smooth import GridMetric
from places import SHARED

SPECTRE = SHARED / "real" / "spectre_SurfaceTestData.h5"
SPIN = np.array([0.1, -0.2, 0.4])


def kerr(unit=1.0, noise=0.0):
    """Points of a Kerr horizon with its RicciScalar."""
    geometry = KerrSchild(unit, SPIN * unit)
    rng = np.random.default_rng(3)
    u = rng.normal(size=(500, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    points = geometry.spheroid(geometry.horizon)(u)[:, None] * u
    r2, along = geometry.horizon**2, (points @ SPIN * unit / geometry.horizon) ** 2
    ricci = 2.0 * (r2 + SPIN @ SPIN * unit**2) * (r2 - 3.0 * along) / (r2 + along) ** 3
    ricci *= 1.0 + noise * rng.normal(size=len(u))
    return CoordinateShape.star_shaped(points, "kerr", np.zeros(3), fields={"RicciScalar": ricci})


def check(shape, geometry):
    return horizon_data(shape, geometry)[1].curvature_check


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e6])
def test_the_right_geometry_agrees(unit):
    found = check(kerr(unit), KerrSchild(unit, SPIN * unit))
    assert found.field == "RicciScalar"
    assert found.agrees and not found.notes
    assert found.relative < 1e-8
    assert found.rms <= found.expected


def test_a_curvature_of_zero_is_beyond_errors():
    shape = replace(kerr(), fields={"RicciScalar": np.zeros(500)})
    found = check(shape, KerrSchild(1.0, SPIN))
    assert not found.agrees and found.notes
    assert found.rms == found.size and "beyond their errors" in found.report["message"]


@pytest.mark.parametrize(
    ("mass", "spin"), [(1.001, SPIN), (1.0, -0.5 * SPIN), (1.0, SPIN[[1, 0, 2]]), (1000.0, 1000.0 * SPIN)]
)
def test_a_wrong_mass_spin_or_unit_is_told(mass, spin):
    found = check(kerr(), KerrSchild(mass, spin))
    assert not found.agrees
    (note,) = found.notes
    assert "mass, spin, time or unit" in note


def test_noise_of_the_field_is_expected_but_no_more():
    found = check(kerr(noise=1e-4), KerrSchild(1.0, SPIN))
    assert found.agrees
    assert 1e-5 < found.rms <= 2.0 * found.expected < 1e-4
    assert not check(kerr(noise=1e-4), KerrSchild(1.01, SPIN)).agrees


def test_it_is_in_the_report():
    (found,) = embed_series([(None, kerr(), KerrSchild(1.0, 0.9 * SPIN))], vertices=100)
    assert found.report["curvature_check"]["field"] == "RicciScalar"
    assert found.report["curvature_check"]["agrees"] is False
    assert any("RicciScalar" in note for note in found.report["notes"])
    assert "beyond their errors" in energy_table(found.report)


def test_without_curvature_there_is_no_check():
    shape = kerr()
    bare = CoordinateShape(shape.points.copy(), shape.faces.copy(), shape.center.copy(), is_hull=True)
    assert check(bare, KerrSchild(1.0, SPIN)) is None


def test_values_that_are_missing_are_left_out():
    shape = kerr()
    ricci = shape.fields["RicciScalar"].copy()
    ricci[::7] = np.nan
    holes = CoordinateShape(
        shape.points.copy(), shape.faces.copy(), shape.center.copy(), fields={"RicciScalar": ricci}
    )
    assert check(holes, KerrSchild(1.0, SPIN)).agrees


def newman_penrose(psi2, k1, k2, turn):
    """Fields of QuasiLocalMeasures where the principal curvatures are k1, k2 in a static slice.

    ``D_b l_a = h_ab / sqrt(2) = -D_b n_a`` along it, and ``m = exp(i turn) (e_1 + i e_2) / sqrt(2)``.
    """
    rho = mu = -(k1 + k2) / np.sqrt(8.0) + 0j
    sigma = -(k1 - k2) / np.sqrt(8.0) * np.exp(2j * turn)
    values = {"npsigma": sigma, "nprho": rho, "npmu": mu, "nplambda": sigma.conj(), "psi2": psi2 + 0j}
    return {part + name: getattr(v, key) for name, v in values.items() for part, key in PARTS}


PARTS = (("re", "real"), ("im", "imag"))


def test_gauss_equation_with_shear():
    rng = np.random.default_rng(0)
    k1, k2, turn = rng.normal(size=(3, 20))
    name, K = brought_curvature(newman_penrose(np.zeros(20), k1, k2, turn))
    assert name == "repsi2"
    assert np.abs(K - k1 * k2).max() < 1e-14


def test_newman_penrose_of_a_sphere_around_a_black_hole():
    x = StarSurface.sphere((0, 0, 0), 2.0).points(np.random.default_rng(1).normal(size=(40, 3)))
    u = x / np.linalg.norm(x, axis=1)[:, None]
    r = 2.0 * (1.0 + 0.5 / 2.0) ** 2  # areal
    k = np.full(40, np.sqrt(1.0 - 2.0 / r) / r)
    fields = newman_penrose(np.full(40, -1.0 / r**3), k, k, np.zeros(40))
    shape = CoordinateShape.star_shaped(2.0 * u, "sphere", np.zeros(3), fields=fields)
    found = check(shape, IsotropicSchwarzschild(1.0))
    assert found.agrees and found.field == "repsi2" and found.relative < 1e-11
    flat = AnalyticCallable(lambda x: np.broadcast_to(np.eye(3), (len(x), 3, 3)) + 0.0 * x[:, :, None])
    assert not check(shape, flat).agrees


def test_a_file_of_points_brings_it(tmp_path):
    shape = kerr()
    K = 0.5 * shape.fields["RicciScalar"]
    np.savez(tmp_path / "ah.npz", points=shape.points, center=np.zeros(3), gaussian_curvature=K)
    found = check(read_horizon(tmp_path / "ah.npz"), KerrSchild(1.0, SPIN))
    assert isinstance(found, CurvatureCheck)
    assert found.agrees and found.field == "gaussian_curvature"


@pytest.mark.shared
def test_a_file_of_spectre():
    pytest.importorskip("h5py")
    shape = read_spectre(SPECTRE, observation=0)
    right = check(shape, KerrSchild(1.0, (0.0, 0.0, 0.2)))
    assert right.agrees and right.relative < 1e-5
    for wrong in (KerrSchild(1.0, (0.0, 0.0, 0.21)), KerrSchild(1.001, (0.0, 0.0, 0.2))):
        assert not check(shape, wrong).agrees


@pytest.mark.parametrize("name", ["gaussian_curvature", "RicciScalar"])
def test_a_file_with_a_metric_on_a_grid_brings_it(tmp_path, name):
    horizon = KerrNewmanHorizon(1.0, 0.6)
    grid = GridMetric.sampled(horizon, 32, 64)
    theta, phi = np.meshgrid(grid.theta, grid.phi, indexing="ij")
    u = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    K = horizon.gaussian_curvature(u.reshape(-1, 3)).reshape(theta.shape)
    q = {part: getattr(grid, part) for part in ("theta", "phi", "q_tt", "q_tp", "q_pp")}
    for factor in (1.0, 1.01):
        np.savez(tmp_path / "grid.npz", **q, **{name: factor * K * (2.0 if name == "RicciScalar" else 1.0)})
        found = horizon_data(read_horizon(tmp_path / "grid.npz"))[1].curvature_check
        assert found.agrees == (factor == 1.0)
        assert found.relative < 1e-8 or factor != 1.0
