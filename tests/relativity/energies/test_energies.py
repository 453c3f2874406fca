"""The energies of surfaces from their integrals, and these by quadrature: closed forms."""

import json

import numpy as np
import pytest

from isoembed.relativity.energies.energies import Energies, Integrals
from isoembed.relativity.energies.smooth_energies import intrinsic_energies, smooth_energies
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import PulledBack
from isoembed.surface.estimate import Estimate


def sphere(r):
    """A round sphere of radius r, with its embedding."""
    metric = PulledBack(lambda u: np.broadcast_to(r * np.eye(3), (len(u), 3, 3)))
    harmonics = Harmonics(1, 1)
    coefficients = np.zeros((4, 3))
    for column, label in enumerate(((1, 1), (1, -1), (1, 0))):
        k = list(zip(*harmonics.labels, strict=True)).index(label)
        coefficients[k, column] = r * np.sqrt(4.0 * np.pi / 3.0)
    return metric, SmoothEmbedding(metric, harmonics, coefficients, 1e-6, np.inf)


def schwarzschild(r, M, rest=None, **kept):
    """The sphere of areal radius r, in the static slice or in the flat one that falls inward."""
    metric, embedding = sphere(r)
    if rest is False:
        kept |= {"momentum": lambda u: np.full(len(u), 2.0 * np.sqrt(2.0 * M / r) / r)}
        k = 2.0 / r
    else:
        k = 2.0 * np.sqrt(1.0 - 2.0 * M / r) / r
    data = SurfaceData(metric, mean_curvature=lambda u: np.full(len(u), k), **kept)
    return smooth_energies(data, embedding)


def within(estimate, exact):
    assert estimate.error <= 1e-12 * max(abs(exact), 1.0)
    assert abs(estimate.value - exact) <= estimate.error


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("r", [2.5, 3.0, 10.0, 1000.0])
def test_schwarzschild_at_rest(r, unit):
    found = schwarzschild(r * unit, unit)
    exact = r * (1.0 - np.sqrt(1.0 - 2.0 / r))
    for name, value in (
        ("hawking", 1.0),
        ("brown_york", exact),
        ("liu_yau", exact),
        ("irreducible_mass", r / 2),
    ):
        estimate = getattr(found, name)
        assert abs(estimate.value / unit - value) <= max(estimate.error / unit, 1e-15)
        assert estimate.error <= 1e-12 * r * unit


@pytest.mark.parametrize("r", [3.0, 10.0])
def test_in_the_falling_slice_only_brown_york_is_another(r):
    found, resting = schwarzschild(r, 1.0, rest=False), schwarzschild(r, 1.0)
    assert abs(found.brown_york.value) <= found.brown_york.error + 1e-15  # k = k0: a flat slice
    assert found.liu_yau.value == pytest.approx(resting.liu_yau.value, abs=1e-13)
    assert found.hawking.value == pytest.approx(1.0, abs=1e-13)


def test_inside_the_hole_there_is_no_liu_yau_energy():
    found = schwarzschild(1.5, 1.0, rest=False)
    assert found.liu_yau is None
    assert found.hawking.value == pytest.approx(1.0, abs=1e-13)
    assert "k^2 - p^2 = -0.5" in found.notes[0]
    assert "not spacelike" in found.notes[0]


def test_a_horizon_has_no_mean_curvature_vector():
    found = schwarzschild(2.0, 1.0, rest=False, marginal=True, angular_momentum=0.0)
    assert found.hawking.value == pytest.approx(1.0, abs=1e-14)
    assert found.liu_yau.value == pytest.approx(2.0, abs=1e-13)
    assert found.christodoulou_mass.value == pytest.approx(1.0, abs=1e-14)


def test_k_that_cancels_p_only_by_rounding_is_uncertain_by_the_root_of_it():
    found = schwarzschild(2.0, 1.0, rest=False)
    assert abs(found.liu_yau.value - 2.0) <= found.liu_yau.error <= 1e-5


