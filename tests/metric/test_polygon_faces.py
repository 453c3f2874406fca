"""Polygons in space, cut into triangles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gluing_polygons import shoelace, star
from isoembed.errors import InvalidMetric
from isoembed.metric.polygon_faces import PLANAR, PolygonFaces


def polygons(points, faces):
    return PolygonFaces(np.asarray(points, float), np.concatenate(faces), np.array([len(f) for f in faces]))


def areas(points, triangles):
    a, b, c = np.moveaxis(np.asarray(points)[triangles], 1, 0)
    return np.cross(b - a, c - a) / 2


@given(seed=st.integers(0, 10**6), sizes=st.lists(st.integers(3, 12), min_size=1, max_size=8))
def test_triangles_fill_their_polygons_in_their_order(seed, sizes):
    points, faces, expected = [], [], []
    for k, n in enumerate(sizes):
        outline = star(n, seed + k)
        turn = Rotation.random(random_state=seed + k).as_matrix()
        faces.append(len(points) + np.arange(n))
        points += list(np.pad(outline, ((0, 0), (0, 1))) @ turn.T / 4)
        expected.append(turn[:, 2] * shoelace(outline) / 16)
    found = polygons(points, faces)
    triangles = found.triangles()
    assert (found.warps < 1e-14).all()
    parts = np.split(triangles, np.cumsum(np.array(sizes) - 2)[:-1])
    for face, normal, part in zip(faces, expected, parts, strict=True):
        assert set(part.ravel()) == set(face)
        vectors = areas(points, part)
        assert (vectors @ normal > 0).all()
        np.testing.assert_allclose(vectors.sum(axis=0), normal, atol=1e-14)


def test_quadrilaterals_are_cut_across_their_smaller_angles():
    flat = [[0.0, 0, 0], [0.9, 0.3, 0], [1, 1, 0], [0.3, 0.9, 0]]
    dart = [[0.0, 0, 0], [1, 0.1, 0], [0.3, 0.3, 0], [0.1, 1, 0]]
    straight = [[0.0, 0, 0], [0.5, 0, 0], [1, 0, 0], [0.5, 0.1, 0]]
    square = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    for points, diagonal in ((flat, {1, 3}), (dart, {0, 2}), (straight, {1, 3}), (square, {0, 2})):
        for shift in range(4):
            first, second = polygons(np.roll(points, shift, axis=0), [[0, 1, 2, 3]]).triangles()
            shared = {int(v - shift) % 4 for v in set(first) & set(second)}
            assert shared == diagonal or points is square


def test_how_far_corners_are_off_a_plane():
    lifted = np.array([[1.0, 0, 0.2], [0, 1, -0.2], [-1, 0, 0.2], [0, -1, -0.2]])
    assert polygons(lifted, [[0, 1, 2, 3]]).warps == pytest.approx(0.2 / np.sqrt(1.04))
    assert polygons(lifted * [1, 1, 1e-7], [[0, 1, 2, 3]]).warps < PLANAR


@pytest.mark.parametrize("n", range(4, 13))
def test_polygons_on_the_same_vertices_share_no_diagonal(n):
    t = 2 * np.pi * np.arange(n) / n
    points = np.column_stack([np.cos(t), 0.7 * np.sin(t), 0 * t])
    triangles = polygons(points, [np.arange(n), np.arange(n)[::-1]]).triangles()
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert (areas(points, triangles[: n - 2])[:, 2] > 0).all()
    assert (areas(points, triangles[n - 2 :])[:, 2] < 0).all()


@pytest.mark.parametrize(
    ("points", "face", "sentence"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [0, 1, 2, 3], "cannot be cut into triangles"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [0, 1, 2, 3], "cannot be cut into triangles"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]], [0, 1, 2, 3, 4], "it has no area"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [0, 1, 0, 2], "face 0 [0, 1, 0, 2] repeats a vertex"),
    ],
)
def test_polygons_that_are_none(points, face, sentence):
    with pytest.raises(InvalidMetric) as caught:
        polygons(np.array(points) / 4, [np.array(face)]).triangles()
    assert sentence in str(caught.value)
