"""Hulls of bodies with nearly flat parts, whose deficits reach from one radian down to rounding."""

import numpy as np
import pytest

import zoo
from isoembed import PolyhedralMetric, embed


def superellipsoid(n, exponent, seed):
    """Points of the surface |x|^p + |y|^p + |z|^p = 1 in random directions."""
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, ord=exponent, axis=1)[:, None]


def bulging_cube(n, height, seed):
    """The corners of a cube and points of low paraboloids on its top and bottom."""
    rng = np.random.default_rng(seed)
    top, bottom = rng.uniform(-1, 1, (n, 2)), rng.uniform(-1, 1, (n, 2))
    caps = [
        np.column_stack([xy, side * (1 + height * (1 - (xy**2).sum(axis=1) / 2))])
        for xy, side in ((top, 1), (bottom, -1))
    ]
    return np.vstack([*caps, zoo.cube()[0] * 2 - 1])


@pytest.mark.parametrize(
    "points",
    [
        pytest.param(superellipsoid(1000, 20, 2), id="superellipsoid"),
        pytest.param(superellipsoid(4000, 50, 2), id="sharper superellipsoid"),
        pytest.param(bulging_cube(120, 1e-5, 3), id="cube"),
        pytest.param(bulging_cube(250, 1e-5, 6), id="cube with more points"),
        pytest.param(bulging_cube(500, 1e-6, 6), id="flatter cube"),
    ],
)
def test_deficits_of_all_sizes(points):
    vertices, faces = zoo.outward_hull(points)
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert found.residual <= 1e-10
    # The height of a vertex above its neighbors is of the size of the root of its deficit, of which up to
    # 1e-12 is rounding.
    assert zoo.aligned(found.vertices, vertices) < 1e-6
