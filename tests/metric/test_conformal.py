"""Conformal change of a metric by factors at the vertices."""

import numpy as np
import pytest

import zoo
from isoembed.errors import InvalidMetric
from isoembed.metric.conformal import rescaled
from isoembed.metric.polyhedral import PolyhedralMetric


def test_every_edge_takes_the_mean_of_the_factors_at_its_ends():
    metric = PolyhedralMetric.from_mesh(*zoo.icosphere(1))
    u = np.random.default_rng(1).uniform(-0.01, 0.01, 42)
    changed = rescaled(metric, u)
    for (a, b), before, after in zip(metric.edges, metric.lengths, changed.lengths, strict=True):
        assert after == pytest.approx(before * (np.exp(u[a]) + np.exp(u[b])) / 2, rel=1e-15)
    assert changed.triangulation is metric.triangulation


def test_a_constant_factor_is_a_change_of_unit():
    metric = PolyhedralMetric.from_mesh(*zoo.icosphere(1))
    assert rescaled(metric, np.full(42, np.log(3.0))).lengths == pytest.approx(3 * metric.lengths, rel=1e-15)


def test_factors_that_break_a_triangle_are_refused():
    metric = PolyhedralMetric(zoo.TETRAHEDRON, np.ones(6))
    # A side keeps more than half of its length, so that equilateral triangles stand anything at one vertex.
    assert rescaled(metric, np.array([-20.0, 0, 0, 0])).lengths.min() == pytest.approx(0.5)
    thin = metric.with_lengths([1, 1, 1, 1.9, 1.9, 1.9])  # the edges at vertex 0 first
    with pytest.raises(InvalidMetric, match=r"face \d \[.*\] breaks the triangle inequality"):
        rescaled(thin, np.array([-1.0, 0, 0, 0]))
