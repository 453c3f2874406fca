"""Points on the unit sphere (spiral, quadrature nodes), and their Delaunay triangulation."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull
from scipy.special import roots_legendre

from isoembed.arrays import Floats, Indices

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
DENSE = 768  # number of Gauss nodes in z up to which NumPy computes them quickly


def directions_at(z: Floats, phi: ArrayLike) -> Floats:
    """Unit vectors (..., 3) at heights z and angles phi about the z axis, broadcast together."""
    sin = np.sqrt((1.0 - z) * (1.0 + z))
    return np.stack(np.broadcast_arrays(sin * np.cos(phi), sin * np.sin(phi), z), axis=-1)


def angles_of(u: Floats) -> tuple[Floats, Floats]:
    """Angles theta in [0, pi] and phi in [0, 2 pi), each (n,), of unit vectors (n, 3)."""
    theta = np.arctan2(np.hypot(u[:, 0], u[:, 1]), u[:, 2])
    return theta, np.arctan2(u[:, 1], u[:, 0]) % (2.0 * np.pi)


def fibonacci_lattice(n: int) -> Floats:
    """Points (n, 2) evenly distributed over the unit square, periodic in the second coordinate."""
    i = np.arange(n)
    return np.stack([(i + 0.5) / n, i * GOLDEN % 1.0], axis=1)


def fibonacci_directions(n: int) -> Floats:
    """Evenly distributed directions (n, 3) without regular pattern, none at a pole or at phi = 0."""
    height, turn = fibonacci_lattice(n).T
    return directions_at(1.0 - 2.0 * height, 2.0 * np.pi * (turn + 0.5 * (1.0 + GOLDEN)))


def gauss_rule(n: int, around: int) -> tuple[Floats, Floats]:
    """Nodes (n * around, 3) and weights of a product rule on the unit sphere.

    Gauss-Legendre in z times equidistant angles about the z axis: exact for harmonics of degree below 2 n and
    order below `around`.  No node is a pole.
    """
    z, weight = gauss_legendre(n)
    phi = 2.0 * np.pi / around * np.arange(around)
    return directions_at(z[:, None], phi).reshape(-1, 3), np.repeat(2.0 * np.pi / around * weight, around)


@lru_cache(maxsize=64)
def gauss_legendre(n: int) -> tuple[Floats, Floats]:
    """Nodes and weights (n,) on [-1, 1], cached and read-only."""
    # NumPy's nodes are twice as accurate, but take cubic time.
    rule = np.polynomial.legendre.leggauss(n) if n <= DENSE else roots_legendre(n)
    for array in rule:
        array.setflags(write=False)
    return rule


def hull_faces(u: Floats) -> Indices:
    """Outward triangles (F, 3) of the convex hull of directions (n, 3): their Delaunay triangulation."""
    faces = ConvexHull(u).simplices.astype(np.int64)
    a, b, c = (u[faces[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(a, b), c) < 0.0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    return faces


def solid_angles(u: Floats, faces: Indices) -> Floats:
    """A third of the area of the spherical triangles at each direction (n,); zero if there are none."""
    a, b, c = u[faces].transpose(1, 0, 2)
    dot = 1.0 + np.einsum("ni,ni->n", a, b) + np.einsum("ni,ni->n", b, c) + np.einsum("ni,ni->n", c, a)
    solid = 2.0 * np.arctan2(np.abs(np.einsum("ni,ni->n", a, np.cross(b, c))), dot)
    weights = np.zeros(len(u))
    np.add.at(weights, faces, solid[:, None] / 3.0)
    return weights
