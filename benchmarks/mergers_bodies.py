"""Surfaces in Euclidean space whose area and int H dA are known: truth of mergers.py, without isoembed.

A surface is a map X of unit vectors u, written with plus, minus, times, division and powers alone, so that
it takes complex numbers (the metric: first derivatives by complex steps) and `Jet`s (second derivatives, for
int H dA by Gauss's quadrature).  The coordinates of X are then forgotten: only the metric is passed on.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import Legendre

STEP = 1e-30  # of complex differentiation
CHUNK = 40_000  # nodes at a time


@dataclass(frozen=True)
class Jet:
    """A function of x in R^3 with its gradient (3, n) and Hessian (3, 3, n)."""

    f: np.ndarray
    d: np.ndarray
    dd: np.ndarray

    @classmethod
    def coordinates(cls, u):
        """x, y and z at u (n, 3)."""
        return [
            cls(u[:, i], np.eye(3)[i][:, None] + np.zeros((3, len(u))), np.zeros((3, 3, len(u))))
            for i in range(3)
        ]

    def of(self, f, df, ddf):
        """A function of one variable, of this one, from its derivatives there."""
        return Jet(f, df * self.d, df * self.dd + ddf * self.d[:, None] * self.d[None])

    def __add__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.f + other, self.d, self.dd)
        return Jet(self.f + other.f, self.d + other.d, self.dd + other.dd)

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.f * other, self.d * other, self.dd * other)
        cross = self.d[:, None] * other.d[None]
        mixed = cross + cross.transpose(1, 0, 2)
        return Jet(
            self.f * other.f,
            self.f * other.d + other.f * self.d,
            self.f * other.dd + other.f * self.dd + mixed,
        )

    def __pow__(self, p):
        return self.of(self.f**p, p * self.f ** (p - 1), p * (p - 1) * self.f ** (p - 2))

    def __neg__(self):
        return self * -1.0

    def __sub__(self, other):
        return self + -other

    def __truediv__(self, other):
        return self * other**-1.0

    def __rsub__(self, other):
        return -self + other

    def __rtruediv__(self, other):
        return self**-1.0 * other

    __radd__, __rmul__ = __add__, __mul__
    __array_ufunc__ = None


def polynomial(p, x):
    """A `numpy.polynomial` p of an array or a `Jet`."""
    return x.of(p(x.f), p.deriv()(x.f), p.deriv(2)(x.f)) if isinstance(x, Jet) else p(x)


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


@dataclass(frozen=True)
class Mapped:
    """The surface X(u) in poor coordinates.

    `truth`: int H dA where a closed form or another quadrature has it, else None; `nodes`: heights of the
    quadrature of X itself.
    """

    name: str
    X: Callable
    truth: float | None = None
    nodes: int = 200
    positive: bool = False  # K > 0
    options: dict = field(default_factory=dict)

    def differential(self, u):
        """dX (n, 3, 3) at u (n, 3)."""
        columns = []
        for e in np.eye(3):
            columns.append(np.stack([f.imag / STEP for f in self.X(*(u + 1j * STEP * e).T)], axis=1))
        return np.stack(columns, axis=2)

    def tensor(self, u):
        """The metric (n, 3, 3): symmetric, zero along u."""
        dX = self.differential(u)
        dX = dX - np.einsum("nij,nj->ni", dX, u)[:, :, None] * u[:, None, :]
        return np.einsum("nki,nkj->nij", dX, dX)

    def integrals(self, n):
        """Area, int H dA and the least Gaussian curvature by n heights and 2 n angles."""
        z, w = np.polynomial.legendre.leggauss(n)
        phi = np.arange(2 * n) * (np.pi / n)
        z, phi = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
        w = np.repeat(w, 2 * n) * (np.pi / n)
        parts = []
        for begin in range(0, len(w), CHUNK):
            some = slice(begin, begin + CHUNK)
            dA, H, K = self._shape(z[some], phi[some])
            parts.append((w[some] @ dA, w[some] @ (dA * H), K.min()))
        area, imc, least = zip(*parts, strict=True)
        return float(np.sum(area)), float(np.sum(imc)), float(np.min(least))

    def _shape(self, z, phi):
        """dA over that of the unit sphere, H and K."""
        s, zero = np.sqrt(1.0 - z * z), 0.0 * z
        u = np.stack([s * np.cos(phi), s * np.sin(phi), z])
        along = np.stack([z * np.cos(phi), z * np.sin(phi), -s])
        around = np.stack([-np.sin(phi), np.cos(phi), zero])
        X = self.X(*Jet.coordinates(u.T))

        def first(v):
            return np.stack([np.einsum("in,in->n", f.d, v) for f in X])

        def second(v, w):  # covariant, as the sphere's geodesics bend along -u
            bend = np.stack([np.einsum("ijn,in,jn->n", f.dd, v, w) for f in X])
            return bend - first(u) * np.einsum("in,in->n", v, w)

        Xt, Xp = first(along), first(around)
        normal = np.cross(Xt, Xp, axis=0)
        dA = np.linalg.norm(normal, axis=0)
        normal /= dA
        a, b, c = (-(second(v, w) * normal).sum(axis=0) for v, w in ((along, along), (along, around), (around, around)))
        E, F, G = (Xt * Xt).sum(axis=0), (Xt * Xp).sum(axis=0), (Xp * Xp).sum(axis=0)
        return dA, 0.5 * (a * G - 2.0 * b * F + c * E) / dA**2, (a * c - b * b) / dA**2


def ellipsoid_truth(*axes):
    """int H dA, the integral over the directions of the support function, by two Gauss's quadratures."""
    n = 400
    z, w = np.polynomial.legendre.leggauss(n)
    # cos(phi) nodes: periodic, the trapezoidal rule.
    phi = np.arange(n) * (2.0 * np.pi / n)
    s2 = 1.0 - z[:, None] ** 2
    h = np.sqrt(s2 * ((axes[0] * np.cos(phi)) ** 2 + (axes[1] * np.sin(phi)) ** 2) + (axes[2] * z[:, None]) ** 2)
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
    yield Mapped("ellipsoid (3, 2, 1) as r(u)", star(ellipsoid_radius(3, 2, 1)), ellipsoid_truth(3, 2, 1), 200, True)
    yield Mapped(
        "the same, turned", star(ellipsoid_radius(3, 2, 1), turn=turn), ellipsoid_truth(3, 2, 1), 200, True
    )
    yield Mapped("ellipsoid (5, 2, 1) as r(u)", star(ellipsoid_radius(5, 2, 1)), ellipsoid_truth(5, 2, 1), 400, True)
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
