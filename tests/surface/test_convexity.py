"""Concave edges, inverted and partially inverted vertices: made by hand, and told apart exactly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.convexity import concave_edges, inverted_vertices, partially_inverted_vertices


def with_dents(dents, level=2):
    """Icosphere with some vertices mirrored in the plane of their neighbors."""
    vertices, faces = zoo.icosphere(level)
    t = Triangulation(faces)
    pushed = vertices.copy()
    for v in dents:
        middle = vertices[t.adjacency[[v]].indices].mean(axis=0)
        pushed[v] = 2 * middle - vertices[v]
    return t, pushed


@pytest.mark.parametrize("mesh", [zoo.tetrahedron(), zoo.cube(), zoo.icosphere(2), zoo.random_hull(200, 0)])
def test_a_convex_surface_has_nothing_concave(mesh):
    vertices, faces = mesh
    t = Triangulation(faces)
    concave = concave_edges(t, vertices @ zoo.rotation(0).T)
    assert not concave.any()
    assert not inverted_vertices(t, concave).any()
    assert not partially_inverted_vertices(t, concave).any()


def test_a_vertex_pushed_in_is_inverted_and_its_neighbors_are_not():
    for v, degree in [(0, 5), (100, 6)]:
        t, vertices = with_dents([v])
        assert t.degrees[v] == degree
        concave = concave_edges(t, vertices)
        assert np.array_equal(np.flatnonzero(concave), np.flatnonzero((t.edges == v).any(axis=1)))
        assert np.flatnonzero(inverted_vertices(t, concave)).tolist() == [v]
        assert not partially_inverted_vertices(t, concave).any()


def test_several_dents():
    dents = [0, 1, 100, 159]
    t, vertices = with_dents(dents)
    concave = concave_edges(t, vertices)
    assert np.flatnonzero(inverted_vertices(t, concave)).tolist() == dents


def test_a_surface_turned_inside_out_is_inverted_everywhere():
    vertices, faces = zoo.icosphere(1)
    t = Triangulation(faces[:, ::-1])
    concave = concave_edges(t, vertices)
    assert concave.all()
    assert inverted_vertices(t, concave).all()
    assert not partially_inverted_vertices(t, concave).any()


@pytest.mark.parametrize(
    ("concave_there", "inverted", "partial"),
    [(0, False, False), (4, False, False), (5, False, True), (6, True, False)],
)
def test_seventy_percent_of_six_edges(concave_there, inverted, partial):
    """Five of six edges are more than seventy percent, four are not; six are all."""
    t = Triangulation(zoo.icosphere(2)[1])
    at = np.flatnonzero((t.edges == 100).any(axis=1))
    concave = np.zeros(t.n_edges, dtype=bool)
    concave[at[:concave_there]] = True
    assert inverted_vertices(t, concave)[100] == inverted
    assert partially_inverted_vertices(t, concave)[100] == partial


def test_exactly_seventy_percent_is_not_more():
    """A vertex of degree 10: seven concave edges are not more than seventy percent, eight are."""
    angle = 2 * np.pi * np.arange(10) / 10
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(10)])
    vertices, faces = zoo.outward_hull(np.vstack([rim, [[0, 0, 1], [0, 0, -1]]]))
    t = Triangulation(faces)
    apex = int(np.argmax(vertices[:, 2]))
    at = np.flatnonzero((t.edges == apex).any(axis=1))
    assert len(at) == 10
    for count, partial in [(7, False), (8, True), (9, True), (10, False)]:
        concave = np.zeros(t.n_edges, dtype=bool)
        concave[at[:count]] = True
        assert partially_inverted_vertices(t, concave)[apex] == partial


def test_a_dent_beside_a_bump_is_partially_inverted():
    vertices, faces = zoo.icosphere(2)
    t = Triangulation(faces)
    beside = int(t.adjacency[[100]].indices[0])
    for bump, inverted in [(1.0, True), (1.15, False)]:
        moved = vertices.copy()
        moved[100] *= 0.89
        moved[beside] *= bump
        concave = concave_edges(t, moved)
        assert concave[(t.edges == 100).any(axis=1)].sum() == (6 if inverted else 5)
        assert inverted_vertices(t, concave)[100] == inverted
        assert partially_inverted_vertices(t, concave)[100] != inverted


@given(seed=st.integers(0, 10**6), exponent=st.integers(-50, 50))
def test_motions_scales_and_labels_change_nothing(seed, exponent):
    rng = np.random.default_rng(seed)
    t, vertices = with_dents(rng.choice(42, size=3, replace=False), level=1)
    concave = concave_edges(t, vertices)
    moved = 10.0**exponent * (vertices @ zoo.rotation(seed).T + [1.0, 2, 3])
    assert np.array_equal(concave_edges(t, moved), concave)
    points, other, new = zoo.relabeled(vertices, t.faces, seed)
    s = Triangulation(other)
    twin = concave_edges(s, points)
    assert np.array_equal(twin[s.edge_indices(new[t.edges])], concave)
    for count in (inverted_vertices, partially_inverted_vertices):
        assert np.array_equal(count(s, twin)[new], count(t, concave))


def test_rounding_on_flat_faces_is_not_concave():
    vertices, faces = zoo.subdivided(*zoo.subdivided(*zoo.cube()))
    t = Triangulation(faces)
    for seed in range(5):
        assert not concave_edges(t, 1e-150 * vertices @ zoo.rotation(seed).T * 1e150).any()
