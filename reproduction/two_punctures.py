"""Slices with two black holes in motion along their axis: Bowen and York's, by a spectral method.

M. Ansorg, B. Bruegmann and W. Tichy, arXiv:gr-qc/0404056, in the prolate coordinates that theirs are made of:
xi = (r_+ + r_-) / d and mu = (r_- - r_+) / d, r_+ and r_- the distances from the holes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from isoembed.relativity import ThreeGeometry
from reproduction.arrays import Floats

DEGREES = 28  # along t = 1 / xi and along mu
STEPS = 20  # of Newton's method, which needs 3 to 6


@dataclass(frozen=True, eq=False)
class TwoPunctures(ThreeGeometry):
    """The slice ``gamma_ij = psi^4 delta_ij``, ``K_ij = psi^-2 A_ij`` of two holes at z = d / 2 and - d / 2.

    ``psi = 1 + sum_k m_k / (2 r_k) + u``, and the constraint is ``Laplace(u) = - A_ij A_ij psi^-7 / 8``.

    Attributes
    ----------
    masses, momenta : tuple of two floats
        m_k and P_k along z, of the hole at d / 2 first; a mass may be 0 if its momentum is.
    distance : float
        d.
    coefficients : ndarray
        Of u / t in Legendre polynomials of 2 t - 1 and of mu.
    source : float
        The integral of ``A_ij A_ij psi^-7`` over 16 pi.
    """

    masses: tuple[float, float]
    momenta: tuple[float, float]
    distance: float
    coefficients: Floats
    source: float

    @classmethod
    def solved(
        cls,
        masses: tuple[float, float],
        momenta: tuple[float, float],
        distance: float,
        degrees: int = DEGREES,
    ) -> TwoPunctures:
        """The slice, by collocation at Gauss's nodes and Newton's method.

        In t and mu, ``r_+ r_- Laplace(u)`` is ``t^2 ((1 - t^2) u_t)_t + ((1 - mu^2) u_mu)_mu``.
        It is singular at all ends: polynomials pick the solution that is regular there, and 0 at infinity.
        """
        x, weights = legendre.leggauss(degrees)
        t, mu = 0.5 * (x[:, None] + 1), x
        values, first, second = _polynomials(x)
        radial = t * ((1 - t**2) * (4 * first + 4 * t * second) - 2 * t * (values + 2 * t * first))
        angular = (1 - mu**2)[:, None] * second - 2 * mu[:, None] * first
        operator = np.kron(radial, values) + np.kron(values, angular)  # on u / t, over t
        to_u = np.kron(t * values, values)

        rho = 0.5 * distance * np.sqrt((1 / t**2 - 1) * (1 - mu**2))
        points = np.stack([rho, 0 * rho, 0.5 * distance * mu / t], axis=-1).reshape(-1, 3)
        empty = cls(masses, momenta, distance, np.zeros((degrees, degrees)), 0.0)
        static = empty.conformal_factor(points)
        r = np.prod(empty.distances(points), axis=0)
        A = empty.conformal_curvature(points)
        source = r * np.einsum("nij,nij->n", A, A) / 8
        over_t = np.repeat(t, degrees)
        c = np.zeros(degrees**2)
        for _ in range(STEPS):
            psi = static + to_u @ c
            slope = operator - (7 * source / over_t * psi**-8)[:, None] * to_u
            change = np.linalg.solve(slope, -operator @ c - source / over_t * psi**-7)
            c += change
            if np.abs(change).max() < 1e-14 * np.abs(c).max(initial=1e-300):
                break
        psi = static + to_u @ c
        density = (source * psi**-7).reshape(degrees, degrees) / t**2  # over xi, dxi = dt / t^2
        integral = distance * 0.25 * float(weights @ density @ weights)
        return cls(masses, momenta, distance, c.reshape(degrees, degrees), integral)

    @property
    def time_symmetric(self) -> bool:
        """Whether the holes are at rest."""
        return not any(self.momenta)

    @property
    def black_holes(self) -> tuple[tuple[float, tuple[float, float, float]], ...]:
        """The mass and the place of each, from which horizons are searched."""
        places = ((0.0, 0.0, 0.5 * self.distance), (0.0, 0.0, -0.5 * self.distance))
        return tuple((m, place) for m, place in zip(self.masses, places, strict=True) if m)

    @property
    def mass(self) -> float:
        """The mass at infinity, by the integral of the source."""
        return sum(self.masses) + self.source

    @property
    def mass_by_falloff(self) -> float:
        """The same by the falloff of psi along the axis, ``1 + M / (2 r)``; there u has logarithms."""
        at_infinity = legendre.legvander(np.array([-1.0]), len(self.coefficients) - 1)[0]
        return sum(self.masses) + self.distance * float((at_infinity @ self.coefficients).sum())

    @property
    def puncture_masses(self) -> tuple[float, float]:
        """The masses at the other ends of the holes, ``m_1 (1 + u_1 + m_2 / (2 d))``."""
        at = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]) * self.distance
        (m, n), (u, v), d = self.masses, self.correction(at), self.distance
        return float(m * (1 + u + n / (2 * d))), float(n * (1 + v + m / (2 * d)))

    def distances(self, x: Floats) -> tuple[Floats, Floats]:
        """r_+ and r_- (n,) at points x (n, 3)."""
        above, below = (np.linalg.norm(x - z * self._axis, axis=1) for z in (1, -1))
        return above, below

    def correction(self, x: Floats) -> Floats:
        """The function u (n,)."""
        t, along, across = self._expanded(*self.distances(x))
        return np.asarray(t * np.einsum("nj,nj->n", along @ self.coefficients, across))

    def conformal_factor(self, x: Floats) -> Floats:
        """The function psi (n,)."""
        (above, below), (m, n) = self.distances(x), self.masses
        return np.asarray(1 + 0.5 * m / above + 0.5 * n / below + self.correction(x))

    def gradient(self, x: Floats) -> Floats:
        """``d_k gamma_ij`` (n, 3, 3, 3)."""
        (above, below), (m, n), c = self.distances(x), self.masses, self.coefficients
        d_above, d_below = (x - self._axis) / above[:, None], (x + self._axis) / below[:, None]
        t, along, across = self._expanded(above, below)
        u_over_t = np.einsum("nj,nj->n", along @ c, across)
        by_t = u_over_t + 2 * t * np.einsum("nj,nj->n", along[:, :-1] @ legendre.legder(c), across)
        by_mu = t * np.einsum("nj,nj->n", along @ legendre.legder(c, axis=1), across[:, :-1])
        by_above = -0.5 * m / above**2 - (by_t * t**2 + by_mu) / self.distance
        by_below = -0.5 * n / below**2 - (by_t * t**2 - by_mu) / self.distance
        psi = 1 + 0.5 * m / above + 0.5 * n / below + t * u_over_t
        slopes = 4 * psi[:, None] ** 3 * (by_above[:, None] * d_above + by_below[:, None] * d_below)
        return np.asarray(slopes[:, :, None, None] * np.eye(3))

    def _expanded(self, above: Floats, below: Floats) -> tuple[Floats, Floats, Floats]:
        """The coordinate t = 1 / xi (n,), and the polynomials in 2 t - 1 and in mu (n, degrees)."""
        t, mu = self.distance / (above + below), (below - above) / self.distance
        n = len(self.coefficients) - 1
        along, across = (np.asarray(legendre.legvander(x, n), dtype=np.float64) for x in (2 * t - 1, mu))
        return t, along, across

    @property
    def _axis(self) -> Floats:
        """The place of the upper hole."""
        return np.array([0.0, 0.0, 0.5 * self.distance])

    def conformal_curvature(self, x: Floats) -> Floats:
        """``A_ij`` (n, 3, 3), the sum of ``3 / (2 r^2) (P_i n_j + n_i P_j - (delta_ij - n_i n_j) P . n)``."""
        A, axis = np.zeros((len(x), 3, 3)), np.array([0.0, 0.0, 1.0])
        for P, z, distances in zip(self.momenta, (1, -1), self.distances(x), strict=True):
            r = distances[:, None, None]
            n = (x - z * self._axis)[:, :, None] / r
            mixed = n * axis
            A += 1.5 * P / r**2 * (mixed + mixed.transpose(0, 2, 1))
            A -= 1.5 * P / r**2 * n[:, 2:] * (np.eye(3) - n * n.transpose(0, 2, 1))
        return A

    def metric(self, x: Floats) -> Floats:
        """``gamma_ij`` (n, 3, 3)."""
        return (self.conformal_factor(x) ** 4)[:, None, None] * np.eye(3)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """``K_ij`` (n, 3, 3)."""
        return self.conformal_curvature(x) / (self.conformal_factor(x) ** 2)[:, None, None]

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """What a quantity loses without the two highest degrees of u."""
        c = self.coefficients.copy()
        c[-2:], c[:, -2:] = 0, 0
        return np.asarray(quantity(replace(self, coefficients=c)) - quantity(self))


def _polynomials(x: Floats) -> tuple[Floats, Floats, Floats]:
    """Legendre polynomials at as many points, and their first two derivatives."""
    n = len(x)
    values = np.asarray(legendre.legvander(x, n - 1), dtype=np.float64)
    slopes = np.vstack([legendre.legder(np.eye(n)), np.zeros((1, n))]).astype(np.float64)
    return values, values @ slopes, values @ slopes @ slopes
