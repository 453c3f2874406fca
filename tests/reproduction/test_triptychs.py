"""Triptychs: smooth in the middle, crumpled on the right."""

import numpy as np
import pytest

from isoembed import Embedding, Paper, PolyhedralMetric
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.metric.curvature import negative_deficits
from reproduction import triptychs


@pytest.mark.parametrize(
    ("surface", "method"), [(Ellipsoid(), Paper()), (Drum(), "aim")], ids=("ellipsoid", "drum")
)
def test_a_triptych_is_smooth_in_the_middle_and_crumpled_on_the_right(surface, method):
    one = triptychs.triptych(surface, 300, method)
    exact, smooth, crumpled = one.panels.values()
    assert smooth.converged
    assert smooth.distance(exact) < 1e-4
    assert not smooth.surface.rough_edges.any()
    metric, x = exact.metric, crumpled.vertices
    lengths = np.linalg.norm(x[metric.edges[:, 0]] - x[metric.edges[:, 1]], axis=1)
    assert np.abs(lengths - metric.lengths).max() < 1e-6 * metric.mean_length
    assert crumpled.surface.rough_edges.mean() >= triptychs.CRUMPLED
    assert (crumpled.surface.inverted_vertices | crumpled.surface.partially_inverted_vertices).any()
    assert crumpled.distance(exact) > 0.1
    assert one.attempts[-1].succeeded
    assert not any(attempt.succeeded for attempt in one.attempts[:-1])


def test_a_push_leaves_what_is_near_negative_curvature(monkeypatch):
    monkeypatch.setattr(triptychs, "ITERATIONS", 0)  # do not anneal
    points, faces = triangulate(Ergosphere(), 400)
    metric = PolyhedralMetric.from_mesh(points, faces)
    smooth = Embedding(metric, points, method="exact", tolerance=1)
    pushed = np.linalg.norm(triptychs.kicked(smooth, 0.3).vertices - points, axis=1) / metric.mean_length
    held = negative_deficits(metric)
    near = held | (metric.triangulation.adjacency @ held > 0)  # sqrt(400) / 10 is 2 edges
    near = near | (metric.triangulation.adjacency @ near > 0)
    assert pushed[near].max() < 1e-12
    assert np.sqrt(np.mean(pushed[~near] ** 2)) == pytest.approx(0.3, rel=0.15)
