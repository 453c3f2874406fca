"""Triangles that errors of the lengths have flattened."""

import numpy as np
import pytest

import zoo
from isoembed import InvalidMetric, MeshNote, PolyhedralMetric, embed
from isoembed.metric.triangle_checks import within_inequalities
from isoembed.surface.alignment import distance

SIDES = np.array([[0, 1, 2]])


def test_the_nearest_lengths_with_an_area():
    """Equal errors share the excess in thirds; a side without error keeps its length."""
    errors = np.full(3, 0.3)
    found = within_inequalities(SIDES, np.array([4.0, 13.0, 17.0]), errors)
    assert found == pytest.approx([4.1, 13.1, 16.9], abs=1e-12)
    found = within_inequalities(SIDES, np.array([4.0, 13.0, 17.1]), np.array([0.3, 1e-9, 0.3]))
    assert found == pytest.approx([4.2, 13.0, 16.9], abs=1e-6)


def test_a_length_that_is_hardly_known_stays_within_the_others():
    found = within_inequalities(SIDES, np.array([20.0, 22.0, 200.0]), np.array([0.29, 0.29, 200.0]))
    assert found == pytest.approx([20, 22, 32], abs=1e-3)
    found = within_inequalities(SIDES, np.array([1.0, 10.0, 11.5]), np.array([0.001, 0.001, 2.0]))
    assert found == pytest.approx([1, 10, 10.5], abs=1e-3)


def test_what_is_too_large_for_its_space_is_not_explained_by_rounding():
    points, faces = zoo.random_hull(60, 6)
    exact = PolyhedralMetric.from_mesh(100 * points, faces)
    with pytest.raises(InvalidMetric, match="sphere") as caught:
        PolyhedralMetric(exact.faces, np.round(exact.lengths, 1), exact.edges, curvature=1 / 30**2)
    assert "rounding" not in str(caught.value)


def test_lengths_that_errors_do_not_explain_are_kept():
    lengths = np.array([4.0, 13.0, 25.0])
    assert within_inequalities(SIDES, lengths, np.full(3, 0.3)) is lengths
    with pytest.raises(InvalidMetric, match=r"its sides are 4\.0, 13\.0 and 25\.0$"):
        PolyhedralMetric([[0, 1, 2], [0, 2, 1]], lengths, length_errors=0.3)


def thin():
    """A hull with a triangle that is flat in whole units."""
    points, faces = zoo.random_hull(60, 6)
    points = 100.0 * points
    a, b, c = faces[0]
    inside = 0.5 * (points[a] + points[b]) + 0.001 * (points[c] - points[a])
    v = len(points)
    return np.vstack([points, inside]), np.vstack([faces[1:], [[a, b, v], [b, c, v], [c, a, v]]])


def test_a_metric_whose_rounded_triangles_are_flat():
    points, faces = thin()
    exact = PolyhedralMetric.from_mesh(points, faces)
    lengths = np.round(exact.lengths)
    advice = r"breaks the triangle inequality.*; rounding explains it: give 0\.29 as the standard deviation"
    with pytest.raises(InvalidMetric, match=advice):
        PolyhedralMetric(exact.faces, lengths, exact.edges)
    with pytest.warns(MeshNote, match="lengths are changed within their errors, so that no triangle"):
        metric = PolyhedralMetric(exact.faces, lengths, exact.edges, length_errors=12**-0.5)
    assert np.abs(metric.lengths - lengths).max() < 4 * 12**-0.5
    found = embed(metric)
    assert distance(found.vertices, points) < 5.0
