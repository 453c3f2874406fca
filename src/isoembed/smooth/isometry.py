"""Isometry equations of smooth embeddings, ``X_a . X_b = delta_ab``: spherical harmonics, dense Jacobian.

The derivatives X_a are taken along a frame that is orthonormal in the given metric, and the equations are
weighted by its area, which makes them independent of scale and coordinates.

In hyperbolic and spherical space X is in ambient coordinates, the inner product is that of space, and
derivatives of displacements are ``D_a = d_a - (d_a ln w)``.  Translations are not constants there; they are
fixed by the condition that the centroid of the surface, the mean of X over its area, is the origin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import TwoMetric, area_density, orthonormal_frame
from isoembed.space import EUCLIDEAN, Space

OVERSAMPLING = 1.25  # ratio of nodes to coefficients in each direction
SYMMETRIC_ANGLES = 8  # nodes about an axis of symmetry
SEARCH = LineSearch(decrease=0.0, shortest=2.0**-10)
LEVEL = 1.0 + 1e-6  # admissible growth of the error, which is stationary at the minimum
NEAR = 1e-3  # relative step below which the normal equations are kept
REFINEMENTS = 2  # steps of iterative refinement of displacements


@dataclass(frozen=True)
class MetricSamples:
    """Metric at the nodes of a Gauss rule.

    Attributes
    ----------
    u : ndarray, shape (n, 3)
    areas : ndarray, shape (n,)
        Areas of the nodes, which sum to the area of the surface.
    frames : ndarray, shape (n, 2, 3)
        Tangent vectors, orthonormal in the metric, with outward cross product.
    """

    u: Floats
    areas: Floats
    frames: Floats

    @classmethod
    def of(cls, metric: TwoMetric, n: int, angles: int) -> MetricSamples:
        """Sample on `n` circles of latitude with `angles` nodes each."""
        u, weights = gauss_rule(n, angles)
        q = metric.tensor(u)
        return cls(u, weights * area_density(q), orthonormal_frame(u, q))


def around(n: int, harmonics: Harmonics) -> int:
    """Number of nodes on each of n circles of latitude: few about an axis of symmetry."""
    return SYMMETRIC_ANGLES if harmonics.order < harmonics.degree else 2 * n


class Tangents(NamedTuple):
    """Derivatives of a map along frames at points of a space.

    Attributes
    ----------
    vectors, lowered : ndarray, shape (n, 2, 3)
        Derivatives of the ambient coordinates, and these with the index lowered by the metric of space.
    drift : ndarray, shape (n, 2)
        Derivatives of -ln w; zero in Euclidean space.
    """

    vectors: Floats
    lowered: Floats
    drift: Floats

    @property
    def strains(self) -> Floats:
        """``X_a . X_b - delta_ab`` (n, 3), as 11, sqrt(2) 12, 22."""
        (first, second), (lower, other) = np.moveaxis(self.vectors, 1, 0), np.moveaxis(self.lowered, 1, 0)
        return np.stack(
            [
                np.einsum("ni,ni->n", first, lower) - 1.0,
                np.sqrt(2.0) * np.einsum("ni,ni->n", first, other),
                np.einsum("ni,ni->n", second, other) - 1.0,
            ],
            axis=1,
        )


def tangents_in(space: Space, points: Floats, vectors: Floats) -> Tangents:
    """Tangents from derivatives (n, 2, 3) at points (n, 3) in curved space; NaN beyond the hemisphere."""
    k = space.curvature
    square = 1.0 - k * np.einsum("ni,ni->n", points, points)
    drift = k * np.einsum("ni,nai->na", points, vectors) / np.where(square > 0.0, square, np.nan)[:, None]
    return Tangents(vectors, vectors + drift[:, :, None] * points[:, None, :], drift)


def check_start(error: float) -> None:
    """Check that the strains of an initial map are finite.

    Raises
    ------
    InvalidParameter
        The map leaves the hemisphere about the origin.
    """
    if not np.isfinite(error):
        raise InvalidParameter("the starting points are not all in the hemisphere about the origin")


def flat_tangents(vectors: Floats) -> Tangents:
    """Tangents from derivatives (n, 2, 3) in Euclidean space, independent of the points."""
    return Tangents(vectors, vectors, np.zeros(vectors.shape[:2]))


def strains(tangents: Floats) -> Floats:
    """``X_a . X_b - delta_ab`` (n, 3), as 11, sqrt(2) 12, 22, of derivatives (n, 2, 3) in Euclidean space."""
    return flat_tangents(tangents).strains


@dataclass(frozen=True)
class IsometrySystem:
    """Equations X_a . X_b = delta_ab, or with another right-hand side, at the nodes of a rule.

    Attributes
    ----------
    unit : float
        Unit of length of the equations: the radius of the sphere with the area of the metric.
    Y : ndarray, shape (n, m)
        Harmonics without the constant one, which is a translation.
    B : ndarray, shape (n, 2, m)
        Their derivatives along the frames.
    root : ndarray, shape (n,)
        Square roots of the fractions of the area at the nodes.
    space : Space
        Ambient space, in that unit.
    """

    unit: float
    Y: Floats
    B: Floats
    root: Floats
    space: Space = EUCLIDEAN

    @classmethod
    def of(cls, harmonics: Harmonics, samples: MetricSamples, space: Space = EUCLIDEAN) -> IsometrySystem:
        """Evaluate the harmonics at the nodes."""
        unit = float(np.sqrt(samples.areas.sum() / (4.0 * np.pi)))
        Y, B = harmonics.along(samples.u, samples.frames)
        root = np.sqrt(samples.areas / samples.areas.sum())
        return cls(unit, Y[:, 1:], unit * B[:, :, 1:], root, space.scaled(1.0 / unit))

    def solved(self, coefficients: Floats, stretch: Floats | float = 0.0) -> Floats:
        """Coefficients (size, 3) of X near given ones, by least squares of the strains minus a stretch.

        The stretch (n, 3), or 0, has the form of `strains`.  In Euclidean space the constant harmonic keeps
        its coefficients.
        """
        constant, C = coefficients[:1], coefficients[1:] / self.unit
        error, tangents, residuals = self._strained(C, stretch)
        check_start(error)
        before, solve, fresh = np.inf, None, True
        for _ in range(30):
            fresh = solve is None
            if solve is None:
                solve = self._normal_equations(C, tangents)
            step = solve(-self._gradient(tangents, residuals))
            size = float(np.linalg.norm(step) / np.linalg.norm(C))
            if size > 0.3 * before and not (fresh and size > NEAR):  # steps must decrease with old equations
                # The equations of an earlier step are outdated; if they are new, the rest is rounding.
                if fresh:
                    break
                before, solve = np.inf, None
                continue
            for length in SEARCH.parameters():
                trial = C + length * step
                attained, new_tangents, new_residuals = self._strained(trial, stretch)
                if SEARCH.accepts(attained, LEVEL * error, length):
                    break
            else:
                break
            stalled = attained > max(0.9 * error, 1e-3)  # slow convergence
            C, error, tangents, residuals = trial, attained, new_tangents, new_residuals
            if size < 1e-13 or stalled:  # rounding
                break
            before = size if length == 1.0 else np.inf
            if size > NEAR:
                solve = None
        if not self.space.is_euclidean:
            constant = -np.sqrt(4.0 * np.pi) * self.unit * (self.root**2 @ self.Y @ C)[None]
        return np.concatenate([constant, self.unit * C])

    def deformations(self, coefficients: Floats, strains: Floats) -> Floats:
        """First-order changes (k, size, 3) of the coefficients of X for changes (k, n, 3) of the strains.

        They are free of translations and rotations.
        """
        C = coefficients[1:] / self.unit
        tangents = self._tangents(C)
        solve = self._normal_equations(C, tangents)
        changes = np.zeros((len(strains), len(coefficients), 3))
        for k, strain in enumerate(strains):
            residuals = self.root[:, None] * strain
            changes[k, 1:] = self.unit * solve(self._gradient(tangents, residuals))
        return changes

    def linearized(self, coefficients: Floats) -> LinearizedStrains:
        """Strains linearized at X in R^3, with coefficients (size, 3)."""
        C = coefficients[1:] / self.unit
        tangents = self._tangents(C)
        return LinearizedStrains(self, tangents, self._turns(C), self._normal_equations(C, tangents))

    @cached_property
    def _centered(self) -> Floats:
        """Harmonics (n, m) minus their means over the area."""
        return self.Y - self.root**2 @ self.Y

    def _tangents(self, C: Floats) -> Tangents:
        vectors = self.B @ C
        if self.space.is_euclidean:
            return flat_tangents(vectors)
        return tangents_in(self.space, self._centered @ C, vectors)

    def _derivatives(self, tangents: Tangents) -> Floats:
        """Derivatives D_a (n, 2, m) of displacements."""
        if self.space.is_euclidean:
            return self.B
        return self.B + tangents.drift[:, :, None] * self._centered[:, None, :]

    def _strained(self, C: Floats, stretch: Floats | float) -> tuple[float, Tangents, Floats]:
        tangents = self._tangents(C)
        residuals = self.root[:, None] * (tangents.strains - stretch)
        return float(np.linalg.norm(residuals)), tangents, residuals

    def _gradient(self, tangents: Tangents, residuals: Floats) -> Floats:
        """Half the gradient (m, 3) of the sum of squared weighted strains in the coefficients."""
        r = self.root[:, None] * residuals
        X1, X2 = tangents.lowered[:, 0], tangents.lowered[:, 1]
        across = np.sqrt(2.0) * r[:, 1, None]
        first, second = 2.0 * r[:, 0, None] * X1 + across * X2, 2.0 * r[:, 2, None] * X2 + across * X1
        D = self._derivatives(tangents)
        return np.asarray(D[:, 0].T @ first + D[:, 1].T @ second)

    def _normal_equations(self, C: Floats, tangents: Tangents) -> Callable[[Floats], Floats]:
        """Solver of the normal equations, for right-hand sides and solutions (m, 3).

        Normal equations lose half of the digits, which further steps recover.
        """
        J, turns = self._jacobian(tangents), self._turns(C)
        solve = normal_solver(J.T @ J + turns.T @ turns)
        return lambda right: solve(right.T.reshape(-1, 1)).reshape(3, -1).T

    def _jacobian(self, tangents: Tangents) -> Floats:
        """Jacobian (3 n, 3 m) of the weighted strains with respect to the coefficients of x, y and z."""
        D = self.root[:, None, None] * self._derivatives(tangents)
        return strain_rates(*np.moveaxis(tangents.lowered, 1, 0), *np.moveaxis(D, 1, 0))

    def _turns(self, C: Floats) -> Floats:
        """Rows (3, 3 m) whose products with steps without rotation vanish."""
        X = (self.Y if self.space.is_euclidean else self._centered) @ C
        X = X / np.sqrt(np.einsum("ni,ni,n->", X, X, self.root**2))
        moments = (self.root[:, None] ** 2 * X).T @ self.Y  # (3, m)
        rows = np.zeros((3, 3, self.Y.shape[1]))
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            rows[k, j], rows[k, i] = moments[i], -moments[j]
        return rows.reshape(3, -1)


def strain_rates(X1: Floats, X2: Floats, first: Floats, second: Floats) -> Floats:
    """Jacobian (3 n, 3 m) of the strains of tangents (n, 3) with respect to the coefficients of x, y and z.

    The derivatives (n, m) of the harmonics along both directions may be weighted.
    """
    J = np.empty((3, len(X1), 3, first.shape[1]))
    for i in range(3):
        x1, x2 = X1[:, i, None], X2[:, i, None]
        J[0, :, i] = 2.0 * x1 * first
        J[1, :, i] = np.sqrt(2.0) * (x1 * second + x2 * first)
        J[2, :, i] = 2.0 * x2 * second
    return J.reshape(-1, 3 * first.shape[1])


def normal_solver(normal: Floats) -> Callable[[Floats], Floats]:
    """Solver of normal equations, for right-hand sides and solutions (k, r); overwrites the matrix."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    normal *= scale[:, None] * scale
    normal[np.diag_indices_from(normal)] += len(normal) * np.finfo(np.float64).eps
    factor = cho_factor(normal, overwrite_a=True)
    return lambda right: np.asarray(scale[:, None] * cho_solve(factor, scale[:, None] * right))


