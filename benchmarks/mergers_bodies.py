"""Surfaces in Euclidean space in poor coordinates: inputs of mergers.py, and what is true of them.

The directions are seen from a bad center, or through a map that bends.  Closed forms and other quadratures
stand beside those of the maps themselves; of isoembed there is nothing here.
"""

import numpy as np
from numpy.polynomial import Legendre

from mergers_maps import STEP, Mapped, polynomial


def unit(x, y, z):
    r = (x * x + y * y + z * z) ** -0.5
    return r * x, r * y, r * z


def turned(matrix, x, y, z):
    return tuple(row[0] * x + row[1] * y + row[2] * z for row in matrix)


def rotation(seed):
    """A rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


def ellipsoid_truth(*axes):
    """int H dA, the integral over the directions of the support function, by two Gauss's quadratures."""
    n = 400
    z, w = np.polynomial.legendre.leggauss(n)
    # cos(phi) nodes: periodic, the trapezoidal rule.
    phi = np.arange(n) * (2.0 * np.pi / n)
    s2 = 1.0 - z[:, None] ** 2
    h = np.sqrt(
        s2 * ((axes[0] * np.cos(phi)) ** 2 + (axes[1] * np.sin(phi)) ** 2) + (axes[2] * z[:, None]) ** 2
    )
    return float(w @ h.sum(axis=1)) * 2.0 * np.pi / n


def revolution_truth(r):
    """int H dA of the surface of revolution with the radius r(cos theta), a function of complex numbers."""
    x, w = np.polynomial.legendre.leggauss(400)
    theta, w = 0.5 * np.pi * (1.0 + x), 0.5 * np.pi * w
    moved = theta + 1j * STEP
    R = r(np.cos(moved))
    rho, z = R * np.sin(moved), R * np.cos(moved)
    turn = np.arctan2(-z.imag, rho.imag)  # the angle of the meridian, from 0 to pi
    # int rho d alpha = - int alpha d rho
    return -np.pi * float(w @ (turn * rho.imag + z.imag)) / STEP


# The directions are changed before they are mapped: a bad center, or a map that bends.


def as_they_are(x, y, z):
    return x, y, z


def shifted(dx, dy, dz):
    """Directions seen from a point off the center of the unit sphere, nearly."""
    return lambda x, y, z: unit(x + dx, y + dy, z + dz)


def bent(size):
    """A strong map of the sphere to itself: degree two, one to one up to a size of 0.45 or so."""
    return lambda x, y, z: unit(x + size * y * y, y + size * z * x, z + size * (x * x - y * z))


def star(radius, directions=as_they_are, turn=None):
    """r(u) u, the directions changed and turned before."""

    def X(x, y, z):
        v = directions(x, y, z)
        v = v if turn is None else turned(turn, *v)
        r = radius(*v)
        return r * v[0], r * v[1], r * v[2]

    return X


def linear(axes, directions, turn):
    """An ellipsoid."""

    def X(x, y, z):
        v = turned(turn, *directions(x, y, z))
        return tuple(a * c for a, c in zip(axes, v, strict=True))

    return X


def ellipsoid_radius(a, b, c):
    return lambda x, y, z: (x * x / a**2 + y * y / b**2 + z * z / c**2) ** -0.5


def cassini(a, b):
    """Distances from two foci +- a on z multiply to b^2: a waist where b < sqrt(2) a."""

    def radius(_, __, z):
        c = 2.0 * z * z - 1.0  # cos 2 theta
        return (a * a * c + (b**4 - a**4 * (1.0 - c * c)) ** 0.5) ** 0.5

    return radius


def ridges(degree, count, size, seed):
    """1 + sum of Legendre polynomials P_l(u . e) of random degrees up to one, and random directions e."""
    rng = np.random.default_rng(seed)
    e = rng.normal(size=(count, 3))
    e /= np.linalg.norm(e, axis=1)[:, None]
    terms = []
    for i in range(count):
        l = degree if i == 0 else int(rng.integers(2, degree + 1))
        terms.append((Legendre.basis(l), e[i], size * rng.normal() / l**1.5))

    def radius(x, y, z):
        r = 1.0
        for p, (a, b, c), height in terms:
            r = r + height * polynomial(p, a * x + b * y + c * z)
        return r

    return radius


def waist(depth, width, squeezed=1.0, bend=0.0):
    """A body with a waist, its cross-sections ellipses and its axis bent where this is asked for."""

    def X(x, y, z):
        r = 1.0 - depth / (1.0 + (z / width) ** 2)
        return r * x + bend * z * z, squeezed * r * y, 1.6 * z + 0.3 * bend * x * z

    return X


def tip(height, width):
    """A sphere with a pointed hill around z, and a small one aside."""

    def radius(x, y, z):
        aside = 0.6 * x + 0.8 * y
        return 1.0 + height * width / (width**2 + 2.0 * (1.0 - z)) ** 0.5 + 0.05 * aside * aside * aside

    return radius


def composed(outer, directions, turn):
    def X(x, y, z):
        return outer(*turned(turn, *directions(x, y, z)))

    return X


def bodies():
    """All of them."""
    turn = rotation(3)
    peanut = cassini(1.0, 1.1)
    profile = revolution_truth(lambda c: peanut(None, None, c))
    yield Mapped(
        "ellipsoid (3, 2, 1) as r(u)", star(ellipsoid_radius(3, 2, 1)), ellipsoid_truth(3, 2, 1), 200, True
    )
    yield Mapped(
        "the same, turned", star(ellipsoid_radius(3, 2, 1), turn=turn), ellipsoid_truth(3, 2, 1), 200, True
    )
    yield Mapped(
        "ellipsoid (5, 2, 1) as r(u)", star(ellipsoid_radius(5, 2, 1)), ellipsoid_truth(5, 2, 1), 400, True
    )
    yield Mapped(
        "ellipsoid (3, 2, 1), center 0.3 off",
        star(ellipsoid_radius(3, 2, 1), shifted(0.3, 0.1, 0.05)),
        ellipsoid_truth(3, 2, 1),
        300,
        True,
    )
    yield Mapped(
        "ellipsoid (2, 1.5, 1), bent 0.2",
        linear((2, 1.5, 1), bent(0.2), turn),
        ellipsoid_truth(2, 1.5, 1),
        150,
        True,
    )
    yield Mapped(
        "ellipsoid (2, 1.5, 1), bent 0.4",
        linear((2, 1.5, 1), bent(0.4), turn),
        ellipsoid_truth(2, 1.5, 1),
        250,
        True,
    )
    yield Mapped("star of degree 20, K > 0", star(ridges(20, 12, 0.2, 1)), None, 150, True)
    yield Mapped("star of degree 20, K < 0 in places", star(ridges(20, 12, 0.6, 1)), None, 150)
    yield Mapped("star of degree 20, bent 0.2", star(ridges(20, 12, 0.3, 2), bent(0.2)), None, 200)
    yield Mapped("Cassini's peanut, turned", star(peanut, turn=turn), profile, 300)
    yield Mapped(
        "Cassini's peanut, turned, off center", star(peanut, shifted(0.2, 0.1, 0.2), turn), profile, 400
    )
    yield Mapped("waist, turned", composed(waist(0.4, 0.5), as_they_are, turn), None, 200)
    yield Mapped("waist without symmetry", composed(waist(0.4, 0.5, 0.8, 0.2), as_they_are, turn), None, 200)
    yield Mapped("bumpy", star(ridges(10, 20, 0.6, 4)), None, 150)
    yield Mapped("pointed tip", star(tip(0.4, 0.15), turn=turn), None, 400)
