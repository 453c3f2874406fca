"""Horizons, near-horizons and none: spheres in Kerr-Schild coordinates, of which all energies are known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from horizons import IMC
from isoembed.errors import InvalidParameter
from isoembed.relativity import (
    AnalyticCallable,
    CartesianGrid,
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    embed_surface,
    expansion_test,
    horizon_data,
    read_horizon,
)
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.expansion import classify_horizon, classify_surface
from isoembed.smooth import GridMetric
from isoembed.smooth.uncertain import UncertainFunction, Uncertainty
from places import SHARED

HOLE = KerrSchild(1.0, (0.0, 0.0, 0.0))


def scattered(n, seed=1):
    u = np.random.default_rng(seed).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def sphere(r, noise=0.0, geometry=HOLE, **options):
    u = scattered(300)
    r = r * (1.0 + noise * np.random.default_rng(2).normal(size=(len(u), 1)))
    shape = CoordinateShape.star_shaped(r * u, "sphere", np.zeros(3))
    data, facts = horizon_data(shape, geometry, **options)
    return data, facts.report


@cache
def round_sphere():
    return embed_surface(StarSurface.sphere((0.0, 0.0, 0.0), 2.0).data(HOLE), vertices=60)


def energies(data):
    return embed_surface(data, start=round_sphere()).energies


def held(estimate, exact, largest=np.inf):
    assert abs(estimate.value - exact) <= estimate.error <= largest


@pytest.mark.parametrize(("r", "noise"), [(2.0001, 0.0), (2.001, 1e-6), (2.01, 0.0)])
def test_a_horizon_that_is_a_little_off_has_the_errors_of_both_readings(r, noise):
    data, facts = sphere(r, noise)
    assert data.marginal and data.doubtful and facts["marginal"]
    assert facts["displacement"] == pytest.approx(1.0 - 2.0 / r, rel=0.1)
    assert "treated as a horizon that was located inexactly" in data.notes[0]
    found = energies(data)
    for m, liu_yau in ((1.0, 2.0), (0.5 * r, r * (1.0 - np.sqrt(1.0 - 2.0 / r)))):
        held(found.irreducible_mass, m, 5.0 * (r - 2.0))
        held(found.hawking, 1.0, 5.0 * (r - 2.0))
        held(found.liu_yau, liu_yau, 4.0 * np.sqrt(r - 2.0))
        held(found.integrated_mean_curvature, 8.0 * np.pi * m)


def test_extrinsic_curvature_of_the_opposite_sign_makes_no_horizon():
    def K(x):
        return -HOLE.extrinsic_curvature(x)

    data, facts = sphere(2.0, geometry=AnalyticCallable(HOLE.metric, K))
    assert not data.marginal and facts["inward"]
    assert "k + p vanishes instead of k - p" in data.notes[0]


def test_a_grid_without_extrinsic_curvature_is_said_to_be_time_symmetric():
    ticks = np.arange(20) * 0.3 - 2.85
    x = np.stack(np.meshgrid(ticks, ticks, ticks, indexing="ij"), axis=-1)
    gamma = np.moveaxis(HOLE.metric(x.reshape(-1, 3)).reshape(*x.shape, 3), (3, 4), (0, 1))
    data, _ = sphere(2.0, geometry=CartesianGrid(x[0, 0, 0].tolist(), 0.3, gamma))
    assert data.notes[0] == "the slice has no K_ij: it is assumed to be time-symmetric"
    assert not data.marginal


@pytest.mark.parametrize("r", [2.05, 3.0])
def test_what_is_farther_away_is_no_horizon(r):
    data, facts = sphere(r)
    assert not (data.marginal or facts["marginal"])
    found = energies(data)
    assert found.christodoulou_mass is None
    held(found.hawking, 1.0, 1e-11)
    held(found.liu_yau, r * (1.0 - np.sqrt(1.0 - 2.0 / r)), 1e-11)
    assert found.notes[0].startswith("not a horizon: the expansion is")


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_horizon_is_one_within_the_noise_of_its_points(noise):
    data, facts = sphere(2.0, noise)
    assert data.marginal and data.notes == ()
    assert facts["largest_expansion"] <= facts["expansion_error"] <= 3e-12 + 20.0 * noise
    found = energies(data)
    held(found.liu_yau, 2.0, 1e-12 + 9.0 * noise)
    held(found.hawking, 1.0, 1e-12 + 9.0 * noise)


def test_much_noise_hides_no_near_horizon():
    """The error of k anywhere is larger than the expansion, that of its mean is not."""
    data, _ = sphere(2.01, 1e-3)
    test = expansion_test(replace(data, marginal=False))
    assert test.displacement_error < test.displacement
    assert not test.is_zero


def test_it_can_be_said_instead():
    said, _ = sphere(2.14, marginal=True)
    assert said.marginal and not said.doubtful
    assert "treated as a horizon as requested, although the expansion is 0.044" in said.notes[0]
    held(energies(said).liu_yau, 2.0)
    denied, _ = sphere(2.001, marginal=False)
    assert not denied.marginal and denied.notes == ()
    held(energies(denied).liu_yau, 2.001 * (1.0 - np.sqrt(1.0 - 2.0 / 2.001)), 1e-10)


def test_a_metric_without_k_is_no_horizon_unless_it_is_said():
    grid = SurfaceData(GridMetric.sampled(KerrNewmanSphere(4.0), 16, 4))
    data = horizon_data(grid)[0]
    assert not data.marginal
    assert "not treated as a horizon, because k is unknown" in data.notes[0]
    found = energies(data)
    assert (found.hawking, found.liu_yau) == (None, None)
    said = horizon_data(grid, marginal=True)[0]
    assert said.marginal and said.notes == ()
    with pytest.raises(InvalidParameter, match="cannot be identified without the mean curvature"):
        expansion_test(data)


@pytest.mark.parametrize("scale", [1e-3, 1e6])
def test_units(scale):
    data, _ = sphere(2.001 * scale, geometry=KerrSchild(scale, (0.0, 0.0, 0.0)))
    test = expansion_test(data)
    assert test.displacement == pytest.approx(1.0 - 2.0 / 2.001, rel=1e-9)
    assert scale * test.largest_expansion == pytest.approx(3.5e-4, rel=0.01)


def test_errors_of_k_and_p_make_that_of_the_expansion():
    metric = KerrNewmanSphere(2.5)

    def uncertain(value, pointwise, mean):
        return UncertainFunction(lambda u: np.full(len(u), value), Uncertainty(pointwise, mean))

    data = SurfaceData(metric, uncertain(0.4, 0.03, 3e-3), uncertain(0.38, 0.02, 2e-3))
    test = expansion_test(data)
    assert test.largest_expansion == pytest.approx(0.02)
    assert test.expansion_error == pytest.approx(0.05)
    assert test.displacement == pytest.approx((0.4**2 - 0.38**2) * 2.5**2 / 4.0)
    assert test.displacement_error == pytest.approx(0.4 * 5e-3 * 0.78 * 2.5**2 / 4.0)
    assert not classify_horizon(data, None).marginal
    nearer = replace(data, momentum=uncertain(0.399, 0.02, 2e-3))
    assert classify_horizon(nearer, None).marginal and not classify_horizon(nearer, None).doubtful


def test_an_outlier_is_named_and_its_error_is_gone():
    u = scattered(600, seed=4)
    points = 2.5 * u
    points[17] *= 1.2
    data = horizon_data(CoordinateShape.star_shaped(points, "", np.zeros(3)), HOLE)[0]
    x, y, z = points[17]
    said = f"point 17 at ({x:.6g}, {y:.6g}, {z:.6g}) was left out: it lies 0.5 outside the surface"
    assert data.notes[0].startswith(said)
    found = energies(data)
    held(found.area, 25.0 * np.pi, 1e-10)
    held(found.liu_yau, 2.5 * (1.0 - np.sqrt(1.0 - 2.0 / 2.5)), 1e-10)


def test_functions_of_another_shape_are_refused():
    data = replace(KerrNewmanSphere(4.0).data(), momentum=lambda u: u)
    with pytest.raises(InvalidParameter, match=r"the momentum at \d+ directions has the shape \(\d+, 3\)"):
        expansion_test(data)


@pytest.mark.parametrize("m", [100, 300, 600])
def test_well_sampled_horizons_stay_exact(m):
    hole = KerrSchild(1.0, (0.0, 0.36, 0.48))
    u = scattered(m, seed=3)
    shape = CoordinateShape.star_shaped(hole.spheroid(hole.horizon)(u)[:, None] * u, "", np.zeros(3))
    data, _ = horizon_data(shape, hole, axis=(0.0, 0.36, 0.48))
    assert data.marginal and not data.doubtful
    assert data.relative_error < {100: 1e-4, 300: 1e-9, 600: 1e-11}[m]


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.parametrize("marginal", [None, True])
def test_the_horizon_that_the_einstein_toolkit_found(marginal):
    spin = (0.0, -0.6 * np.sin(0.4), 0.6 * np.cos(0.4))
    hole = KerrSchild(1.0, spin)
    shape = read_horizon(SHARED / "real" / "einsteintoolkit" / "EinsteinExact_KS-tilted-EE.h.t0.ah1.gp")
    found = embed_surface(horizon_data(shape, hole, axis=spin, marginal=marginal)[0]).energies
    exact = StarSurface.from_radius(hole.spheroid(hole.horizon))
    assert exact.misfit < 1e-14
    m = np.sqrt(0.5 + 0.5 * np.sqrt(1.0 - 0.36))
    held(found.irreducible_mass, m, 5e-3)
    held(found.hawking, m, 5e-3)
    held(found.liu_yau, IMC[0.6] / (4.0 * np.pi), 0.1 if marginal is None else 5e-3)


def test_what_may_be_a_horizon_is_noted():
    for r, near in ((2.0, True), (2.001, True), (3.0, False)):
        data = classify_surface(StarSurface.sphere((0.0, 0.0, 0.0), r).data(HOLE))
        assert not data.marginal
        assert [note.startswith("this may be a horizon") for note in data.notes] == [True] * near
    assert classify_surface(SurfaceData(KerrNewmanSphere(4.0))).notes == ()
