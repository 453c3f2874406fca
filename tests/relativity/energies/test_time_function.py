"""Time functions: their values, gradients and metrics, and what is none."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity import TimeFunction
from isoembed.relativity.energies.time_function import TimeRaisedMetric
from spacelike import directions, round_sphere


def test_time_functions():
    tau, u = TimeFunction.of(lambda u: 2.0 * u[:, 2] + u[:, 0] * u[:, 1] + 7.0, 3), directions()
    np.testing.assert_allclose(tau.values(u), 2.0 * u[:, 2] + u[:, 0] * u[:, 1] + 7.0, atol=1e-13)
    slope = np.stack([u[:, 1], u[:, 0], np.full(len(u), 2.0)], axis=1)
    slope -= np.einsum("ni,ni->n", slope, u)[:, None] * u
    np.testing.assert_allclose(tau.gradient(u), slope, atol=1e-13)
    metric = round_sphere(4.0).metric
    raised = TimeRaisedMetric(metric, tau).tensor(u)
    np.testing.assert_allclose(raised, metric.tensor(u) + np.einsum("ni,nj->nij", slope, slope), atol=1e-12)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", raised, u), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda u: u, r"tau at \d+ directions has the shape \(\d+, 3\)"),
        (lambda u: 1.0, r"tau at \d+ directions has the shape \(\)"),
        (lambda u: np.where(u[:, 2] > 0.9, np.nan, 1.0), r"tau in the direction \(.*, 0.9\d+\) is nan"),
        (lambda u: np.abs(u[:, 2]), r"harmonics up to degree 16 have an error of 0.0\d+ for tau"),
    ],
)
def test_refuses_functions_without_values(function, message):
    with pytest.raises(InvalidParameter, match=message):
        TimeFunction.of(function)