@dataclass(frozen=True, eq=False)
class LinearizedStrains:
    """Linearized strains of a surface in R^3 under displacements without translation and rotation.

    Attributes
    ----------
    system : IsometrySystem
    tangents : Tangents
        Tangents of the surface.
    turns : ndarray, shape (3, 3 m)
        Rows whose products with steps without rotation vanish.
    solve : callable
        Approximate solver of the normal equations.
    """

    system: IsometrySystem
    tangents: Tangents
    turns: Floats
    solve: Callable[[Floats], Floats]

    def displacements(self, strains: Floats) -> tuple[Floats, float]:
        """Least-squares displacements (size, 3) for given strains (n, 3), and the relative residual."""
        wanted = self.system.root[:, None] * strains
        d = self.solve(self._adjoint(wanted))
        for _ in range(REFINEMENTS):
            d = d + self.solve(self._adjoint(wanted - self._rates(d)))
        size = max(float(np.linalg.norm(wanted)), float(np.finfo(float).tiny))
        left = float(np.linalg.norm(wanted - self._rates(d))) / size
        return self.system.unit * np.concatenate([np.zeros((1, 3)), d]), left

    def by_strains(self, gradient: Floats) -> Floats:
        """Derivatives (n, 3) with respect to the strains from those for the coefficients (size, 3)."""
        g = self.system.unit * gradient[1:]
        z = self.solve(g)
        for _ in range(REFINEMENTS):
            z = z + self.solve(g - self._normal(z))
        return self.system.root[:, None] * self._rates(z)

    def _rates(self, d: Floats) -> Floats:
        """Weighted strains (n, 3) of displacements (m, 3)."""
        (X1, X2), (d1, d2) = (np.moveaxis(each, 1, 0) for each in (self.tangents.vectors, self.system.B @ d))
        rates = [
            2.0 * np.einsum("ni,ni->n", X1, d1),
            np.sqrt(2.0) * (np.einsum("ni,ni->n", X1, d2) + np.einsum("ni,ni->n", X2, d1)),
            2.0 * np.einsum("ni,ni->n", X2, d2),
        ]
        return self.system.root[:, None] * np.stack(rates, axis=1)

    def _adjoint(self, r: Floats) -> Floats:
        return self.system._gradient(self.tangents, r)

    def _normal(self, z: Floats) -> Floats:
        turned = (self.turns.T @ (self.turns @ z.T.ravel())).reshape(3, -1).T
        return np.asarray(self._adjoint(self._rates(z)) + turned)
