"""Newton's and the Gauss-Newton method: rates on closed-form problems, and every reason to stop."""

from itertools import pairwise

import numpy as np
import pytest

from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import LineSearch, contraction
from isoembed.nonlinear.descent import Reason
from isoembed.nonlinear.newton import newton
from isoembed.nonlinear.stopping import below, never, short_step, stagnated


def circle_and_line(x):
    """Zero at (1, 1) / sqrt 2 and its opposite."""
    return np.array([x @ x - 1.0, x[0] - x[1]])


def inverted(x, r):
    return np.linalg.solve(np.array([2.0 * x, [1.0, -1.0]]), r)


def watched(residual):
    """A residual and the list of its norms."""
    norms = []

    def evaluated(x):
        r = residual(x)
        norms.append(float(np.abs(r).max()))
        return r

    return evaluated, norms


def test_newtons_method_is_quadratic():
    residual, norms = watched(circle_and_line)
    found = newton(np.array([2.0, 1.0]), residual, inverted, converged=below(1e-15), max_iterations=20)
    assert found.converged
    assert found.point.x == pytest.approx(np.full(2, np.sqrt(0.5)), abs=1e-15)
    assert found.iterations == len(norms) - 1 <= 7
    rates = [np.log(after) / np.log(before) for before, after in pairwise(norms) if 1e-15 < after < 0.1]
    assert len(rates) > 1
    assert min(rates) > 1.9


def test_gauss_newton_is_linear_with_the_ratio_of_the_closed_form():
    # r = (x - 1, a (x + 1)^2 / 2 + c): with f' = (1, a (x + 1)) the error falls by the share of the second
    # derivative that is left out, a r_2 / |f'|^2, at the minimum.
    a, c = 0.3, 1.0

    def residual(x):
        return np.array([x[0] - 1.0, a * (x[0] + 1.0) ** 2 / 2 + c])

    def solve(x, r):
        J = np.array([1.0, a * (x[0] + 1.0)])
        return np.array([J @ r / (J @ J)])

    points = []

    def followed(x, r):
        points.append(x[0])
        return solve(x, r)

    found = newton(np.array([1.0]), residual, followed, converged=short_step(1e-14), max_iterations=200)
    x = found.point.x[0]
    assert found.converged
    assert x - 1.0 + a * (x + 1.0) * residual(np.array([x]))[1] == pytest.approx(0.0, abs=1e-13)  # gradient
    expected = -a * residual(np.array([x]))[1] / (1.0 + (a * (x + 1.0)) ** 2)
    errors = np.array(points) - x
    assert errors[6] / errors[5] == pytest.approx(expected, rel=1e-2)


def arctangent(x):
    return np.arctan(x)


def step_on_arctangent(x, r):
    return r * (1.0 + x**2)


def test_whole_steps_go_astray_where_a_line_search_arrives():
    start = np.array([3.0])
    free = newton(start, arctangent, step_on_arctangent, converged=below(1e-14), max_iterations=5)
    assert free.reason is Reason.EXHAUSTED
    assert abs(free.point.x[0]) > abs(start[0])
    assert free.best.x is start
    assert free.best_value == np.arctan(3.0) < free.value
    search = LineSearch(decrease=0.1, shortest=1e-3)
    found = newton(start, arctangent, step_on_arctangent, search, converged=below(1e-14), max_iterations=20)
    assert found.converged
    assert found.best is found.point


def test_rules_compare_with_the_least_value_before():
    seen = []

    def noted(point, value, before):
        seen.append((value, before))
        return False

    newton(np.array([3.0]), arctangent, step_on_arctangent, converged=noted, max_iterations=3)
    values = [value for value, _ in seen]
    assert values == sorted(values)
    assert [before for _, before in seen] == [np.inf, *[values[0]] * 3]


def test_contraction_ends_where_the_residual_is_not_halved():
    # Newton's steps to a double root leave a quarter of x^2 each.
    def solve(x, r):
        return r / (2.0 * x)

    start, options = np.array([1.0]), {"converged": never, "max_iterations": 10}
    assert newton(start, np.square, solve, contraction(0.3), **options).iterations == 10
    found = newton(start, np.square, solve, contraction(0.2), **options)
    assert (found.reason, found.iterations, found.point.x) == (Reason.REJECTED, 0, start)


def test_stagnation_at_rounding():
    # The root of 2 is no float: from some step on the residual does not fall.
    def residual(x):
        return x**2 - 2.0

    found = newton(
        np.array([1.5]),
        residual,
        lambda x, r: r / (2.0 * x),
        converged=below(0.0),
        stalled=stagnated(1e-9),
        max_iterations=50,
    )
    assert found.reason is Reason.STALLED
    assert found.best_value <= 4.5e-16
    assert found.iterations < 8


def test_a_singular_matrix_ends_it():
    def solve(x, r):
        raise SingularMatrix("nothing")

    start = np.array([1.0])
    found = newton(start, np.square, solve, converged=never, max_iterations=5)
    assert (found.reason, found.iterations) == (Reason.SINGULAR, 0)
    assert found.point.x is start


def test_numbers_that_are_none_are_not_accepted():
    with np.errstate(invalid="ignore"):
        found = newton(
            np.array([1.0]), np.sqrt, lambda x, r: np.array([2.0]), converged=never, max_iterations=5
        )
    assert found.reason is Reason.REJECTED
    assert found.point.x == 1.0


def test_a_start_that_is_good_enough_is_returned_unsolved():
    start = np.array([0.0])
    found = newton(start, np.square, None, converged=below(0.0), max_iterations=5)
    assert found.converged
    assert found.iterations == 0
    assert found.point.x is start
