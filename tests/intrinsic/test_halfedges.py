"""Half-edge tables: their order in memory."""

import numpy as np

import zoo
from isoembed import GluedMetric, PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate


def shuffled(vertices, faces):
    label = np.random.default_rng(0).permutation(len(vertices))
    moved = np.empty_like(vertices)
    moved[label] = vertices
    return GluedMetric.of(PolyhedralMetric.from_mesh(moved, label[faces]))


def test_neighbors_are_near_in_memory_order():
    metric = shuffled(*triangulate(Ellipsoid((3, 2, 1)), 2000))
    tables = metric.half_edges()
    order = tables.order_in_memory()
    assert (np.sort(order) == np.arange(2000)).all()
    near = tables.in_order(order)
    i, j = near.ends
    assert np.abs(i - j).max() < 250 < 1500 < np.abs(tables.ends[0] - tables.ends[1]).max()
    assert (np.diff(near.faces.min(axis=1)) >= 0).all()


def test_the_same_metric_by_other_numbers():
    metric = shuffled(*zoo.random_hull(50, 2))
    tables = metric.half_edges(directed=False)
    order = tables.order_in_memory()
    other = GluedMetric.flipped(tables.in_order(order))
    checked = GluedMetric(other.faces, other.twins, other.face_lengths)
    np.testing.assert_allclose(checked.deficits, metric.deficits[order], atol=1e-14)
