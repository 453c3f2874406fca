"""What is given instead of data, and what is assumed of data that are left out."""

from dataclasses import replace

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity import KerrNewmanHorizon, SurfaceData, chen_wang_yau, embed_surface, wang_yau
from isoembed.smooth import AngleMetric, GridMetric
from isoembed.space import Hyperbolic

THETA, PHI = (np.arange(12) + 0.5) * np.pi / 12, np.zeros(1)
ONE = np.ones((12, 1))
GRID = GridMetric(THETA, PHI, ONE, 0.0 * ONE, np.sin(THETA)[:, None] ** 2)


@pytest.mark.parametrize(
    "given, sentence",
    [
        (GRID, "a GridMetric, not SurfaceData: for a metric alone, SurfaceData\\(metric\\)"),
        (KerrNewmanHorizon(), "a KerrNewmanHorizon, not SurfaceData: take its data\\(\\)"),
    ],
)
def test_a_refusal_says_what_to_give_instead(given, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        embed_surface(given)


def test_that_p_and_j_are_taken_to_be_0_is_said():
    found = wang_yau(SurfaceData(GRID, 1.5 * ONE))
    assert "neither p nor K(., n) is given: both are assumed to be 0" in found.notes[0]
    zero = np.zeros((2, 12, 1))
    assert not wang_yau(SurfaceData(GRID, 1.5 * ONE, 0.0 * ONE, zero)).notes


def test_a_momentum_of_0_needs_no_normal_momentum():
    found = embed_surface(SurfaceData(GRID, 1.5 * ONE, 0.0 * ONE), space=Hyperbolic(0.1))
    without = replace(found.data, momentum=None)
    assert chen_wang_yau(found.data, found.embedding).energy == chen_wang_yau(without, found.embedding).energy
    assert wang_yau(SurfaceData(GRID, 1.5 * ONE, 0.0 * ONE)).energy.value > 0.0
    with pytest.raises(InvalidParameter, match="with a momentum, the Wang-Yau energy needs the normal_mom"):
        wang_yau(SurfaceData(GRID, 1.5 * ONE, 0.1 * ONE))


def test_that_a_dimple_may_be_a_reflected_one_is_said():
    def components(theta, phi):  # r^2 = 1 + 0.8 cos 2 theta, a waist
        r2, slope = 1.0 + 0.8 * np.cos(2.0 * theta), -0.8 * np.sin(2.0 * theta)
        return r2 + slope**2 / r2 + 0.0 * phi, 0.0, r2 * np.sin(theta) ** 2

    found = embed_surface(SurfaceData(AngleMetric(components)), vertices=300)
    assert found.embedding.least_curvature < 0.0
    assert any("a dimple and its reflection have the same metric" in note for note in found.energies.notes)


@pytest.mark.parametrize(
    ("field", "name"),
    [
        ("mean_curvature", "the mean curvature"),
        ("momentum", "the momentum"),
        ("normal_momentum", r"K\(., n\)"),
    ],
)
def test_values_that_are_not_finite_are_refused(field, name):
    def values(u):
        out = np.ones_like(u) if field == "normal_momentum" else np.ones(len(u))
        out[u[:, 2] > 0.5] = np.nan
        return out

    data = replace(
        SurfaceData(AngleMetric(lambda theta, phi: (1.0, 0.0, np.sin(theta) ** 2))), **{field: values}
    )
    with pytest.raises(InvalidParameter, match=f"{name} in the direction .* is .*nan.*: it must be finite"):
        surface = embed_surface(data)
        _ = surface.energies, surface.spin


@pytest.mark.parametrize("field", ["mean_curvature", "momentum"])
@pytest.mark.parametrize("values", [None, "2", 2j], ids=repr)
def test_functions_that_return_no_real_numbers_are_named(field, values):
    sphere = SurfaceData(
        AngleMetric(lambda theta, phi: (1.0, 0.0, np.sin(theta) ** 2)), lambda u: np.ones(len(u))
    )
    with pytest.raises(InvalidParameter, match=rf"the {field.replace('_', ' ')} has .*, not real numbers"):
        _ = embed_surface(replace(sphere, **{field: lambda u: values})).energies


def test_a_horizon_whose_angular_momentum_is_not_known_says_so():
    data = SurfaceData(GRID, marginal=True)
    assert any(
        note.startswith("J and the Christodoulou mass are") for note in embed_surface(data).energies.notes
    )
    known = replace(data, angular_momentum=0.0)
    assert not any(
        "the Christodoulou mass are unknown" in note for note in embed_surface(known).energies.notes
    )
