"""Derivatives of functions that users give, compared with differences."""

import re

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import embed_surface, find_horizon, find_horizons
from isoembed.relativity.spacetimes.differences import EIGHTH, SIXTH, central_differences
from isoembed.relativity.spacetimes.schwarzschild import BrillLindquist, Superposed
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable, CallableGeometry
from isoembed.relativity.spacetimes.transformed import Translated

SPHERE = StarSurface.sphere((0, 0, 0), 2.0)
X = 2.0 * fibonacci_directions(50)


def isotropic(r):
    return ((1.0 + 0.5 / r) ** 4)[:, None, None] * np.eye(3)


def root(x):
    return np.sqrt((x**2).sum(axis=1))


def by_norm(x):
    return isotropic(np.linalg.norm(x, axis=1))


def by_abs(x):
    return isotropic(root(np.abs(x)))


def by_real(x):
    return isotropic(root(np.real(x)))


def filled(x):
    out = np.zeros((len(x), 3, 3))
    out[:] = isotropic(root(x))
    return out


def far_hole_by_norm(x):
    """Two holes, the radius of the far one a norm: the energy is off in the third digit."""
    psi = 1.0 + 0.5 / root(x) + 0.5 / np.linalg.norm(x - np.array([0.0, 0.0, 30.0]), axis=1)
    return (psi**4)[:, None, None] * np.eye(3)


def one_component(x):
    """A small component that is not differentiable for complex x."""
    gamma = isotropic(root(x))
    gamma[:, 1, 2] = gamma[:, 2, 1] = 1e-4 * np.real(x[:, 0])
    return gamma


@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")  # of the function `filled`
@pytest.mark.parametrize("gamma", [by_norm, by_abs, by_real, filled, far_hole_by_norm])
def test_functions_that_drop_the_imaginary_part_are_refused(gamma):
    sentence = (
        r"d_[xyz] gamma_(xx|yy|zz) at \(.*\) is .* by the complex step and .* by differences: .*"
        r"Write np.sqrt\(\(x\*\*2\).sum\(axis=1\)\)"
    )
    with pytest.raises(InvalidParameter, match=sentence):
        AnalyticCallable(gamma).gradient(X)
    with pytest.raises(InvalidParameter, match=sentence):
        find_horizon(AnalyticCallable(gamma), SPHERE)
    with pytest.raises(InvalidParameter, match=sentence):
        embed_surface(SPHERE.data(AnalyticCallable(gamma))).energies  # noqa: B018 - it is computed


def test_the_component_is_named():
    with pytest.raises(InvalidParameter, match=r"d_x gamma_yz at \(.*\) is 0 by .* and 0\.0001 by diff"):
        AnalyticCallable(one_component).gradient(X)


def test_superposed_functions_are_compared_too():
    alone = AnalyticCallable(by_norm)
    with pytest.raises(InvalidParameter, match="by the complex step"):
        Superposed((alone, Translated(AnalyticCallable(clean), (0.0, 0.0, 9.0)))).gradient(X)


@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e150])
@pytest.mark.parametrize("center", [(0.0, 0.0, 0.0), (0.0, 0.0, 1e5), (1e9, 0.0, 0.0)])
def test_holomorphic_functions_are_taken_in_every_unit_and_place(unit, center):
    hole = BrillLindquist((unit,), (np.array(center) * unit,))
    x = unit * (np.array(center) + X)
    given = AnalyticCallable(hole.metric).gradient(x)
    np.testing.assert_array_equal(given, hole.gradient(x))
    faint = AnalyticCallable(lambda x: np.eye(3) * (1.0 + 1e-13 * root(x / unit))[:, None, None])
    faint.gradient(x)
    AnalyticCallable(lambda x: np.broadcast_to(np.eye(3), (len(x), 3, 3))).gradient(x)
    CallableGeometry(hole.metric, 2.0 * unit).gradient(x)


@pytest.mark.parametrize("length", [100.0, 300.0, 1000.0, 1e12])
def test_too_large_a_length_is_refused(length):
    with pytest.raises(
        InvalidParameter, match=f"the length {re.escape(f'{length:.6g}')} and .*: give the dist"
    ):
        embed_surface(SPHERE.data(CallableGeometry(by_norm, length)))


@pytest.mark.parametrize("length", [0.2, 2.0, 50.0])
def test_errors_of_other_lengths_hold(length):
    found = embed_surface(SPHERE.data(CallableGeometry(by_norm, length))).energies.brown_york
    assert abs(found.value - 1.25) < found.error < 1e-4


def test_noise_is_no_wrong_length():
    def noisy(x):
        return by_norm(x) * (1.0 + 1e-4 * np.sin(1e7 * x[:, :1, None]))

    for length in (0.2, 2.0, 20.0):
        error = np.abs(
            CallableGeometry(noisy, length).gradient(X) - AnalyticCallable(clean).gradient(X)
        ).max()
        assert 1e-4 < error < 1.0


def clean(x):
    return isotropic(root(x))


def test_differences_have_their_orders():
    exact = AnalyticCallable(clean).gradient(X)
    for weights, order in ((SIXTH, 6), (EIGHTH, 8)):
        coarse, fine = (
            np.abs(central_differences(clean, X, step, weights) - exact).max() for step in (0.1, 0.05)
        )
        assert coarse / fine == pytest.approx(2.0**order, rel=0.1)


@pytest.mark.parametrize("find", [find_horizon, find_horizons])
def test_functions_need_a_guess(find):
    with pytest.raises(InvalidParameter, match=r"use find_horizon\(geometry, guess\) with a guess"):
        find(AnalyticCallable(clean))
