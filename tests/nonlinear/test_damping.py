"""Levenberg-Marquardt damping: minima, when it is raised and lowered, and what ends it."""

import numpy as np
import pytest

from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Reason, descend
from isoembed.nonlinear.newton import damped_step
from isoembed.nonlinear.stopping import never, settled


def rosenbrock(x):
    """Residual and Jacobian of the valley whose minimum is (1, 1)."""
    return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]), np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])


def value(x):
    r, _ = rosenbrock(x)
    return float(r @ r)


def step(x):
    r, J = rosenbrock(x)
    return lambda damping: x - damped_step(J.T @ J, J.T @ r, damping)


def descended(start, damping, **options):
    given = {"value": value, "converged": lambda x, value, before: value < 1e-28, "max_iterations": 100}
    return descend(np.array(start), step, damping, **given | options)


def test_a_curved_valley_is_followed_downhill():
    values = []

    def watched(x):
        values.append(value(x))
        return values[-1]

    found = descended([-1.2, 1.0], Damping(1.0), value=watched)
    assert found.converged
    assert found.point == pytest.approx([1.0, 1.0], abs=1e-13)
    assert len(values) > found.iterations + 1  # some steps led uphill
    assert found.value == min(values)


@pytest.mark.parametrize(
    ("damping", "following"),
    [(Damping(1.0), 0.2), (Damping(1.0, softer=0.5), 0.5), (Damping(1.0, eased_below=0.5), 1.0)],
)
def test_it_is_lowered_after_a_decrease(damping, following):
    assert damping.following(0.9, 1.0, 1.0) == following
    assert damping.following(0.4, 1.0, 1.0) == damping.softer


def test_it_is_raised_until_the_value_falls_or_no_more_is_allowed():
    tried = []

    def uphill(x):
        def curve(damping):
            tried.append(damping)
            return x + 1.0

        return curve

    options = {"value": float, "converged": never, "max_iterations": 5}
    assert descend(0.0, uphill, Damping(1.0, stiffer=10.0, largest=1e3), **options).reason is Reason.REJECTED
    assert tried == [1.0, 10.0, 100.0, 1000.0]
    tried.clear()
    found = descend(0.0, uphill, Damping(1.0, tries=2), **options)
    assert (found.point, found.reason, tried) == (0.0, Reason.REJECTED, [1.0, 5.0])


def test_singular_matrices_ask_for_more_damping():
    def curve_of(x):
        def curve(damping):
            if damping < 20.0:
                raise SingularMatrix("indefinite")
            return x / 2

        return curve

    found = descend(1.0, curve_of, Damping(1.0), value=abs, converged=never, max_iterations=1)
    assert found.point == 0.5
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        damped_step(np.diag([1.0, -2.0]), np.ones(2), 1.0)
    assert damped_step(np.diag([1.0, -2.0]), np.ones(2), 3.0) == pytest.approx([0.25, 1.0], rel=1e-15)


def test_nothing_is_tried_when_no_more_may_be_spent():
    trials = []

    def exhausted(x):
        trials.append(x)
        return len(trials) > 3

    found = descended([-1.2, 1.0], Damping(1.0), exhausted=exhausted)
    assert found.reason is Reason.EXHAUSTED
    assert len(trials) == 4
    assert found.value < value(np.array([-1.2, 1.0]))
    again = descended([-1.2, 1.0], Damping(1.0), max_trials=3)
    assert (again.reason, again.value) == (Reason.EXHAUSTED, found.value)


def test_a_step_that_gains_little_is_the_last():
    found = descended([-1.2, 1.0], Damping(1.0), converged=settled(0.5))
    assert found.converged
    before = descended([-1.2, 1.0], Damping(1.0), max_iterations=found.iterations - 1)
    assert found.value > 0.5 * before.value
    assert before.iterations == found.iterations - 1


def test_stalled_ends_it_as_told():
    found = descended([-1.2, 1.0], Damping(1.0), stalled=lambda x, value, before: value < 1.0)
    assert found.reason is Reason.STALLED
    assert found.value < 1.0
