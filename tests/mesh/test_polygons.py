"""Tables of polygons: who is next around each, and where they face."""

import numpy as np
import pytest

from isoembed.mesh.polygons import next_corners, polygon_normals


def test_the_next_corners():
    assert next_corners(np.array([3, 5, 4])).tolist() == [1, 2, 0, 4, 5, 6, 7, 3, 9, 10, 11, 8]
    assert next_corners(np.empty(0, dtype=np.int64)).size == 0


def test_normals_are_twice_the_areas():
    angles = [2 * np.pi * np.arange(n) / n for n in (3, 7)]
    rings = [np.column_stack([np.cos(a), np.sin(a), np.full(len(a), 5.0)]) for a in angles]
    normals = polygon_normals(np.concatenate([rings[0], rings[1][::-1]]), np.array([3, 7]))
    areas = [n / 2 * np.sin(2 * np.pi / n) for n in (3, 7)]
    assert normals == pytest.approx(np.array([[0, 0, 2 * areas[0]], [0, 0, -2 * areas[1]]]), abs=1e-14)
