"""The true faces of solids whose metric is exact only to single precision."""

import numpy as np
import pytest

from isoembed import Alexandrov, PolyhedralMetric, embed, unfold


def rounded_cube(n: int, seed: int) -> PolyhedralMetric:
    """A turned cube, n x n squares of two triangles a side, with vertices in single precision."""
    steps = [np.array([x, y]) for x in range(n) for y in range(n)]
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]])
    flat = np.concatenate([corners + step for step in steps])
    sides = []
    for axis in range(3):
        for level, order in ((0, [0, 2, 1]), (n, [0, 1, 2])):
            points = np.full((*flat.shape[:2], 3), level)
            points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = flat[..., 0], flat[..., 1]
            sides.append(points[:, order])
    points, faces = np.unique(np.concatenate(sides).reshape(-1, 3), axis=0, return_inverse=True)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    return PolyhedralMetric.from_mesh((points @ turn / n + 1).astype(np.float32), faces.reshape(-1, 3))


@pytest.mark.parametrize(("n", "seed"), [(4, 5), (9, 3), (9, 7)])
def test_the_faces_of_a_rounded_cube_cover_it(n, seed):
    cube = embed(rounded_cube(n, seed), method=Alexandrov(repair=1e-4))
    area = 0.0
    for polygon in cube.polygons:
        points = cube.vertices[polygon]
        area += np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2
    assert area == pytest.approx(cube.area, rel=1e-6)
    assert len(cube.polygons) <= 12  # what was rounded may fold the sides along a diagonal
    assert not cube.surface.concave_edges.any()
    unfolding = unfold(cube)
    assert len(unfolding.sheets) == 1
    assert len(unfolding.sides) <= 30
