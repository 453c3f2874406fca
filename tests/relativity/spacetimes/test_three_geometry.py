"""Slices of black holes: exact gradients, extrinsic curvatures in closed form and by a second road, units."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.finder import find_horizon
from isoembed.relativity.spacetimes.checks import check_slice
from isoembed.relativity.spacetimes.kerr_slices import BoyerLindquist, KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import (
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import (
    AnalyticCallable,
    CallableGeometry,
    ThreeGeometry,
    complex_step,
    stationary_curvature,
)

SPIN = (0.2, -0.3, 0.6)
GEOMETRIES = {
    "kerr-schild": lambda unit: KerrSchild(unit, np.array(SPIN) * unit),
    "boyer-lindquist": lambda unit: BoyerLindquist(unit, np.array(SPIN) * unit),
    "isotropic": lambda unit: IsotropicSchwarzschild(unit),
    "brill-lindquist": lambda unit: BrillLindquist(
        [unit, 0.5 * unit], np.array([[0.1, 0.2, 0.3], [0, 0, -1]]) * unit
    ),
    "painleve-gullstrand": lambda unit: PainleveGullstrand(unit),
}


def outside(n=20, least=2.0, most=6.0):
    """Points between two distances from the origin, some of them on the axes."""
    rng = np.random.default_rng(3)
    u = np.concatenate([rng.normal(size=(n, 3)), np.eye(3), -np.eye(3)])
    return u / np.linalg.norm(u, axis=1, keepdims=True) * rng.uniform(least, most, size=(len(u), 1))


class Own(ThreeGeometry):
    """A slice of another package."""

    time_symmetric = False

    def __init__(self):
        self.hole = KerrSchild(1.0, (0.0, 0.0, 0.5))

    def metric(self, x):
        return self.hole.metric(x)

    def gradient(self, x):
        return self.hole.gradient(x)

    def extrinsic_curvature(self, x):
        return self.hole.extrinsic_curvature(x)

    def error(self, quantity):
        return np.zeros_like(quantity(self))


class Boxed(Own):
    """With all that a slice may say of itself."""

    notes = ("it was made by hand",)
    box = (-4.0, -4.0, -4.0), (4, 4, 4)

    def least_diameter(self, x):
        return 0.1


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (
            {"gradient": lambda self, x: np.moveaxis(self.hole.gradient(x), 1, 3)},
            r"order is \[point, k, i, j\]",
        ),
        (
            {"gradient": lambda self, x: 1.01 * self.hole.gradient(x)},
            r"gamma_\w\w at .* by Wrong.gradient and .* by differences of its metric$",
        ),
        (
            {"gradient": lambda self, x: self.hole.gradient(x)[:, 0]},
            r"Wrong.gradient returns .* of shape \(\d+, 3, 3\)",
        ),
        ({"metric": lambda self, x: np.ones(len(x))}, r"Wrong.metric returns an array of shape \(\d+,\) for"),
        (
            {"extrinsic_curvature": lambda self, x: 0.0},
            r"extrinsic_curvature returns an array of shape \(\) for",
        ),
        ({"time_symmetric": True}, "time_symmetric is True, but its extrinsic curvature is not zero"),
    ],
)
def test_members_that_do_not_fit_one_another_are_refused(wrong, sentence):
    slice_ = type("Wrong", (Own,), wrong)()
    with pytest.raises(InvalidParameter, match=sentence):
        StarSurface.sphere((0.0, 0.0, 0.0), 3.0).data(slice_)


def test_slices_of_other_packages():
    horizon = find_horizon(Own(), StarSurface.sphere((0.0, 0.0, 0.0), 2.5))
    assert horizon.area == pytest.approx(8 * np.pi * Own().hole.horizon, rel=1e-10)
    assert horizon.data().notes == ()
    with pytest.raises(InvalidParameter, match="does not specify the positions of its black holes"):
        find_horizon(Own())
    boxed = find_horizon(Boxed())
    assert boxed.area == pytest.approx(horizon.area, rel=1e-10)
    assert Boxed.notes[0] in boxed.data().notes


def test_what_is_not_derived_is_refused():
    class Alike:
        metric = gradient = extrinsic_curvature = error = lambda x: x

    with pytest.raises(InvalidParameter, match=r"is a Alike, not a ThreeGeometry: derive its class from"):
        StarSurface.sphere((0.0, 0.0, 0.0), 2.5).data(Alike())


@pytest.mark.parametrize("name", GEOMETRIES)
def test_gradients_are_those_of_differences(name):
    geometry, x = GEOMETRIES[name](1.0), outside()
    differences = CallableGeometry(geometry.metric, length=1.0)
    np.testing.assert_allclose(geometry.gradient(x), differences.gradient(x), atol=5e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
@given(exponent=st.integers(-150, 150))
def test_units_are_free(name, exponent):
    unit, x = 10.0**exponent, outside(3)
    one, other = GEOMETRIES[name](1.0), GEOMETRIES[name](unit)
    np.testing.assert_allclose(other.metric(unit * x), one.metric(x), atol=1e-14)
    np.testing.assert_allclose(other.gradient(unit * x) * unit, one.gradient(x), atol=1e-14)
    np.testing.assert_allclose(
        other.extrinsic_curvature(unit * x) * unit, one.extrinsic_curvature(x), atol=1e-14
    )


def test_callables_differentiated_either_way():
    hole, x = IsotropicSchwarzschild(1.3), outside()
    exact = AnalyticCallable(hole.metric)
    np.testing.assert_array_equal(exact.gradient(x), hole.gradient(x))
    assert exact.time_symmetric
    assert not exact.extrinsic_curvature(x).any()
    moving = PainleveGullstrand(1.3)
    for geometry in (
        AnalyticCallable(hole.metric, moving.extrinsic_curvature),
        CallableGeometry(hole.metric, 1.0, moving.extrinsic_curvature),
    ):
        assert not geometry.time_symmetric
        np.testing.assert_array_equal(geometry.extrinsic_curvature(x), moving.extrinsic_curvature(x))


def test_differences_are_of_sixth_order():
    hole, x = IsotropicSchwarzschild(1.0), np.array([[0.9, 0.3, -0.5]])
    errors = [
        np.abs(CallableGeometry(hole.metric, L).gradient(x) - hole.gradient(x)).max() for L in (24, 12, 6)
    ]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 5.8), orders


@pytest.mark.parametrize("name", GEOMETRIES)
def test_closed_forms_have_no_error(name):
    hole, x = GEOMETRIES[name](1.0), outside()
    for geometry in (hole, AnalyticCallable(hole.metric)):
        assert not geometry.error(lambda slice_: slice_.metric(x).reshape(len(x), 9).T).any()


@pytest.mark.parametrize("unit", [1e-80, 1.0, 1e80])
@pytest.mark.parametrize(("length", "noise"), [(1, 0.0), (6, 0.0), (24, 0.0), (1, 1e-10), (0.01, 0.0)])
def test_differences_tell_their_error(length, noise, unit):
    hole, x = IsotropicSchwarzschild(unit), outside(200, 0.9, 1.0) * unit

    rng = np.random.default_rng(1)

    def gamma(x):
        return hole.metric(x) * (1.0 + noise * rng.normal(size=len(x)))[:, None, None]

    user = CallableGeometry(gamma, length * unit)
    true = np.abs(user.gradient(x) - hole.gradient(x)).max()
    error = user.error(lambda slice_: slice_.gradient(x).reshape(len(x), 27).T)
    assert error.shape == (27, len(x))
    assert 0.05 * true < np.abs(error).max() < 20.0 * true


def test_kerr_schild_without_spin_in_closed_form():
    M, x = 1.3, outside(least=0.5)
    r = np.linalg.norm(x, axis=1)[:, None, None]
    n = x[:, :, None] / r
    K = 2 * M / r**2 / np.sqrt(1 + 2 * M / r) * (np.eye(3) - (2 + M / r) * n * n.transpose(0, 2, 1))
    np.testing.assert_allclose(KerrSchild(M, (0, 0, 0)).extrinsic_curvature(x), K, rtol=1e-12, atol=1e-13)


def test_the_curvature_of_kerr_schild_takes_the_null_form_once_and_its_three_derivatives(monkeypatch):
    x, calls, null_form = np.array([[3.0, -1.0, 2.0]]), [], KerrSchild._null_form
    monkeypatch.setattr(KerrSchild, "_null_form", lambda hole, x: calls.append(x) or null_form(hole, x))
    KerrSchild(1.0, SPIN).extrinsic_curvature(x)
    assert len(calls) == 4


@pytest.mark.parametrize("r", [1e-6, 0.1, 0.9, 1.5, 4.0])
@pytest.mark.parametrize("cos", [1.0, 0.7, -0.01])
def test_kerr_schild_in_spheroidal_coordinates(r, cos):
    M, a = 1.0, 0.9
    sin = np.sqrt(1 - cos**2)
    x = np.array([[np.sqrt(r**2 + a**2) * sin * 0.6, np.sqrt(r**2 + a**2) * sin * 0.8, r * cos]])
    hole = KerrSchild(M, (0, 0, a))
    H = M * r / (r**2 + (a * cos) ** 2)
    l = [(r * x[0, 0] + a * x[0, 1]) / (r**2 + a**2), (r * x[0, 1] - a * x[0, 0]) / (r**2 + a**2), cos]
    np.testing.assert_allclose(hole.metric(x)[0], np.eye(3) + 2 * H * np.outer(l, l), rtol=1e-10, atol=1e-14)
    assert np.isfinite(hole.extrinsic_curvature(x)).all()


def test_boyer_lindquist_is_the_line_element_in_angles():
    M, a = 1.0, 0.7
    theta, phi, r = 0.8, 2.1, 2.9
    x = r * np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    e = np.array(
        [
            x / r,
            r * np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)]),
            [-x[1], x[0], 0.0],
        ]
    )
    Sigma = r**2 + a**2 * np.cos(theta) ** 2
    pp = (r**2 + a**2 + 2 * M * r * a**2 / Sigma * np.sin(theta) ** 2) * np.sin(theta) ** 2
    expected = np.diag([Sigma / (r**2 - 2 * M * r + a**2), Sigma, pp])
    np.testing.assert_allclose(
        e @ BoyerLindquist(M, (0, 0, a)).metric(x[None])[0] @ e.T, expected, atol=1e-13
    )


def test_extrinsic_curvature_of_boyer_lindquist_from_lapse_and_shift():
    hole, x, a = BoyerLindquist(1.0, SPIN), outside(least=2.5), np.array(SPIN)

    def sigma_and_spread(x):
        r = np.sqrt((x * x).sum(axis=1))
        Sigma = r**2 + (x @ a / r) ** 2
        return r, Sigma, (r**2 + a @ a) ** 2 - (r**2 - 2 * r + a @ a) * (r**2 + a @ a - Sigma)

    def shift(x):
        r, _, spread = sigma_and_spread(x)
        return np.einsum("nij,nj->ni", hole.metric(x), -(2 * r / spread)[:, None] * np.cross(a, x))

    r, Sigma, spread = sigma_and_spread(x)
    lapse = np.sqrt((r**2 - 2 * r + a @ a) * Sigma / spread)
    K = stationary_curvature(hole.gradient(x), hole.metric(x), lapse, shift(x), complex_step(shift, x))
    np.testing.assert_allclose(hole.extrinsic_curvature(x), K, atol=1e-14)


def test_painleve_gullstrand_from_lapse_and_shift():
    hole, x = PainleveGullstrand(1.3), outside()

    def shift(x):
        return np.sqrt(2.6) * x / (x * x).sum(axis=1)[:, None] ** 0.75

    K = stationary_curvature(
        hole.gradient(x), hole.metric(x), np.ones(len(x)), shift(x), complex_step(shift, x)
    )
    np.testing.assert_allclose(hole.extrinsic_curvature(x), K, atol=1e-14)


def test_brill_and_lindquists_single_hole():
    x, position = outside(), np.array([1.0, 2.0, 3.0])
    single = BrillLindquist([1.3], [position])
    np.testing.assert_allclose(single.metric(x + position), IsotropicSchwarzschild(1.3).metric(x), rtol=1e-14)


def test_horizons_radius():
    assert KerrSchild(2.0, (0, 0, 1.2)).horizon == pytest.approx(3.6, rel=1e-15)
    assert BoyerLindquist(2.0, (1.2, 0, 0)).horizon == pytest.approx(3.6, rel=1e-15)
    assert BoyerLindquist(1.0, (0, 1.0, 0)).horizon == 1.0


X = np.array([[3.0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: KerrSchild(-1.0, (0, 0, 0)), "the mass must be positive, not -1.0"),
        (lambda: PainleveGullstrand(np.nan), "the mass must be positive, not nan"),
        (lambda: IsotropicSchwarzschild(0.0), "the mass must be positive, not 0.0"),
        (lambda: IsotropicSchwarzschild("heavy"), "the mass must be positive, not heavy"),
        (lambda: IsotropicSchwarzschild([1.0]), r"the mass must be positive, not \[1.0\]"),
        (lambda: KerrSchild(1.0, (0, 1)), r"the spin must be three finite numbers, not \(0, 1\)"),
        (lambda: BoyerLindquist(1.0, (0, 0, np.inf)), "the spin must be three finite numbers"),
        (lambda: BoyerLindquist(1.0, (0, 0.6, 0.9)), "no horizon: the spin 1.08167 exceeds the mass 1"),
        (lambda: KerrSchild(1.0, (0, 0, 1.1)).horizon, "no horizon: the spin 1.1 exceeds the mass 1"),
        (lambda: KerrSchild(1.0, SPIN).spheroid(0.0), "the radius must be positive, not 0.0"),
        (lambda: BrillLindquist([1.0], []), "1 masses at 0 positions"),
        (lambda: BrillLindquist([], []), "0 masses at 0 positions"),
        (lambda: BrillLindquist([1.0, -2.0], X), "mass 1 must be positive, not -2.0"),
        (lambda: BrillLindquist([1.0], [(0, 0)]), "position 0 must be three finite numbers"),
        (
            lambda: CallableGeometry(lambda x: x, 0.0),
            "the length over which the metric varies must be positive",
        ),
        (
            lambda: CallableGeometry(lambda x: x, 1.0).metric(X),
            r"metric returns the shape \(2, 3\) for 2 points",
        ),
        (
            lambda: AnalyticCallable(lambda x: x, lambda x: 0).extrinsic_curvature(X),
            r"for K_ij returns the shape",
        ),
        (lambda: AnalyticCallable(None), "gamma is a NoneType, not a function"),
        (lambda: AnalyticCallable(lambda x: x, 0), r"K is a int, not a function of x \(n, 3\)"),
        (lambda: CallableGeometry(1.0, lambda x: x), "gamma is a float, not a function"),
        (
            lambda: AnalyticCallable(lambda x: math.sqrt(x[:, 0])).metric(X + 0j),
            "the function for the metric raises TypeError: .* use np.sin instead of math.sin",
        ),
        (
            lambda: AnalyticCallable(lambda x: np.eye(3) / np.sqrt(x @ x)).metric(X),
            r"for the metric raises ValueError: matmul.* many points at once, here of shape \(2, 3\)",
        ),
        (
            lambda: CallableGeometry(lambda x, y, z: np.eye(3), 1.0).metric(X),
            r"missing 2 required positional .*: use np.sin .*, and x\[:, 0\] for x of shape \(n, 3\)",
        ),
        (
            lambda: CallableGeometry(lambda x: 1j * np.ones((len(x), 3, 3)), 1.0).metric(X),
            "the function for the metric has complex values, not real numbers",
        ),
        (
            lambda: AnalyticCallable(len, lambda x: 1j * np.ones((len(x), 3, 3))).extrinsic_curvature(X),
            "the function for K_ij has complex values",
        ),
        (lambda: BoyerLindquist(1.0, SPIN).metric(X / 2), r"point 0, \(1.5, 0, 0\), does not lie outside"),
        (lambda: KerrSchild(1.0, (0, 0, 0.5)).metric(X), r"point 1, \(0, 0, 0\), lies on the disk"),
        (lambda: KerrSchild(1.0, (0, 0, 0.5)).metric(X / 10), r"point 0, \(0.3, 0, 0\), lies on the disk"),
        (lambda: BrillLindquist([1.0], [(3, 0, 0)]).metric(X), r"point 0, \(3, 0, 0\), is a puncture"),
        (lambda: PainleveGullstrand(1.0).extrinsic_curvature(X), r"point 1, \(0, 0, 0\), is the singularity"),
    ],
)
def test_refusals(make, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        make()


@pytest.mark.parametrize("bad", [np.diag([1.0, 1, -1]), np.diag([1.0, -1, -1]), np.full((3, 3), np.nan)])
def test_what_is_no_metric(bad):
    gamma = np.stack([np.eye(3), bad])
    with pytest.raises(
        InvalidMetric, match=r"the 3-metric at \(0, 0, 0\) is not positive definite: xx, xy, "
    ):
        check_slice("the 3-metric", X, gamma)
    check_slice("the 3-metric", X[:1], gamma[:1])


def sheared(xy, yx):
    """A constant tensor that is symmetric if its entries xy and yx are equal."""
    return np.array([[1.0, xy, 0.0], [yx, 1.0, 0.0], [0.0, 0.0, 1.0]])


def test_tensors_that_are_not_symmetric_are_refused():
    sphere = StarSurface.sphere((0.0, 0.0, 0.0), 1.0)

    def slice_of(gamma, K=None):
        def conformal(x):
            return ((1.0 + 0.5 / np.sqrt((x**2).sum(axis=1))) ** 4)[:, None, None] * gamma

        return AnalyticCallable(conformal, K and (lambda x: K * np.ones((len(x), 1, 1)) * sheared(0.2, 0.0)))

    with pytest.raises(
        InvalidMetric, match=r"3-metric at .* is not symmetric: its entry xy is .*, and yx is 0"
    ):
        find_horizon(slice_of(sheared(0.2, 0.0)), sphere)
    for K in (0.01, 1e-6):
        with pytest.raises(InvalidMetric, match=r"the extrinsic curvature at .* is not symmetric"):
            sphere.data(slice_of(np.eye(3), K))
    sphere.data(slice_of(sheared(0.2, 0.2)))
    sphere.data(slice_of(np.eye(3), 1e-15))  # rounding of what vanishes
