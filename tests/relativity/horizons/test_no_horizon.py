"""Every way in which a horizon is not found, and its sentence."""

import numpy as np
import pytest

from gridded import sampled
from isoembed.errors import InvalidParameter, NoHorizon
from isoembed.relativity.horizons import radial_image
from isoembed.relativity.horizons.finder import constant_expansion, find_horizon, find_horizons
from isoembed.relativity.spacetimes.kerr_slices import BoyerLindquist, KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild, PainleveGullstrand
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable, CallableGeometry
from isoembed.relativity.spacetimes.transformed import Translated

ORIGIN = (0.0, 0.0, 0.0)
FLAT = AnalyticCallable(lambda x: np.tile(np.eye(3), (len(x), 1, 1)))


def star(x):
    """A ball of constant density in isotropic coordinates, more compact than M / R = 0.3."""
    r2 = np.einsum("ni,ni->n", x, x)
    return (1.0 + 0.2 / np.sqrt(0.3 + r2))[:, None, None] ** 4 * np.eye(3)


@pytest.mark.parametrize(
    ("geometry", "least"), [(FLAT, 1.0), pytest.param(AnalyticCallable(star), 0.7, marks=pytest.mark.slow)]
)
def test_no_horizon(geometry, least):
    with pytest.raises(NoHorizon, match="no horizon was found") as failure:
        find_horizon(geometry, StarSurface.sphere((0.0, 0.0, 0.0), 3.0))
    assert failure.value.least == pytest.approx(least, abs=0.1)


def test_where_to_look_is_not_known():
    with pytest.raises(InvalidParameter, match=r"find_horizon\(geometry, guess\)"):
        find_horizon(CallableGeometry(star, 1.0))


def test_the_slice_ends_before_its_horizon():
    with pytest.raises(InvalidParameter, match="Boyer-Lindquist coordinates are singular on the horizon"):
        find_horizon(BoyerLindquist(1.0, (0.0, 0.0, 0.5)))


def test_the_grid_ends_before_the_horizon():
    grid = sampled(KerrSchild(1.0, ORIGIN), 8, 1.0, center=(4.5, 0.0, 0.0))
    with pytest.raises(
        NoHorizon, match="no surface of constant expansion was found near the starting sphere"
    ):
        find_horizon(grid)


def test_the_guess_leaves_the_grid():
    grid = sampled(IsotropicSchwarzschild(1.0), 12, 1.0)
    with pytest.raises(InvalidParameter, match="lies outside the grid, which reaches from"):
        find_horizon(grid, StarSurface.sphere(ORIGIN, 1.2))


def test_data_are_missing_where_the_horizon_is():
    grid = sampled(IsotropicSchwarzschild(1.0), 32, 2.0, missing=0.7)
    with pytest.raises(NoHorizon, match="data are missing there or nearby"):
        find_horizon(grid)


@pytest.mark.parametrize(
    "move",
    [
        pytest.param(lambda grid: grid, marks=pytest.mark.slow),
        lambda grid: Translated(grid, (5.0, 0.0, 0.0)),
    ],
)
def test_a_grid_that_is_too_coarse(move):
    grid = sampled(IsotropicSchwarzschild(1.0), 24, 2.2)
    coarse = rf"\.\nThis surface has a diameter of \d\.\d+ .* at least {20 * 4.4 / 23:.3g}: use a finer grid"
    with pytest.raises(NoHorizon, match=rf"the slice may displace the surface by \d+ %.*{coarse}"):
        find_horizon(move(grid))


def test_the_degree_does_not_suffice(monkeypatch):
    monkeypatch.setattr(radial_image, "HIGHEST_DEGREES", (8, 8))
    horizon = find_horizon(KerrSchild(1.0, (0.0, 0.6, 0.6)))
    assert horizon.residual > 1e-6
    assert horizon.notes[0].startswith("in degree 8 the expansion is still")


def test_no_surface_of_that_expansion():
    # theta = 2 / r (1 - sqrt(2 M / r)) is at most 8 / 27 M, at r = 9 M / 2
    with pytest.raises(NoHorizon, match=r"no surface of expansion 0.2 was found near the guess"):
        constant_expansion(PainleveGullstrand(1.0), 0.2, StarSurface.sphere(ORIGIN, 4.5))


def test_a_radius_that_is_not_positive():
    with pytest.raises(InvalidParameter, match="the radius must be positive, not -1"):
        find_horizon(FLAT, StarSurface.sphere(ORIGIN, -1.0))


@pytest.mark.parametrize(
    ("search", "sentence"),
    [
        (
            lambda: find_horizon(FLAT, ((0, 0, 0), 1.0)),
            "the guess is a tuple, not a surface such as StarSurf",
        ),
        (lambda: constant_expansion(FLAT, 0.1, 2.0), "the guess is a float, not a surface"),
        (
            lambda: find_horizon(star, StarSurface.sphere((0, 0, 0), 1.0)),
            "the slice is a function, .*Analytic",
        ),
        (
            lambda: find_horizon(2),
            "the slice is a int, not a ThreeGeometry: derive its class from",
        ),
        (lambda: find_horizons(star), "the slice is a function, not a ThreeGeometry: AnalyticCallable"),
        (lambda: StarSurface.sphere((0, 0, 0), 1.0).data(star), "the slice is a function"),
    ],
)
def test_slips(search, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        search()


def test_a_grid_that_is_fine_enough():
    spacing = 1.0 / 20.0  # the horizon's radius is 0.5
    grid = sampled(IsotropicSchwarzschild(1.0), 30, 14.5 * spacing)
    found = find_horizon(grid, StarSurface.sphere(ORIGIN, 0.6))
    assert found.irreducible_mass == pytest.approx(1.0, abs=1e-6)
