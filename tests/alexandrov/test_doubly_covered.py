"""Flat bodies: polygons covered twice, found on the way and laid out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import zoo
from curved import apart
from isoembed import GluedMetric, PolyhedralMetric, embed
from isoembed.alexandrov.doubly_covered import (
    THIN,
    doubly_covered,
    doubly_covered_triangle,
    flat_limit,
)
from isoembed.alexandrov.homotopy import follow_path
from isoembed.alexandrov.lengths import worst_length
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.triangles import Triangles
from isoembed.progress.stages import Log
from isoembed.space import Space
from isoembed.space.models import from_model
from scrambling import scramble
from sheets import covered_twice


def polygon(n, seed, stretch=1.0):
    angle = 2 * np.pi * (np.arange(n) + 0.6 * np.random.default_rng(seed).random(n)) / n
    return np.column_stack([stretch * np.cos(angle), np.sin(angle)])


def found_flat(outline, seed):
    return flat_body(HalfEdges.of(*zoo.doubly_covered(outline)), seed)


def flat_body(tables, seed):
    scramble(tables, 5 * len(tables.faces) + 10, np.random.default_rng(seed))
    triangles = Triangles.of(tables.face_lengths, tables.curvature)
    deficits = 2 * np.pi - np.bincount(tables.corners, triangles.angles.ravel())
    with Log().stage("polytope") as recorder:
        for p in follow_path(tables, deficits, recorder):
            found = flat_limit(p) if p.lowest < THIN else None
            if found is not None:
                return found
    return None


@settings(max_examples=15)
@given(st.integers(4, 12), st.integers(0, 10**6), st.sampled_from([1.0, 3.0, 10.0]))
def test_polygons_are_found(n, seed, stretch):
    outline = polygon(n, seed, stretch)
    found = found_flat(outline, seed)
    assert found is not None
    assert zoo.aligned(found.vertices, np.column_stack([outline, np.zeros(n)])) < 1e-9 * stretch
    Triangulation(found.tables.faces)  # a simplicial complex
    i, j = found.tables.corners, found.tables.corners[found.tables.twins]
    chords = np.linalg.norm(found.vertices[i] - found.vertices[j], axis=1)
    assert chords == pytest.approx(found.tables.lengths, abs=1e-12 * stretch)


@settings(max_examples=15)
@given(
    st.integers(4, 12),
    st.integers(0, 10**6),
    st.sampled_from([1.0, 10.0]),
    st.sampled_from([0.01, 1.0, 1.3]),
    st.sampled_from([-1.0, -1e-9, 1e-9, 1.0]),
)
def test_totally_geodesic_polygons_are_found(n, seed, stretch, size, k):
    outline, space = polygon(n, seed, stretch) / stretch, Space(k)
    size = np.array(size)
    y = np.column_stack([space.sn(size) / space.cs(size) * outline, np.zeros(n)])
    x = from_model(space, y, "projective")
    faces, twins, _ = zoo.doubly_covered(outline)
    lengths = space.distances(x[faces], x[np.roll(faces, -1, axis=1)])
    found = flat_body(HalfEdges.of(faces, twins, lengths / size, k * size**2), seed)
    assert found is not None
    assert not found.vertices[:, 2].any()
    assert apart(x, size * found.vertices, k) < 1e-9
    Triangulation(found.tables.faces)
    assert worst_length(found.tables, found.vertices) < 1e-11


@pytest.mark.parametrize("k", [-1.0, 1.0])
def test_a_triangle_of_a_space_form_covered_twice(k):
    metric = PolyhedralMetric([[0, 1, 2], [0, 2, 1]], [1.0, 1.2, 0.7], curvature=k)
    found = embed(metric, method="alexandrov")
    assert found.core is None
    assert found.residual < 1e-15
    assert found.volume == 0


def test_the_square_whose_apex_is_on_a_diagonal():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    found = found_flat(square, 0)
    assert zoo.aligned(found.vertices, np.column_stack([square, np.zeros(4)])) < 1e-12


def test_the_parallelogram_whose_apex_is_on_two_flat_edges():
    shear = np.array([[0.0, 0], [1, 0], [2, 1], [1, 1]])
    found = found_flat(shear, 1)
    assert zoo.aligned(found.vertices, np.column_stack([shear, np.zeros(4)])) < 1e-12


def test_the_signposts_of_the_fans_are_those_of_the_metric():
    outline = polygon(7, 1)
    tables = HalfEdges.of(*zoo.doubly_covered(outline))
    start, end = tables.corners, np.roll(tables.faces, -1, axis=1).ravel()
    folds = (end - start) % 7 == 1
    folds |= folds[tables.twins]
    found = doubly_covered(tables, folds)
    angles = Triangles.of(tables.face_lengths).angles.ravel()
    total = np.bincount(tables.corners, angles)
    known = {(a, b): x for a, b, x in zip(start[folds], end[folds], tables.directions[folds], strict=True)}
    new_ends = np.roll(found.tables.faces, -1, axis=1).ravel()
    seen = 0
    for a, b, x in zip(found.tables.corners, new_ends, found.tables.directions, strict=True):
        if (b - a) % 7 in (1, 6):
            off = (x - known[a, b]) / total[a]
            assert abs((off + 0.5) % 1 - 0.5) < 1e-12
            seen += 1
    assert seen == 14


def test_the_doubly_covered_triangle():
    outline = np.array([[0.0, 0], [4, 0], [0, 3]])
    tables = HalfEdges.of(*zoo.doubly_covered(outline))
    found = doubly_covered(tables, np.ones(6, dtype=bool))
    assert zoo.aligned(found.vertices, np.column_stack([outline, np.zeros(3)])) < 1e-14


def test_what_is_not_a_doubly_covered_polygon():
    tables = HalfEdges.of(*zoo.doubly_covered(polygon(6, 0)))
    assert doubly_covered(tables, np.zeros(tables.twins.size, dtype=bool)) is None
    assert doubly_covered(tables, np.ones(tables.twins.size, dtype=bool)) is None
    # The two sheets of a tetrahedron, folded along a closed path of four edges, have different angles.
    faces, twins, lengths = zoo.doubly_covered(np.array([[0.0, 0], [2, 0], [2, 1], [0, 1]]))
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    bent = lengths.ravel().copy()
    bent[(start + end == 2) & (start != 1) & (np.arange(12) < 6)] *= 1.1
    folds = (end - start) % 4 != 2
    assert doubly_covered(HalfEdges.of(faces, twins, bent.reshape(-1, 3)), folds) is None


@settings(max_examples=15)
@given(
    n=st.integers(3, 9),
    on_sides=st.integers(0, 6),
    inside=st.integers(0, 6),
    seed=st.integers(0, 10**6),
    stretch=st.sampled_from([1.0, 3.0]),
)
def test_flat_vertices_inside_the_sheets_and_on_the_outline(n, on_sides, inside, seed, stretch):
    metric, points, corners = covered_twice(polygon(n, seed, stretch), on_sides, inside, seed)
    found = embed(metric, method="alexandrov")
    assert zoo.aligned(found.vertices[: len(points)], points) < 1e-8
    assert found.converged and found.volume == 0
    assert found.area == pytest.approx(2 * shoelace(points[:corners]), rel=1e-9)
    # One vertex more where nothing else would do: triangles with flat vertices on their sides only.
    needed = corners == 3 and on_sides > 0 and inside == 0
    assert len(found.vertices) == len(points) + needed
    assert isoembed.report(found)["polyhedron"]["vertices"] == corners


def shoelace(points):
    x, y, _ = points.T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


@pytest.mark.parametrize("missing", [1.0, 1e-3, 1e-8, 1e-11, 1e-13])
def test_obtuse_triangles_however_thin(missing):
    # The Delaunay triangulation has a loop instead of the long side.
    sides = [1.0, 1.0, 2.0 - missing]
    metric = GluedMetric([[0, 1, 2], [2, 1, 0]], [4, 3, 5, 1, 0, 2], [sides, sides])
    found = embed(metric, method="alexandrov")
    assert found.residual < 1e-15
    triangle = doubly_covered_triangle(metric.half_edges())
    assert np.sort(triangle.tables.lengths) == pytest.approx(np.sort(2 * sides), rel=1e-15)