def test_what_needs_k_is_none_without_it():
    metric, embedding = sphere(3.0)
    found = smooth_energies(SurfaceData(metric), embedding)
    assert found.hawking is found.brown_york is found.liu_yau is found.christodoulou_mass is None
    assert found.irreducible_mass.value == pytest.approx(1.5)
    assert found.notes == ("k is not given: there is no Brown-York energy",)
    marginal = smooth_energies(SurfaceData(metric, marginal=True), embedding)
    assert marginal.liu_yau.value == pytest.approx(3.0)
    assert marginal.brown_york is None


def test_without_an_embedding_the_others_remain():
    metric, _ = sphere(2.0)
    found = intrinsic_energies(SurfaceData(metric, mean_curvature=lambda u: np.zeros(len(u))))
    assert found.integrated_mean_curvature is found.brown_york is found.liu_yau is None
    assert found.hawking.value == pytest.approx(1.0)


@pytest.mark.parametrize(("a", "Q"), [(0.0, 0.0), (0.7, 0.0), (0.5, 0.6), (0.0, 1.0), (1.0, 0.0)])
def test_christodoulou_mass_is_the_mass(a, Q):
    r = 1.0 + np.sqrt(max(0.0, 1.0 - a**2 - Q**2))
    area = Estimate(4.0 * np.pi * (r**2 + a**2), 1e-6)
    found = Energies.of(Integrals(area), angular_momentum=a, charge=Q)
    assert found.christodoulou_mass.value == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(("J", "charge"), [(0.2, 0.0), (0.9, 0.0), (0.5, 0.6)])
def test_errors_follow_by_the_derivative(J, charge):
    def at(area, J):
        return Energies.of(Integrals(area), angular_momentum=J, charge=charge)

    area, step = 40.0, 1e-3
    lower, upper = (at(Estimate(area + s, 0.0), J) for s in (-step, step))
    found = at(Estimate(area, step), J)
    for name in ("irreducible_mass", "christodoulou_mass", "dimensionless_spin"):
        change = abs(getattr(upper, name).value - getattr(lower, name).value) / 2.0
        assert getattr(found, name).error == pytest.approx(change, rel=1e-3)
    lower, upper = (at(Estimate(area, 0.0), J + s) for s in (-step, step))
    found = at(Estimate(area, 0.0), Estimate(J, step))
    for name in ("christodoulou_mass", "dimensionless_spin"):
        change = abs(getattr(upper, name).value - getattr(lower, name).value) / 2.0
        assert change <= getattr(found, name).error <= 1.02 * change


def test_without_spin_its_error_is_of_second_order_in_the_mass():
    area, J = Estimate(16.0 * np.pi, 0.0), Estimate(0.0, 1e-3)
    found = Energies.of(Integrals(area), angular_momentum=J)
    assert found.christodoulou_mass.value == 1.0
    assert np.sqrt(1.0 + 1e-6 / 4.0) - 1.0 <= found.christodoulou_mass.error <= 2e-7
    assert found.dimensionless_spin.value == 0.0
    assert found.dimensionless_spin.error == pytest.approx(1e-3, rel=1e-2)


def test_lengths_that_are_uncertain_make_all_uncertain():
    exact, uncertain = schwarzschild(4.0, 1.0), schwarzschild(4.0, 1.0, relative_error=1e-4)
    for name in ("area", "integrated_mean_curvature", "hawking", "brown_york", "liu_yau"):
        assert getattr(uncertain, name).error > 1e-5 > 1e-9 > getattr(exact, name).error
    assert uncertain.error_estimate == max(uncertain.hawking.error, uncertain.liu_yau.error)


def test_the_report_is_plain_json():
    report = json.loads(json.dumps(schwarzschild(4.0, 1.0).report, allow_nan=False))
    assert report["brown_york"] == pytest.approx(1.171572875254)
    assert report["christodoulou_mass"] is None
    assert report["error_estimate"] == max(
        e for e in (report["errors"][n] for n in ("irreducible_mass", "hawking", "brown_york", "liu_yau"))
    )
