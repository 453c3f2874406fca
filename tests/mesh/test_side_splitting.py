"""T-junctions: named, and mended on request by splitting the side at the vertex."""

import re

import numpy as np
import pytest

from isoembed import InvalidMetric, PolyhedralMetric
from isoembed.errors import MeshNote
from isoembed.metric.curvature import deficits

CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SQUARES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
# Vertices 8 and 9 on the side from 0 to 1: the third square has them, and the first does not.
POINTS = [*CUBE, [0, 0, 1 / 3], [0, 0, 0.6]]
OPEN = [*SQUARES[:2], [0, 4, 5, 1, 9, 8], *SQUARES[3:]]


def turned(points):
    """In general position, so that no vertex is on a side exactly."""
    q, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    return np.asarray(points) @ q.T


def test_it_is_named_and_the_advice_is_right():
    with pytest.raises(InvalidMetric, match="vertex 8 is on the side from vertex 0 to vertex 1") as e:
        PolyhedralMetric.from_mesh(turned(POINTS), OPEN)
    assert "not closed" in str(e.value) and "with merge=1e-05" in str(e.value)
    with pytest.warns(MeshNote, match=r"2 vertices on sides of other faces \(T-junctions\) split them"):
        metric = PolyhedralMetric.from_mesh(turned(POINTS), OPEN, merge=1e-5)
    assert metric.triangulation.n_vertices == 10
    np.testing.assert_allclose(deficits(metric), [np.pi / 2] * 8 + [0, 0], atol=1e-9)


def test_triangles_without_area_between_the_sides_are_left_out():
    faces = [*OPEN, [1, 0, 9], [9, 0, 8]]
    with pytest.raises(InvalidMetric, match="T-junction"):
        PolyhedralMetric.from_mesh(POINTS, faces)
    with (
        pytest.warns(MeshNote, match="split"),
        pytest.warns(MeshNote, match="2 triangles without area are left out"),
    ):
        metric = PolyhedralMetric.from_mesh(POINTS, faces, merge=1e-5)
    assert deficits(metric).sum() == pytest.approx(4 * np.pi)


def test_the_tolerance_that_is_advised_is_the_one_that_is_needed():
    points = np.array(POINTS, dtype=float)
    points[8, 0] -= 1e-3
    with pytest.raises(InvalidMetric) as error:
        PolyhedralMetric.from_mesh(points, OPEN)
    needed = float(re.search(r"merge=([\d.e-]+)", str(error.value))[1])
    assert 1e-4 < needed < 1e-2
    with pytest.raises(InvalidMetric, match="not closed"), pytest.warns(MeshNote, match="1 vertex"):
        PolyhedralMetric.from_mesh(points, OPEN, merge=needed / 2)
    with pytest.warns(MeshNote, match="split"), pytest.warns(MeshNote, match="not planar"):
        assert PolyhedralMetric.from_mesh(points, OPEN, merge=needed).triangulation.n_vertices == 10


def test_a_hole_is_no_junction():
    metric = PolyhedralMetric.from_mesh(CUBE, SQUARES[1:])
    assert metric.triangulation.boundary_edges.sum() == 4


def test_equal_vertices_alone_split_nothing():
    with pytest.raises(InvalidMetric, match="not closed"):
        PolyhedralMetric.from_mesh(POINTS, OPEN, merge=0.0)


def test_thin_triangles_of_a_closed_surface_stay_where_nothing_is_asked():
    points = np.array(POINTS[:9], dtype=float)
    faces = [*SQUARES[:2], [0, 4, 5, 1, 8], *SQUARES[3:], [1, 0, 8]]
    points[8, 0] -= 1e-4
    assert PolyhedralMetric.from_mesh(points, faces).triangulation.n_faces == 14
