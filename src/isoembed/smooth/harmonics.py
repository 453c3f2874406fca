"""Real spherical harmonics and their derivatives.

``Y_lm(u) = Pi_lm(z) Re, Im (x + i y)^m``, orthonormal, with a polynomial ``Pi_lm`` in z: there is no division
by sin(theta), and the poles need no special treatment.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices, chunks
from isoembed.smooth.loops import summed


@dataclass(frozen=True)
class Harmonics:
    """Real spherical harmonics of degrees l <= `degree` and orders m from -`order` to `order`.

    They are sorted by the absolute value of m, then by l, then cos(m phi) before sin(m phi), which has m < 0.

    Attributes
    ----------
    degree : int
    order : int
        Largest order, at most `degree`; small for functions with few orders about the z-axis.
    """

    degree: int
    order: int

    def __post_init__(self) -> None:
        if not 0 <= self.order <= self.degree:
            raise ValueError(f"the order {self.order} is not between 0 and the degree {self.degree}")

    @cached_property
    def labels(self) -> tuple[Indices, Indices]:
        """Degrees l and orders m, each of shape (size,)."""
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
        """Number of harmonics."""
        return len(self.labels[0])

    def values(self, u: Floats) -> Floats:
        """Harmonics (n, size) at unit vectors u (n, 3)."""
        return np.ascontiguousarray(self._evaluated(u, 0)[0].T)

    def gradients(self, u: Floats) -> tuple[Floats, Floats]:
        """Harmonics (n, size) and their gradients on the sphere, tangent vectors (n, 3, size)."""
        Y, *gradient = self._evaluated(u, 1)
        D = np.stack(gradient)
        D -= u.T[:, None, :] * np.einsum("in,isn->sn", u.T, D)
        return np.ascontiguousarray(Y.T), np.ascontiguousarray(D.transpose(2, 0, 1))

    def along(self, u: Floats, tangents: Floats) -> tuple[Floats, Floats]:
        """Harmonics (n, size) at u (n, 3) and their derivatives (n, k, size) along tangents (n, k, 3)."""
        Y, *gradient = self._evaluated(u, 1)
        first = np.empty((*tangents.shape[:2], self.size))
        for k in range(tangents.shape[1]):
            first[:, k] = sum(D * t for D, t in zip(gradient, tangents[:, k].T, strict=True)).T
        return np.ascontiguousarray(Y.T), first

    def derivatives(self, u: Floats, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
        """Values, tangent gradients and covariant Hessians of functions on the sphere at u (n, 3).

        Their shapes are (n,), (n, 3) and (n, 3, 3) for coefficients (size,), and (n, c), (n, c, 3) and
        (n, c, 3, 3) for coefficients (size, c) of c functions.
        """
        degrees, orders = self.labels
        several = coefficients.reshape(self.size, -1)
        table = np.zeros((self.order + 1, self.degree + 1, several.shape[1]), dtype=np.complex128)
        sine = orders < 0
        # c Re w^m + s Im w^m = Re (c - i s) w^m
        table.real[orders[~sine], degrees[~sine]] = several[~sine]
        table.imag[-orders[sine], degrees[sine]] = -several[sine]
        values, gradient, hessian = summed(
            np.ascontiguousarray(u, dtype=np.float64), table, *recurrence(self.degree, self.order)
        )
        radial = np.einsum("ni,nci->nc", u, gradient)
        P = np.eye(3) - u[:, :, None] * u[:, None, :]
        gradient -= radial[:, :, None] * u[:, None, :]
        hessian = P[:, None] @ hessian @ P[:, None] - radial[:, :, None, None] * P[:, None]
        shape = (len(u), *coefficients.shape[1:])
        return values.reshape(shape), gradient.reshape(*shape, 3), hessian.reshape(*shape, 3, 3)

    def second_along(self, u: Floats, tangents: Floats, coefficients: Floats | None = None) -> Floats:
        """Covariant Hessians (n, k, k, c) on the unit sphere, in pairs of tangents (n, k, 3) at u (n, 3).

        The c functions are given by coefficients (size, c), or are the harmonics themselves.
        """
        n, k = tangents.shape[:2]
        out = np.empty((n, k, k, self.size if coefficients is None else coefficients.shape[1]))
        for part in chunks(n, max(1, 2_000_000 // self.size)):  # bounds the memory
            tables = (table.T for table in self._evaluated(u[part], 2))
            _, *parts = (table if coefficients is None else table @ coefficients for table in tables)
            x, y, z, xx, xy, xz, yz, zz = parts
            hessian = np.stack([np.stack([xx, xy, xz]), np.stack([xy, -xx, yz]), np.stack([xz, yz, zz])])
            radial = np.einsum("in,inc->nc", u[part].T, np.stack([x, y, z]))
            t = tangents[part]
            out[part] = np.einsum("nai,nbj,ijnc->nabc", t, t, hessian, optimize=True)
            out[part] -= np.einsum("nai,nbi->nab", t, t)[..., None] * radial[:, None, None, :]
        return out

    def _evaluated(self, u: Floats, derivatives: int) -> list[Floats]:
        """Values and Cartesian derivatives of the extension to R^3 up to some order, each (size, n).

        In order: value; gradient x, y, z; Hessian xx = -yy, xy, xz, yz, zz.
        """
        x, y, z = u.T
        w = (x + 1j * y)[None, :] ** np.arange(self.order + 1)[:, None]  # (m, n)
        Pi = self._polynomials(z, derivatives)  # each (l, m, n)
        degrees, orders = self.labels
        m = np.abs(orders)
        row = np.where(orders >= 0, m, self.order + 1 + m)

        def part(factor: NDArray[np.complex128]) -> Floats:
            """Real or imaginary parts (size, n) of a factor of each order."""
            return np.concatenate([factor.real, factor.imag])[row]

        P = [table[degrees, m] for table in Pi]
        W = part(w)
        result = [P[0] * W]
        if derivatives >= 1:
            M = np.arange(self.order + 1)[:, None]
            # Derivative in x; that in y is i times as large.
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
        a, b, sectoral = recurrence(L, M)
        tables = [np.zeros((L + 1, M + 1, len(z))) for _ in range(derivatives + 1)]
        tables[0][np.arange(M + 1), np.arange(M + 1)] = sectoral[:, None]
        for l in range(1, L + 1):
            m = np.arange(min(l - 1, M) + 1)
            for d, table in enumerate(tables):
                row = z * table[l - 1, m]
                if d:
                    row = row + d * tables[d - 1][l - 1, m]
                table[l, m] = a[m, l, None] * row
                if l > 1:
                    table[l, m] -= b[m, l, None] * table[l - 2, m]
        return tables


@lru_cache(maxsize=16)
def recurrence(degree: int, order: int) -> tuple[Floats, Floats, Floats]:
    """Tables (order + 1, degree + 1) for ``P_l = a z P_l-1 - b P_l-2``, and ``P_mm`` (order + 1,)."""
    l, m = np.arange(degree + 1.0), np.arange(order + 1.0)[:, None]
    above = l > m
    a = np.sqrt((4.0 * l**2 - 1.0) * above / np.where(above, l**2 - m**2, 1.0))
    b = np.zeros_like(a)
    b[:, 1:] = a[:, 1:] * np.where(above[:, 1:], 1.0, 0.0)
    b[:, 1:] /= np.where(a[:, :-1] > 0.0, a[:, :-1], np.inf)
    m = m[1:, 0]
    steps = np.sqrt((2.0 * m + 1.0) / (2.0 * m)) * np.where(m == 1.0, np.sqrt(2.0), 1.0)
    tables = a, b, np.cumprod(np.concatenate([[np.sqrt(0.25 / np.pi)], steps]))
    for table in tables:
        table.setflags(write=False)
    return tables
