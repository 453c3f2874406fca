"""Slices on Cartesian grids: exact for polynomials, of eighth order for holes."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.energies.embedded_surface import embed_surface
from isoembed.relativity.energies.smooth_energies import intrinsic_energies
from isoembed.relativity.spacetimes.cartesian_grid import (
    PERIOD,
    CartesianGrid,
    _Interpolation,
    noise_levels,
    sampled_noise,
)
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild, PainleveGullstrand
from isoembed.relativity.spacetimes.star_surface import StarSurface

HOLE, SPHERE = IsotropicSchwarzschild(1.0), StarSurface.sphere((0, 0, 0), 2.5)
FLAT = np.tile(np.eye(3)[:, :, None, None, None], (1, 1, 9, 10, 11))


def points(shape, spacing, origin):
    i = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    return (np.array(origin) + np.array(spacing) * i).reshape(-1, 3)


def directions():
    u = np.random.default_rng(2).normal(size=(400, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def gridded(values, shape):
    return np.moveaxis(values, 0, -1).reshape(3, 3, *shape)


def polynomial(x):
    """A metric (n, 3, 3) of degree seven, and its gradient."""
    a, b = x @ [0.3, -0.2, 0.1], x @ [0.1, 0.2, -0.3]
    gamma = np.zeros((len(x), 3, 3))
    gradient = np.zeros((len(x), 3, 3, 3))
    for i in range(3):
        gamma[:, i, i] = 2 + i + a**7 - 0.5 * b**3
        gradient[:, :, i, i] = (7 * a**6)[:, None] * [0.3, -0.2, 0.1] - (1.5 * b**2)[:, None] * [
            0.1,
            0.2,
            -0.3,
        ]
    gamma[:, 0, 1] = gamma[:, 1, 0] = a * b
    gradient[:, :, 0, 1] = b[:, None] * [0.3, -0.2, 0.1] + a[:, None] * [0.1, 0.2, -0.3]
    gradient[:, :, 1, 0] = gradient[:, :, 0, 1]
    return gamma, gradient


@given(exponent=st.integers(-100, 100), seed=st.integers(0, 10))
def test_polynomials_are_exact_up_to_the_faces(exponent, seed):
    unit, shape, origin, spacing = 10.0**exponent, (9, 10, 12), (-1.0, -0.5, 0.0), (0.25, 0.2, 0.15)
    x = points(shape, spacing, origin)
    gamma = gridded(polynomial(x)[0], shape)
    grid = CartesianGrid(unit * np.array(origin), unit * np.array(spacing), gamma, gamma)
    asked = np.random.default_rng(seed).uniform(x.min(axis=0), x.max(axis=0), size=(20, 3))
    asked = np.concatenate([asked, [x[0], x[-1], x[500]]])
    expected, gradient = polynomial(asked)
    np.testing.assert_allclose(grid.metric(unit * asked), expected, atol=1e-13)
    np.testing.assert_allclose(grid.extrinsic_curvature(unit * asked), expected, atol=1e-13)
    np.testing.assert_allclose(unit * grid.gradient(unit * asked), gradient, atol=1e-11)


def test_a_hole_converges():
    hole = KerrSchild(1.0, (0.1, 0.2, 0.5))
    surface = StarSurface.from_radius(hole.spheroid(3.0))
    u = np.random.default_rng(1).normal(size=(60, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    x = surface.points(u)
    J = surface.angular_momentum(hole, hole.spin)
    errors = []
    for n in (29, 41):
        at = points((n, n, n), 8.4 / (n - 1), (-4.2, -4.2, -4.2))
        near = np.linalg.norm(at, axis=1) < 0.7  # what a code has cut out
        gamma, K = np.full((2, len(at), 3, 3), np.nan)
        gamma[~near], K[~near] = hole.metric(at[~near]), hole.extrinsic_curvature(at[~near])
        grid = CartesianGrid((-4.2,) * 3, 8.4 / (n - 1), gridded(gamma, (n, n, n)), gridded(K, (n, n, n)))
        errors.append(
            [
                np.abs(grid.metric(x) - hole.metric(x)).max(),
                np.abs(grid.extrinsic_curvature(x) - hole.extrinsic_curvature(x)).max(),
                np.abs(grid.gradient(x) - hole.gradient(x)).max(),
                np.abs(surface.expansion(grid, u) - surface.expansion(hole, u)).max(),
                abs(surface.angular_momentum(grid, hole.spin) / J - 1),
            ]
        )
    orders = np.log(np.array(errors[0]) / errors[-1]) / np.log(40 / 28)
    assert np.all(orders > [7, 7, 6, 6, 6]), orders
    assert np.all(np.array(errors[-1]) < [1e-7, 3e-7, 2e-6, 2e-6, 1e-8]), errors


@cache
def sampled(hole, spacing, half, cut, noise=0.0, unit=1.0):
    """The hole on a cube about the origin, but for a ball within; the unit multiplies all lengths."""
    n = round(2 * half / spacing) + 1
    at = points((n, n, n), spacing, (-half,) * 3)
    near = np.linalg.norm(at, axis=1) < cut
    gamma, K = np.full((2, len(at), 3, 3), np.nan)
    gamma[~near] = hole.metric(unit * at[~near])
    K[~near] = hole.extrinsic_curvature(unit * at[~near])
    rough = noise * np.random.default_rng(6).normal(size=gamma.shape)
    gamma += rough + rough.transpose(0, 2, 1)
    shape = (n, n, n)
    return CartesianGrid(
        (-unit * half,) * 3,
        unit * spacing,
        gridded(gamma, shape),
        None if hole.time_symmetric else gridded(K, shape),
    )


@pytest.fixture(scope="module")
def exact():
    return embed_surface(SPHERE.data(HOLE), vertices=60).energies


@pytest.mark.parametrize(
    ("spacing", "noise"), [(0.25, 0.0), (0.175, 1e-5), pytest.param(0.125, 0.0, marks=pytest.mark.slow)]
)
def test_energies_are_within_their_errors(exact, spacing, noise):
    grid = sampled(HOLE, spacing, 3.5, 0.3, noise)
    found = embed_surface(SPHERE.data(grid), vertices=60).energies
    for name in ("area", "irreducible_mass", "integrated_mean_curvature"):
        assert abs(getattr(found, name).value - getattr(exact, name).value) < getattr(found, name).error
    for name in ("hawking", "brown_york", "liu_yau"):
        off = abs(getattr(found, name).value - getattr(exact, name).value)
        assert off < getattr(found, name).error < 100 * off, name


def test_the_error_knows_of_extrinsic_curvature():
    flat, sphere = PainleveGullstrand(1.0), StarSurface.sphere((0, 0, 0), 2.0)
    errors = []
    for spacing in (0.25, 0.2):
        grid = sampled(flat, spacing, 3.0, 0.2)
        p = sphere.data(grid).momentum
        true = np.abs(p(directions()) - sphere.momentum(flat, directions())).max()
        errors.append(p.error.pointwise)
        assert true < errors[-1] < 100 * true
        assert p.error.mean < p.error.pointwise
    assert np.log(errors[0] / errors[1]) / np.log(1.25) > 6.5
    still = CartesianGrid(grid.origin, grid.spacing, grid.gamma)
    assert sphere.data(still).relative_error < 1e-14


@pytest.fixture(scope="module")
def intrinsic():
    return intrinsic_energies(SPHERE.data(HOLE))


@pytest.mark.parametrize("noise", [1e-8, 1e-3])
def test_noise_on_the_grid_is_in_the_errors(intrinsic, noise):
    """Also where it is less than what interpolation misses, and averages out in part."""
    clean = sampled(HOLE, 0.25, 3.5, 0.3)
    gamma = clean.gamma + noise * np.random.default_rng(4).normal(size=clean.gamma.shape)
    found = intrinsic_energies(SPHERE.data(CartesianGrid(clean.origin, clean.spacing, gamma)))
    for name in ("area", "hawking"):
        assert abs(getattr(found, name).value - getattr(intrinsic, name).value) < getattr(found, name).error


@pytest.mark.slow
def test_errors_of_noise_are_a_few_standard_deviations():
    """The spacing is that of the nodes at which errors are estimated, and truncation is small."""
    hole, sphere = IsotropicSchwarzschild(0.1), StarSurface.sphere((0.1, 0.0, 0.2), 2.5)
    clean, exact = sampled(hole, 0.35, 4.025, 0.1), intrinsic_energies(sphere.data(hole)).area.value
    ratios = []
    for seed in range(8):
        gamma = clean.gamma + 1e-3 * np.random.default_rng(seed).normal(size=clean.gamma.shape)
        area = intrinsic_energies(sphere.data(CartesianGrid(clean.origin, clean.spacing, gamma))).area
        ratios.append((area.value - exact) / area.error)
    assert 0.05 < np.sqrt(np.mean(np.square(ratios))) < 0.5, ratios


@pytest.mark.parametrize("level", [1e-9, 1e-4])
def test_the_level_of_noise_is_found_beside_what_is_smooth(level):
    grid = np.stack(np.meshgrid(*[np.arange(24) * 0.1] * 3, indexing="ij"))
    smooth = np.stack([np.exp(grid[0]) + grid[1] * grid[2], np.cos(grid.sum(axis=0))])
    noisy = smooth + level * np.array([1.0, 3.0])[:, None, None, None] * np.random.default_rng(0).normal(
        size=smooth.shape
    )
    noisy[:, 12, 12, 12] = np.nan
    nodes = np.random.default_rng(1).integers(0, 24, size=(2000, 3))
    found = noise_levels(noisy, nodes) / level
    np.testing.assert_allclose(found, [1.0, 3.0], rtol=0.1)


def test_samples_of_noise_repeat_after_a_period():
    noise = sampled_noise(np.array([1.0, 2.0]), 8, np.random.default_rng(0))
    assert noise.shape == (2, PERIOD + 8, PERIOD + 8, PERIOD + 8)
    np.testing.assert_array_equal(noise[:, :8, 3, PERIOD:], noise[:, PERIOD:, 3, :8])
    np.testing.assert_allclose(noise.std(axis=(1, 2, 3)), [1.0, 2.0], rtol=0.02)


def test_beside_missing_points_the_error_is_told_by_fewer():
    """Some of ten points along an axis are not there next to the hole."""
    hole, sphere = IsotropicSchwarzschild(1.0), StarSurface.sphere((0, 0, 0), 2.0)
    grid, u = sampled(hole, 0.25, 3.0, 0.2), directions()
    assert np.isnan(_Interpolation(grid, 10).metric(sphere.points(u))).any()
    k = sphere.data(grid).mean_curvature
    true = np.abs(k(u) - sphere.mean_curvature(hole, u)).max()
    assert true < k.error.pointwise < 1e3 * true


@pytest.fixture(scope="module")
def on_the_grid():
    return SPHERE.data(sampled(HOLE, 0.25, 3.5, 0.3))


def test_the_error_scales(on_the_grid):
    unit = 1e-60
    one, other = on_the_grid, StarSurface.sphere((0, 0, 0), 2.5 * unit)
    scaled = other.data(sampled(IsotropicSchwarzschild(unit), 0.25, 3.5, 0.3, unit=unit))
    assert scaled.relative_error == pytest.approx(one.relative_error, rel=1e-6)
    error = one.mean_curvature.error.pointwise
    assert scaled.mean_curvature.error.pointwise * unit == pytest.approx(error, rel=1e-6)


def test_six_or_nine_entries():
    nine = FLAT + 0.1
    six = nine[np.triu_indices(3)]
    x = np.array([[0.31, 0.42, 0.53]])
    one, other = CartesianGrid((0, 0, 0), 0.1, nine), CartesianGrid((0, 0, 0), (0.1, 0.1, 0.1), six)
    np.testing.assert_array_equal(one.metric(x), other.metric(x))
    assert one.time_symmetric
    assert not one.extrinsic_curvature(x).any()
    with pytest.raises(ValueError, match="read-only"):
        one.gamma[0, 0, 0, 0] = 2.0


def test_the_users_arrays_stay_writable():
    six = FLAT[np.triu_indices(3)].copy()
    CartesianGrid((0, 0, 0), 0.1, six)
    six[0] = 2.0
    assert six[0, 0, 0, 0] == 2.0


def skew():
    bad = FLAT.copy()
    bad[0, 2, 3, 4, 5] = 0.5
    return bad


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: CartesianGrid((0, 0), 1.0, FLAT), "the origin must be three finite numbers"),
        (lambda: CartesianGrid((0, 0, 0), (1.0, 1.0), FLAT), "the spacing must be three finite numbers"),
        (lambda: CartesianGrid((0, 0, 0), "fine", FLAT), "the spacing must be three finite numbers"),
        (
            lambda: CartesianGrid((0, 0, 0), (1.0, -1.0, 1.0), FLAT),
            "the spacing in y must be positive, not -1.0",
        ),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, FLAT[0]),
            r"gamma must have the shape .* not \(3, 9, 10, 11\)",
        ),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, FLAT[..., :7]),
            r"has \(9, 10, 7\) points: there must be 8 along",
        ),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, skew()),
            r"gamma is not symmetric at the grid point \(3, 4, 5\): 0.5",
        ),
        (lambda: CartesianGrid((0, 0, 0), 1.0, FLAT + 0j), "gamma has complex values, not real numbers"),
        (lambda: CartesianGrid((0, 0, 0), 1.0, FLAT, 1j * FLAT), "K has complex values"),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, FLAT, FLAT[..., :9]),
            r"K is given at \(9, 10, 9\) points, gamma at \(9, 10, 11\)",
        ),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, FLAT).metric(np.array([[1, 2, 3], [1, 9.1, 3.0]])),
            r"point 1, \(1, 9.1, 3\), lies outside the grid, which reaches from \(0, 0, 0\) to \(8, 9, 10\)",
        ),
        (
            lambda: CartesianGrid((0, 0, 0), 1.0, FLAT).gradient(np.full((1, 3), np.nan)),
            r"point 0, \(nan, nan, nan\), lies outside the grid",
        ),
    ],
)
def test_refusals(make, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        make()


@pytest.mark.parametrize("missing", [np.nan, np.inf])
def test_a_surface_through_missing_points_is_refused(missing):
    gamma = FLAT.copy()
    gamma[..., 5, 5, 5] = missing
    surface = StarSurface.sphere((4, 4, 4), 1.0)
    with pytest.raises(InvalidMetric, match=r"is not positive definite: xx, xy, \.\.\. = (nan|inf)"):
        surface.mean_curvature(CartesianGrid((0, 0, 0), 1.0, gamma), np.array([[0, 0, 1.0]]))


def test_a_metric_that_is_positive_definite_nowhere_is_refused():
    lorentzian = FLAT.copy()
    lorentzian[0, 0] = -1.0
    sentence = r"not positive definite anywhere; its first node has xx, xy, ... = -1, 0, 0, 1, 0, 1"
    with pytest.raises(InvalidParameter, match=sentence):
        CartesianGrid((0, 0, 0), 1.0, lorentzian)
    hole = lorentzian.copy()  # what lies inside of a hole is not looked at
    hole[..., 5:, :, :] = FLAT[..., 5:, :, :]
    CartesianGrid((0, 0, 0), 1.0, hole)
