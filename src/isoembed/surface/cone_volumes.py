"""Volumes of cones over triangles in hyperbolic and spherical space.

Let p be the distance of a triangle's plane from the origin, y_F the foot of the perpendicular in projective
coordinates, ``psi(r) = (1 - r cs(r) / sn(r)) / k``, and r(s) the distance from the origin along an edge of
length l from a to b. In polar coordinates about the foot, the volume of the cone is ``tn(p) / 2`` times the
integral of ``psi(r) - psi(p)`` over the angle, around the triangle: psi' is proportional to the volume of a
ball over the square of sn(r). Along an edge, this is

    (w_p^2 / 2) det(y_F, x_a, x_b) / sn(l)  int_0^l (psi(r) - psi(p)) / (sn(r)^2 - sn(p)^2) ds,

which is free of cancellation: for k = 0, psi is r^2 / 3, and the volume one sixth of the determinants. The
integrand is smooth in s, so Gauss-Legendre quadrature converges geometrically.
"""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.space import Space
from isoembed.surface.tangent_frames import sides

NEAR = 0.1  # relative: a difference quotient of closer values is computed as a mean of psi'


def cone_volumes(faces: Indices, vertices: Floats, space: Space) -> Floats:
    """Signed volumes of the cones over triangles from the origin, (F,); positive for outward triangles."""
    x = vertices[faces]
    a, b = x.reshape(-1, 3), np.roll(x, -1, axis=1).reshape(-1, 3)
    feet, squares = _feet(x, space)
    feet, squares = np.repeat(feet, 3, axis=0), np.repeat(squares, 3)
    along = sides(space, a, b)
    length = np.linalg.norm(along, axis=1)  # sn(l)
    l = space.distances(a, b)
    k, w = space.curvature, space.heights(a)
    radial = np.einsum("ij,ij->i", a, along) / np.where(length > 0, length, 1.0)
    # quadrature nodes: 7, plus 6 per radius of curvature in the longest edge
    count = 7 + int(6.0 * space.root * float(l.max(initial=0.0)))
    places, weights = np.polynomial.legendre.leggauss(min(count, 80))  # nodes at most
    total = np.zeros(len(a))
    base = np.einsum("ij,ij->i", a, a)
    for place, weight in zip((1 + places) / 2, weights / 2, strict=True):
        s = place * l
        # h = (1 - w) / k along the edge, and sn(r)^2 = h (2 - k h).
        sn, versine = space.sn(s), space.versine(s)
        h = base / (1 + w) + versine * w + sn * radial
        total += weight * _quotient(h * (2 - k * h), squares, space)
    determinants = np.einsum("ij,ij->i", feet, np.cross(a, b)) * (1 - k * squares)
    share = np.divide(l, length, out=np.ones_like(l), where=length > 0)
    return (determinants * share * total / 2).reshape(-1, 3).sum(axis=1)


def _feet(x: Floats, space: Space) -> tuple[Floats, Floats]:
    """Feet y_F of triangles (F, 3, 3) in projective coordinates, (F, 3), and ``sn(p)^2``, (F,)."""
    k, w = space.curvature, space.heights(x[:, 0])
    first, second = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
    falls = []  # changes of w along both sides
    for side, end in ((first, x[:, 1]), (second, x[:, 2])):
        falls.append(-k * np.einsum("ij,ij->i", side, x[:, 0] + end) / (w + space.heights(end)))
    # The plane is n . x = h w.
    across = np.cross(first, second)
    n = w[:, None] * across + np.cross(falls[0][:, None] * second - falls[1][:, None] * first, x[:, 0])
    h = np.einsum("ij,ij->i", x[:, 0], across)
    squares = np.einsum("ij,ij->i", n, n)
    whole = squares > 0
    feet = n * np.divide(h, squares, out=np.zeros_like(h), where=whole)[:, None]
    return feet, np.divide(h * h, squares + k * h * h, out=np.zeros_like(h), where=whole)


def _quotient(S: Floats, T: Floats, space: Space) -> Floats:
    """``(psi(S) - psi(T)) / (S - T)``, psi as a function of the square of sn(r)."""
    z, y = space.curvature * S, space.curvature * T
    apart = z - y
    near = np.abs(apart) <= NEAR * (1 - np.maximum(z, y))
    quotient = (_psi(z) - _psi(y)) / np.where(near, 1.0, apart)
    places, weights = np.polynomial.legendre.leggauss(5)  # quadrature nodes for the mean
    between = (z[near] + y[near])[:, None] / 2 + places * apart[near][:, None] / 2
    quotient[near] = _slope(between) @ (weights / 2)
    small = np.maximum(np.abs(z), np.abs(y)) <= 0.1  # psi is a series
    quotient[small] = _series(z[small], y[small])
    return quotient


def _psi(z: Floats) -> Floats:
    """``1 - r cs(r) / sn(r)`` of ``z = k sn(r)^2``."""
    return 1 - np.sqrt(np.maximum(1 - z, 0.0)) * _ratio(z)


def _ratio(z: Floats) -> Floats:
    """``r / sn(r)``."""
    root = np.sqrt(np.abs(z))
    r = np.where(z > 0, np.arcsin(np.minimum(root, 1.0)), np.arcsinh(root))
    return np.divide(r, root, out=np.ones_like(r), where=root > 0)


def _slope(z: Floats) -> Floats:
    """Derivative of `_psi`, away from z = 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return (_ratio(z) / np.sqrt(1 - z) - 1) / (2 * z)


def _series(z: Floats, y: Floats) -> Floats:
    """Difference quotient of psi by its series: z / 3, then ``2 n z / (2 n + 3)`` times the previous term."""
    coefficient, power, difference, total = 1 / 3, np.ones_like(y), np.ones_like(y), np.zeros_like(y)
    for n in range(1, 18):  # terms of the series
        total += coefficient * difference
        coefficient *= 2 * n / (2 * n + 3)
        power = power * y
        difference = difference * z + power
    return total
