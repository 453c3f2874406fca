"""Roots of small systems of quadratic equations by homotopy.

k equations of degree 2 in k unknowns have 2^k complex roots, counted with multiplicities and at infinity
(Bezout).  Those of ``s_i^2 = s_i`` are the corners of a cube.  As t goes from 0 to 1, the roots of

    (1 - t) gamma (s_i^2 - s_i) + t f_i(s)

follow paths that do not meet before t = 1, for all but finitely many gamma on the unit circle.  The paths are
computed in projective space, where no root is infinite.  See Sommese and Wampler, The numerical
solution of systems of polynomials arising in engineering and science (World Scientific, 2005).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats

Complex = NDArray[np.complex128]

COINCIDE = 1e-6  # relative distance of identical roots


@dataclass(frozen=True, eq=False)
class QuadraticRoots:
    """The roots of k quadratic equations.

    Attributes
    ----------
    roots : ndarray of complex, shape (n, k)
        The finite roots.
    at_infinity : int
        Number of roots at infinity.
    complete : bool
        Whether all paths were followed: to t = 1, or close to it at multiple or nearly multiple roots, which
        are known to few digits; and no two paths that reached t = 1 have the same root.
    """

    roots: Complex
    at_infinity: int
    complete: bool

    def near_real(self, imaginary: float) -> list[Floats]:
        """Real parts, (k,), of the roots with at most this imaginary part, relative to the root.

        Conjugate and coincident roots are counted once.
        """
        found: list[Floats] = []
        for root in self.roots:
            real, size = root.real, float(np.linalg.norm(root))
            if np.linalg.norm(root.imag) > imaginary * size:
                continue
            if all(np.linalg.norm(real - other) > COINCIDE * max(size, 1.0) for other in found):
                found.append(real)
        return found


def quadratic_roots(constant: Floats, slope: Floats, Q: Floats) -> QuadraticRoots:
    """All roots of ``c_i + sum_j L_ij s_j + 1/2 sum_jk Q_ijk s_j s_k``.

    Parameters
    ----------
    constant : ndarray, shape (k,)
    slope : ndarray, shape (k, k)
        L.
    Q : ndarray, shape (k, k, k)
        Symmetric in the last two indices.  The unknowns should be scaled so that roots are of order 1.
    """
    rng = np.random.default_rng(0)
    for retry in range(3):  # with a new gamma, and a tenth of the corrections
        paths = _Paths(constant, slope, Q, rng)
        ends, t = paths.followed(1e-3 * 0.1**retry)  # relative Newton correction of a step
        converged = t > 0.99  # otherwise the path was lost
        # Threshold on the relative homogenizing coordinate.
        infinite = converged & (np.abs(ends[:, 0]) <= 1e-6 * np.linalg.norm(ends, axis=1))
        complete = bool(converged.all()) and not _coincide(ends[(t == 1.0) & ~infinite])
        if complete:
            break
    finite = ends[converged & ~infinite]
    return QuadraticRoots(finite[:, 1:] / finite[:, :1], int(infinite.sum()), complete)


def _coincide(ends: Complex) -> bool:
    """Whether two ends of paths coincide in the affine patch of projective space."""
    apart = np.linalg.norm(ends[:, None] - ends, axis=2)
    np.fill_diagonal(apart, np.inf)
    return bool((apart <= COINCIDE * np.linalg.norm(ends, axis=1)).any())


class _Paths:
    """The homotopy from ``s_i^2 = s_i``, in homogeneous coordinates z = (z_0, s) of a random affine patch."""

    def __init__(self, constant: Floats, slope: Floats, Q: Floats, rng: np.random.Generator) -> None:
        self.constant, self.slope, self.Q = constant, slope, Q
        self.k = k = len(constant)
        self.gamma = np.exp(2j * np.pi * rng.random())
        self.patch = rng.normal(size=k + 1) + 1j * rng.normal(size=k + 1)
        corners = np.array(list(itertools.product((1.0,), *itertools.repeat((0.0, 1.0), k))))
        self.starts = corners / (corners @ self.patch)[:, None]

    def followed(self, corrected: float) -> tuple[Complex, Floats]:
        """Ends of the paths, (2^k, k + 1), and their t: 1, or less at a multiple root."""
        z, n = self.starts.copy(), len(self.starts)
        t, h, alive = np.zeros(n), np.full(n, 0.05), np.ones(n, dtype=np.bool_)  # the first step
        while (moving := np.flatnonzero(alive & (t < 1))).size:
            now, step = t[moving], np.minimum(h[moving], 1 - t[moving])
            then = np.where(step == 1 - now, 1.0, now + step)
            ends, first, last = self._corrected(self._predicted(z[moving], now, step), then)
            good = (first <= corrected) & (last <= 1e-10)  # the last of three corrections
            z[moving[good]], t[moving[good]] = ends[good], then[good]
            # Steps with small corrections are doubled.
            h[moving] = np.where(good, np.where(first <= 0.1 * corrected, 2 * step, step), step / 2)
            alive[moving] = h[moving] >= 1e-8  # a path with shorter steps ends at a multiple root
        return z, t

    def _predicted(self, z: Complex, t: Floats, h: Floats) -> Complex:
        """A step of the fourth-order Runge-Kutta method."""
        half = h[:, None] / 2
        first = self._tangent(z, t)
        second = self._tangent(z + half * first, t + h / 2)
        third = self._tangent(z + half * second, t + h / 2)
        fourth = self._tangent(z + 2 * half * third, t + h)
        return z + half / 3 * (first + 2 * second + 2 * third + fourth)

    def _corrected(self, z: Complex, t: Floats) -> tuple[Complex, Floats, Floats]:
        """Three steps of Newton's method, and the lengths of the first and the last."""
        sizes = []
        for _ in range(3):
            start, goal, J = self._evaluated(z, t)
            f = np.zeros_like(z)
            f[:, :-1] = (1 - t)[:, None] * start + t[:, None] * goal
            f[:, -1] = z @ self.patch - 1
            step = _solved(J, f)
            z = z - step
            sizes.append(np.linalg.norm(step, axis=1) / np.linalg.norm(z, axis=1))
        return z, sizes[0], sizes[-1]

    def _tangent(self, z: Complex, t: Floats) -> Complex:
        start, goal, J = self._evaluated(z, t)
        f = np.zeros_like(z)
        f[:, :-1] = start - goal
        return _solved(J, f)

    def _evaluated(self, z: Complex, t: Floats) -> tuple[Complex, Complex, Complex]:
        """Both systems, each (n, k), and the derivatives of the homotopy and of the patch equation by z."""
        k, z0, s, t = self.k, z[:, :1], z[:, 1:], t[:, None]
        start = self.gamma * s * (s - z0)
        bent = np.einsum("ijk,nk->nij", self.Q, s)
        steep = s @ self.slope.T
        goal = self.constant * z0**2 + steep * z0 + np.einsum("nij,nj->ni", bent, s) / 2
        J = np.empty((len(z), k + 1, k + 1), dtype=np.complex128)
        J[:, :k, 0] = t * (2 * self.constant * z0 + steep) - (1 - t) * self.gamma * s
        J[:, :k, 1:] = t[:, None] * (self.slope * z0[:, None] + bent)
        J[:, range(k), range(1, k + 1)] += (1 - t) * self.gamma * (2 * s - z0)
        J[:, k] = self.patch
        return start, goal, J


def _solved(J: Complex, f: Complex) -> Complex:
    """``J^-1 f``, (n, k + 1); NaN for singular matrices."""
    try:
        return np.asarray(np.linalg.solve(J, f[..., None])[..., 0])
    except np.linalg.LinAlgError:
        found = np.full_like(f, np.nan)
        for i, (matrix, right) in enumerate(zip(J, f, strict=True)):
            if np.linalg.cond(matrix) < 1 / np.finfo(np.float64).eps:
                found[i] = np.linalg.solve(matrix, right)
        return found
