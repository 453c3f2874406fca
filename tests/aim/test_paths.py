"""The families of conformal factors on the way back: times and factors of the three paths."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed.aim.paths import path_factors, path_times
from isoembed.aim.uniformize import Uniformization, ricci_flow
from isoembed.metric.polyhedral import PolyhedralMetric

HISTORY = np.array([[0.0, 0, 0, 0], [2, 1, 0, -1], [3, 1, 0, -2], [3.5, 1, 0, -2.5], [3.7, 1, 0, -2.7]])
UNIFORM = Uniformization(
    HISTORY[-1], PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6), HISTORY, 0.0, True
)


@pytest.mark.parametrize("steps", [1, 2, 7])
@pytest.mark.parametrize("path", ["linear", "exponential", "flow"])
def test_times_fall_from_one_to_zero(path, steps):
    times = path_times(path, steps, 0.3)
    assert times.shape == (steps + 1,)
    assert times[0] == pytest.approx(1, abs=1e-15)
    assert times[-1] == pytest.approx(0, abs=1e-15)
    assert (np.diff(times) < 0).all()


def test_linear_times_are_equidistant():
    assert path_times("linear", 4, 9.0) == pytest.approx([1, 0.75, 0.5, 0.25, 0])
    assert path_times("flow", 4, 9.0) == pytest.approx([1, 0.75, 0.5, 0.25, 0])


def test_exponential_times_are_the_papers():
    alpha, steps = 0.7, 5
    times = path_times("exponential", steps, alpha)
    for j in range(steps + 1):
        wanted = (np.exp(-alpha * steps) - np.exp(-alpha * j)) / (np.exp(-alpha * steps) - 1)
        assert times[j] == pytest.approx(wanted, abs=1e-15)
    gaps = -np.diff(times)
    assert gaps[1:] / gaps[:-1] == pytest.approx(np.exp(-alpha), rel=1e-12)
    assert path_times("exponential", 5, 1e-6) == pytest.approx(path_times("linear", 5, 1.0), abs=1e-5)


def test_there_is_no_such_path():
    with pytest.raises(ValueError, match="no path 'straight'; there are linear, exponential and flow"):
        path_times("straight", 3, 1.0)


@pytest.mark.parametrize("path", ["linear", "exponential"])
@pytest.mark.parametrize("t", [0.0, 0.3, 1.0])
def test_factors_are_linear_in_time(path, t):
    assert path_factors(path, UNIFORM, t) == pytest.approx(t * HISTORY[-1], abs=1e-15)


def test_the_flows_path_runs_through_its_history():
    for k in range(5):
        assert path_factors("flow", UNIFORM, k / 4) == pytest.approx(HISTORY[k], abs=1e-15)
    assert path_factors("flow", UNIFORM, 0.3) == pytest.approx(0.8 * HISTORY[1] + 0.2 * HISTORY[2], abs=1e-15)
    still = Uniformization(HISTORY[0], UNIFORM.metric, HISTORY[:1], 0.0, True)
    assert (path_factors("flow", still, 0.4) == 0).all()


def test_the_flows_path_ends_at_the_given_and_at_the_uniform_metric():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices * [1.3, 1, 1], faces).normalized
    flow = ricci_flow(metric, smooth_bodies.recorder(), integrator="BDF", epsilon=0.03, t_f=100.0)
    assert (path_factors("flow", flow, 0.0) == 0).all()
    assert path_factors("flow", flow, 1.0) == pytest.approx(flow.u, abs=1e-15)
    # Most of the change is in the first steps of the flow, unlike on the linear path.
    half = path_factors("flow", flow, 0.5)
    assert np.linalg.norm(half - flow.u / 2) > 1e-3 * np.linalg.norm(flow.u)
