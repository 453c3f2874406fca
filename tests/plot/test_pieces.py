"""Triangles of hyperbolic and spherical space in pieces."""

import numpy as np
import pytest

import zoo
from isoembed import Space, Triangulation
from isoembed.plot.pieces import Pieces, middles
from isoembed.space.models import to_model


@pytest.fixture(params=[-1.0, 0.8])
def space(request):
    return Space(request.param)


@pytest.fixture(scope="module")
def octahedron():
    points, faces = zoo.octahedron()
    return 0.9 * points, Triangulation(faces)


def cut(triangulation, times):
    pieces = Pieces.whole(triangulation.faces, triangulation.edges)
    for _ in range(times):
        pieces = pieces.cut()
    return pieces


def test_middles_are_as_far_from_both_ends(space):
    ends = np.random.default_rng(1).uniform(-0.5, 0.5, (20, 2, 3))
    found = middles(space, ends)
    length = space.distances(ends[:, 0], ends[:, 1])
    for k in range(2):
        np.testing.assert_allclose(space.distances(found, ends[:, k]), length / 2, rtol=1e-13)


def test_a_closed_surface_stays_closed(octahedron):
    _, t = octahedron
    for times in range(4):
        pieces = cut(t, times)
        assert len(pieces.faces) == 8 * 4**times == 8 * pieces.per_face
        assert len(pieces.edges) == 12 * 2**times
        finer = Triangulation(pieces.faces)  # checks that it is a sphere
        assert finer.n_vertices == pieces.n_vertices
        np.testing.assert_array_equal(np.bincount(pieces.owners), 2**times)


def test_pieces_lie_in_planes_and_on_lines(octahedron, space):
    """In projective coordinates both are straight."""
    points, t = octahedron
    pieces = cut(t, 3)
    straight = to_model(space, pieces.points(space, points), "projective")
    a, b, c = straight[t.faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    offsets = straight[pieces.faces].reshape(8, -1, 3) - a[:, None]
    assert np.abs(np.einsum("fni,fi->fn", offsets, normals)).max() < 1e-14
    start, end = straight[t.edges[pieces.owners]].transpose(1, 0, 2)
    for k in range(2):
        assert np.abs(np.cross(end - start, straight[pieces.edges[:, k]] - start)).max() < 1e-14


def test_values_are_linear_along_edges(octahedron):
    _, t = octahedron
    pieces = cut(t, 2)
    values = pieces.values(np.arange(6.0))
    low, high = values[t.edges[pieces.owners]].T
    for end in pieces.edges.T:
        share = (values[end] - low) / (high - low)
        np.testing.assert_allclose(4 * share, np.rint(4 * share), atol=1e-12)
    np.testing.assert_array_equal(pieces.nearest()[:6], np.arange(6))
    assert pieces.nearest().max() == 5 and len(pieces.nearest()) == pieces.n_vertices


def test_pieces_of_edges_know_the_pieces_beside_them(octahedron):
    _, t = octahedron
    pieces = cut(t, 2)
    beside = pieces.beside()
    for k in range(2):
        corners = pieces.faces[beside[:, k]]
        for end in pieces.edges.T:
            assert (corners == end[:, None]).any(axis=1).all()
    owners = np.sort(beside // pieces.per_face, axis=1)
    np.testing.assert_array_equal(owners, np.sort(t.edge_faces[pieces.owners], axis=1))


def test_the_script_finds_the_edges_in_the_order_of_the_faces(octahedron):
    _, t = octahedron
    for times in (0, 2):
        pieces = cut(t, times)
        corners = pieces.faces
        halves = np.column_stack([corners.ravel(), np.roll(corners, -1, axis=1).ravel()])
        rising = np.sort(halves[halves[:, 0] < halves[:, 1]], axis=1).tolist()
        known = {
            tuple(sorted(ends)): k
            for ends, k in zip(pieces.edges.tolist(), pieces.owners.tolist(), strict=True)
        }
        np.testing.assert_array_equal(
            pieces.edges_of_faces(), [known.get(tuple(ends), -1) for ends in rising]
        )
