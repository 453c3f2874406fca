"""Real spherical harmonics as functions on R^3, with their derivatives, and quadrature on the sphere.

``Y_lm(u) = Pi_lm(z) Re, Im (x + i y)^m``, orthonormal, ``Pi_lm`` a polynomial in z: there is no division by
sin(theta) anywhere, and the poles are points like any others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_legendre

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CHUNK = 2_000_000  # harmonics at directions, evaluated at a time


@dataclass(frozen=True)
class Harmonics:
    """The real spherical harmonics of degree l <= `degree` and orders m from -`order` to `order`.

    They are sorted by the absolute value of m, then by l; of the two with the same of both, the one with
    cos(m phi) comes first, and m < 0 stands for the one with sin(m phi).

    Attributes
    ----------
    degree : int
    order : int
        At most `degree`; small for what is nearly symmetric about the z-axis.
    """

    degree: int
    order: int

    def __post_init__(self) -> None:
        if not 0 <= self.order <= self.degree:
            raise ValueError(f"the order {self.order} is not between 0 and the degree {self.degree}")

    @cached_property
    def labels(self) -> tuple[Indices, Indices]:
        """The degrees l and the orders m, each of shape (size,)."""
        pairs = [
            (l, sign * m)
            for m in range(self.order + 1)
            for l in range(m, self.degree + 1)
            for sign in ((1, -1) if m else (1,))
        ]
        degrees, orders = np.array(pairs, dtype=np.int64).T
        return degrees, orders

    @property
    def size(self) -> int:
        """How many they are."""
        return len(self.labels[0])

    def values(self, u: Floats) -> Floats:
        """The harmonics (n, size) in the directions u (n, 3), unit vectors."""
        return np.ascontiguousarray(self._evaluated(u, 0)[0].T)

    def gradients(self, u: Floats) -> tuple[Floats, Floats]:
        """The harmonics (n, size) and their gradients on the sphere, tangent vectors (n, 3, size)."""
        Y, *gradient = self._evaluated(u, 1)
        D = np.stack(gradient)
        D -= u.T[:, None, :] * np.einsum("in,isn->sn", u.T, D)
        return np.ascontiguousarray(Y.T), np.ascontiguousarray(D.transpose(2, 0, 1))

    def along(self, u: Floats, tangents: Floats) -> tuple[Floats, Floats]:
        """The harmonics and their derivatives along k tangent vectors at each of n directions.

        Parameters
        ----------
        u : ndarray, shape (n, 3)
        tangents : ndarray, shape (n, k, 3)
            Orthogonal to u; of any length.

        Returns
        -------
        values : ndarray, shape (n, size)
        first : ndarray, shape (n, k, size)
        """
        Y, *gradient = self._evaluated(u, 1)
        first = np.empty((*tangents.shape[:2], self.size))
        for k in range(tangents.shape[1]):
            first[:, k] = sum(D * t for D, t in zip(gradient, tangents[:, k].T, strict=True)).T
        return np.ascontiguousarray(Y.T), first

    def second_along(self, u: Floats, tangents: Floats, coefficients: Floats) -> Floats:
        """Covariant second derivatives on the unit sphere of functions given by their coefficients.

        Parameters
        ----------
        u : ndarray, shape (n, 3)
        tangents : ndarray, shape (n, k, 3)
        coefficients : ndarray, shape (size, c)

        Returns
        -------
        ndarray, shape (n, k, k, c)
            The Hessian of each function in each pair of tangent vectors.
        """
        n, k = tangents.shape[:2]
        out = np.empty((n, k, k, coefficients.shape[1]))
        chunk = max(1, CHUNK // self.size)
        for begin in range(0, n, chunk):
            part = slice(begin, begin + chunk)
            _, *parts = (table.T @ coefficients for table in self._evaluated(u[part], 2))
            x, y, z, xx, xy, xz, yz, zz = parts
            hessian = np.stack([np.stack([xx, xy, xz]), np.stack([xy, -xx, yz]), np.stack([xz, yz, zz])])
            radial = np.einsum("in,inc->nc", u[part].T, np.stack([x, y, z]))
            t = tangents[part]
            out[part] = np.einsum("nai,nbj,ijnc->nabc", t, t, hessian, optimize=True)
            out[part] -= np.einsum("nai,nbi->nab", t, t)[..., None] * radial[:, None, None, :]
        return out

    def _evaluated(self, u: Floats, derivatives: int) -> list[Floats]:
        """Values and Cartesian derivatives of the extension to R^3, each (size, n), as many as asked for.

        In this order: the value; the gradient's x, y, z; the Hessian's xx = -yy, xy, xz, yz, zz.
        """
        x, y, z = u.T
        w = (x + 1j * y)[None, :] ** np.arange(self.order + 1)[:, None]  # (m, n)
        Pi = self._polynomials(z, derivatives)  # each (l, m, n)
        degrees, orders = self.labels
        m = np.abs(orders)
        row = np.where(orders >= 0, m, self.order + 1 + m)

        def part(factor: NDArray[np.complex128]) -> Floats:
            """Real or imaginary part (size, n) of one factor for each order."""
            return np.concatenate([factor.real, factor.imag])[row]

        P = [table[degrees, m] for table in Pi]
        W = part(w)
        result = [P[0] * W]
        if derivatives >= 1:
            M = np.arange(self.order + 1)[:, None]
            # The derivative in x; that in y is i times it.
            w1 = M * np.concatenate([np.zeros_like(w[:1]), w[:-1]])
            Wx, Wy = part(w1), part(1j * w1)
            result += [P[0] * Wx, P[0] * Wy, P[1] * W]
        if derivatives >= 2:
            w2 = M * np.concatenate([np.zeros_like(w1[:1]), w1[:-1]])
            Wxx, Wxy = part(w2), part(1j * w2)
            result += [P[0] * Wxx, P[0] * Wxy, P[1] * Wx, P[1] * Wy, P[2] * W]
        return result

    def _polynomials(self, z: Floats, derivatives: int) -> list[Floats]:
        """``Pi_lm(z)`` and its derivatives, each (degree + 1, order + 1, n), by the recurrence in l."""
        L, M = self.degree, self.order
        tables = [np.zeros((L + 1, M + 1, len(z))) for _ in range(derivatives + 1)]
        sectoral = np.sqrt(1.0 / (4.0 * np.pi))
        for m in range(M + 1):
            if m:
                sectoral *= np.sqrt((2.0 * m + 1.0) / (2.0 * m)) * (np.sqrt(2.0) if m == 1 else 1.0)
            tables[0][m, m] = sectoral
        for l in range(1, L + 1):
            orders = np.arange(min(l - 1, M) + 1)
            a = np.sqrt((4.0 * l**2 - 1.0) / (l**2 - orders**2))[:, None]
            # The row before the first has no harmonics, whatever its factor.
            b = a * np.sqrt(((l - 1.0) ** 2 - orders**2) / max(4.0 * (l - 1.0) ** 2 - 1.0, 1.0))[:, None]
            for d, table in enumerate(tables):
                row = z * table[l - 1, orders]
                if d:
                    row = row + d * tables[d - 1][l - 1, orders]
                table[l, orders] = a * row
                if l > 1:
                    table[l, orders] -= b * table[l - 2, orders]
        return tables


def gauss_rule(n: int, around: int) -> tuple[Floats, Floats]:
    """Nodes (n * around, 3) and weights of a product rule on the unit sphere.

    Gauss-Legendre in z times even angles about the z-axis: exact for harmonics of degree below 2 n and order
    below `around`.  No node is a pole.
    """
    z, weight = roots_legendre(n)
    phi = 2.0 * np.pi / around * np.arange(around)
    sin = np.sqrt((1.0 - z) * (1.0 + z))
    x, y = np.outer(sin, np.cos(phi)), np.outer(sin, np.sin(phi))
    u = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)], axis=-1).reshape(-1, 3)
    return u, np.repeat(weight * 2.0 * np.pi / around, around)


def spread_directions(n: int) -> Floats:
    """Directions (n, 3) that are spread evenly and without a pattern: a Fibonacci lattice."""
    k = np.arange(n) + 0.5
    z, phi = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    sin = np.sqrt((1.0 - z) * (1.0 + z))
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), z], axis=1)
