"""Vertices that coincide."""

import numpy as np
import pytest

from isoembed.mesh.merging import representatives, without_repetitions


def nearest_first(points, distance):
    """By all pairs: the first vertex of each chain."""
    n = len(points)
    near = np.linalg.norm(points[:, None] - points, axis=2) <= distance
    for _ in range(n):
        near = near | (near.astype(int) @ near.astype(int) > 0)
    return np.argmax(near, axis=1)


@pytest.mark.parametrize("distance", [0.0, 1e-12, 0.03, 0.1])
def test_the_first_of_each_chain(distance):
    rng = np.random.default_rng(0)
    points = rng.random((60, 3))
    points = np.concatenate([points, points[rng.permutation(60)[:25]], -0.0 * points[:2], 0.0 * points[:2]])
    points[60:70] += 1e-13 * (distance > 0)
    points = points[rng.permutation(len(points))]
    np.testing.assert_array_equal(representatives(points, distance), nearest_first(points, distance))


def test_coordinates_beyond_what_can_be_squared():
    points = np.array([[0.0, 0.0], [1e300, 0.0], [1e300, 1e285], [1.0, 0.0]])
    assert representatives(points, 1e290).tolist() == [0, 1, 1, 0]


def test_faces_that_are_edges_and_points_are_left_out():
    faces = [
        [0, 1, 2],
        [3, 3, 4],
        [5, 5, 5],
        [0, 0, 1, 2],
        [1, 2, 2, 1],
        [1, 2, 1, 2],
        [4, 1, 2, 4],
        [0, 1, 2, 3],
    ]
    corners, sizes, left = without_repetitions(np.concatenate(faces), np.array([len(face) for face in faces]))
    parts = np.split(corners, np.cumsum(sizes)[:-1])
    assert [part.tolist() for part in parts] == [[0, 1, 2], [0, 1, 2], [1, 2, 4], [0, 1, 2, 3]]
    np.testing.assert_array_equal(np.flatnonzero(left), [0, 3, 6, 7])
