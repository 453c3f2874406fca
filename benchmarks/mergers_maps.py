"""Maps of the sphere into Euclidean space with their metric, area and int H dA, without isoembed.

A map X of unit vectors u is written with plus, minus, times, division and powers alone, so that it takes
complex numbers (the metric: first derivatives by complex steps) and `Jet`s (second derivatives, for int H dA
by Gauss's quadrature).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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

    def differential(self, u):
        """dX (n, 3, 3) at u (n, 3)."""
        moved = [self.X(*(u + 1j * STEP * e).T) for e in np.eye(3)]
        return np.array([[f.imag / STEP for f in X] for X in moved]).transpose(2, 1, 0)

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

        along_t, along_p = first(along), first(around)
        normal = np.cross(along_t, along_p, axis=0)
        dA = np.linalg.norm(normal, axis=0)
        normal /= dA
        a, b, c = (
            -(second(v, w) * normal).sum(axis=0)
            for v, w in ((along, along), (along, around), (around, around))
        )
        E, F, G = (
            (along_t * along_t).sum(axis=0),
            (along_t * along_p).sum(axis=0),
            (along_p * along_p).sum(axis=0),
        )
        return dA, 0.5 * (a * G - 2.0 * b * F + c * E) / dA**2, (a * c - b * b) / dA**2
