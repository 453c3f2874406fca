"""Regularized energy: squared length errors plus mu times squared distance from a smooth surface.

For negative curvature, many surfaces have nearly the same lengths, and plain Newton steps wander among them.
The energy

    ``|r|^2 + mu (|R x|^2 + w |K x|^2)``

is minimized instead, with the errors r of the lengths.  R takes each vertex to its difference from a cubic
fitted to its neighbors, which vanishes for smooth surfaces of any shape to fourth order in the edge length.
K, the cotangent Laplacian, takes x to its mean curvature; it is stiffer at intermediate wavelengths but would
flatten the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import cached_property
from typing import Self

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix, SymmetricFactor, Work
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.local_fit import edge_lengths_about
from isoembed.surface.measures import face_areas
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import edge_rows, length_residuals
from isoembed.surface.smoothness import fit_residuals
from isoembed.surface.vertex_system import HeldTriangle, VertexSystem

LEAST_COTANGENT = 0.01  # smaller weights would favor bending, or fold a harmonic surface
MAX_ITERATIONS = 100  # conjugate gradient iterations


class RegularizedEnergy:
    """The energy ``|r|^2 + mu (|R x|^2 + w |K x|^2)`` of surfaces with the triangles of a metric.

    In hyperbolic and spherical space x are points on the hyperboloid or sphere, of a surface centered on the
    origin.  The unknowns of steps are the z of `isoembed.surface.projected`, without isometries, which change
    the penalties only.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric, which determines K.
    vertices : ndarray, shape (V, 3)
        A surface close enough for its charts to be valid, which determines R.
    work : Work, optional
        Counter of factorizations.

    Attributes
    ----------
    unit : float
        The mean edge length.
    """

    def __init__(self, metric: PolyhedralMetric, vertices: Floats, work: Work | None = None) -> None:
        self._work = work
        units = edge_lengths_about(metric.triangulation, metric.lengths)
        self._set_penalties(metric, vertices, units, metric.mean_length)

    def _set_penalties(
        self, metric: PolyhedralMetric, vertices: Floats, units: Floats, mean_length: float
    ) -> None:
        """Set R and K for edge lengths around each vertex, (V,), and the mean edge length."""
        self.triangulation, self.unit, self._units = metric.triangulation, mean_length, units
        self.space = metric.space
        self._edge_weights: Floats | None = None
        laplacian = cotangent_laplacian(GluedMetric.of(metric), least=LEAST_COTANGENT)
        K = csr_array(laplacian / (2.9 * mean_length))  # mean edge lengths; K has the magnitude of R
        self._KK = csr_array(K.T @ K)
        self._regularize_by(fit_residuals(self.triangulation, vertices))

    @cached_property
    def _system(self) -> VertexSystem:
        return VertexSystem(self.triangulation, self._KK, self._work)

    @cached_property
    def _newton_system(self) -> VertexSystem:
        return VertexSystem(self.triangulation, csr_array(self._RT @ self._R), self._work)

    def finer(self, vertices: Floats) -> RegularizedEnergy:
        """Energy with quintic fits in the charts of these vertices, applied twice, instead of R."""
        return self._fitted_twice(vertices, 5)

    def weighted(self, weights: Floats) -> Self:
        """Energy with a weight for each length error, (E,), in the residuals."""
        other = copy(self)
        other._edge_weights = weights
        return other

    def coarser(self, vertices: Floats) -> RegularizedEnergy:
        """Energy with cubic fits in the charts of these vertices, applied twice."""
        return self._fitted_twice(vertices, 3)

    def _fitted_twice(self, vertices: Floats, degree: int) -> RegularizedEnergy:
        other = copy(self)
        residuals = fit_residuals(self.triangulation, vertices, degree)
        other._regularize_by(csr_array(residuals @ residuals))
        return other

    def _regularize_by(self, residuals: csr_array) -> None:
        """Set R to residuals of fits, with rows normalized relative to the local edge length."""
        size = self._units * np.sqrt(residuals.multiply(residuals).sum(axis=1))
        self._R = csr_array(diags_array(1 / np.where(size > 0, size, 1.0)) @ residuals)
        self._RT = csr_array(self._R.T)

    @property
    def fit_residuals(self) -> csr_array:
        """R, shape (V, V)."""
        return self._R

    @property
    def fit_residuals_transposed(self) -> csr_array:
        """R^T, shape (V, V)."""
        return self._RT

    def roughness(self, vertices: Floats, w: float) -> Floats:
        """``(R^T R + w K^T K) x``, shape (V, 3): half the gradient of the penalty."""
        return self._RT @ (self._R @ vertices) + w * (self._KK @ vertices)

    def residuals(self, vertices: Floats, lengths: Floats) -> Floats:
        """The errors r of the lengths."""
        r = length_residuals(self.triangulation, vertices, lengths, self.space)
        return r if self._edge_weights is None else self._edge_weights * r

    def _rows(self, vertices: Floats, lengths: Floats) -> Floats:
        rows = edge_rows(self.triangulation, vertices, lengths, self.space)
        return rows if self._edge_weights is None else self._edge_weights[:, None] * rows

    def rates(self, vertices: Floats, lengths: Floats, motion: Floats) -> Floats:
        """``J d``, shape (E,): rates of change of the lengths for a motion d, (V, 3)."""
        a, b = self.triangulation.edges.T
        bent = motion / self.space.heights(vertices)[:, None]
        rows = self._rows(vertices, lengths)
        return np.einsum("ij,ij->i", rows, bent[a] - bent[b])

    def forces(self, vertices: Floats, lengths: Floats, tensions: Floats) -> Floats:
        """``J^T y``, shape (V, 3): the total force at each vertex of edges with tensions y, (E,)."""
        rows = self._rows(vertices, lengths)
        forces = self.triangulation.incidence @ (rows * tensions[:, None])
        return forces / self.space.heights(vertices)[:, None]

    def value(self, vertices: Floats, lengths: Floats, mu: float) -> float:
        """``|r|^2 + mu |R x|^2``."""
        r = self.residuals(vertices, lengths)
        return float(r @ r + mu * np.sum(vertices * self.roughness(vertices, 0.0)))

    def solver(
        self, vertices: Floats, lengths: Floats, mu: float, w: float, tensions: Floats | float = 0.0
    ) -> Callable[[Floats], Floats]:
        """Prepare to solve ``(J^T J + S + mu (R^T R + w K^T K)) d = g`` for d, (V, 3).

        The matrix with K in place of R, which is far sparser, is factored as a preconditioner: a few
        iterations of conjugate gradients suffice.  S is the Laplacian weighted by the tensions of the edges,
        (E,): ``r / l`` for Newton's method, 0 for the Gauss-Newton method.

        Raises
        ------
        SingularMatrix
            It is not positive definite to working precision.
        """
        triangulation, surface = self.triangulation, Projected.of(self.space, vertices)
        rows = self._rows(vertices, lengths)
        # Weight of |K x|^2 in place of |R x|^2.
        factor = self._system.penalized(rows, mu * (w + 0.5), surface, tensions)
        fixed = surface.without_isometries()
        a, b = triangulation.edges.T

        def product(d: Floats) -> Floats:
            z = d.reshape(-1, 3)
            grown = z[a] - z[b]
            stretch = np.einsum("ij,ij->i", rows, grown)
            pull = surface.motion(mu * self.roughness(surface.motion(z), w))
            forces = rows * stretch[:, None] + (tensions * grown.T).T
            return fixed((triangulation.incidence @ forces + pull).ravel())

        n = 3 * triangulation.n_vertices
        matrix = LinearOperator((n, n), matvec=product, dtype=np.float64)
        inverse = LinearOperator((n, n), matvec=lambda g: fixed(factor.solve(g, sweeps=0)), dtype=np.float64)

        def solve(gradient: Floats) -> Floats:
            with np.errstate(all="ignore"):  # an ill-conditioned matrix gives NaN
                d = cg(
                    matrix,
                    fixed(surface.motion(gradient).ravel()),
                    rtol=1e-3,
                    M=inverse,
                    maxiter=MAX_ITERATIONS,
                )[0].reshape(-1, 3)
            if not np.isfinite(d).all():
                raise SingularMatrix("conjugate gradients broke down")
            return surface.motion(d)

        return solve

    def quiet_triangle(self, vertices: Floats, lengths: Floats) -> Indices:
        """The corners, (3,), of the triangle with the smallest residuals, among the larger half."""
        faces, residuals = self.triangulation.faces, np.abs(self.residuals(vertices, lengths))
        areas = face_areas(faces, vertices)
        around = residuals[self.triangulation.face_edges].sum(axis=1)
        return np.asarray(faces[np.argmin(np.where(areas < np.median(areas), np.inf, around))])

    def newton_factor(
        self, vertices: Floats, lengths: Floats, mu: float, tensions: Floats, clamped: HeldTriangle
    ) -> SymmetricFactor:
        """Factor ``J^T J + S + mu R^T R``, half the Hessian in Euclidean space.

        S is as in `solver`.  A triangle fixes rigid motions.

        Raises
        ------
        SingularMatrix
            It is not positive definite to working precision.
        """
        rows = edge_rows(self.triangulation, vertices, lengths)
        return self._newton_system.penalized(rows, mu, tensions=tensions, clamped=clamped)

    def solved(self, vertices: Floats, lengths: Floats, gradient: Floats, mu: float, w: float) -> Floats:
        """Solve the equations of `solver` for one gradient; raises SingularMatrix."""
        return self.solver(vertices, lengths, mu, w)(gradient)

    def step(
        self,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        w: float,
        recorder: StageRecorder,
        stiffness: float = 1.0,
    ) -> tuple[Floats, bool]:
        """One Gauss-Newton step, and whether it goes downhill.

        Parameters
        ----------
        vertices : ndarray, shape (V, 3)
        lengths : ndarray, shape (E,)
        mu, w : float
        recorder : StageRecorder
        stiffness : float
            Factor of mu in the matrix, which shortens soft motions.
        """

        def measured(x: Floats) -> tuple[Floats, Floats, float]:
            r, pull = self.residuals(x, lengths), self.roughness(x, w)
            return r, pull, float(r @ r + mu * np.sum(x * pull))

        r, pull, energy = measured(vertices)
        gradient = self.forces(vertices, lengths, r) + mu * pull
        recorder.iterations += 1
        try:
            trial = vertices - self.solved(vertices, lengths, gradient, stiffness * mu, w)
        except SingularMatrix:
            return vertices, False
        r, _, reached = measured(trial)
        recorder.show(residual=float(np.abs(r).max()))
        return trial, bool(reached <= energy)

    def relaxed(
        self, vertices: Floats, lengths: Floats, mu: float, w: float, recorder: StageRecorder
    ) -> Floats:
        """A step that does not increase the energy, however short; the vertices themselves if none exists."""
        for stiffness in (1.0, 2.0, 11.0, 101.0):  # tried until a step goes downhill
            trial, downhill = self.step(vertices, lengths, mu, w, recorder, stiffness)
            if downhill:
                return trial
        return vertices

    def minimized(
        self,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        share: float,
        max_iterations: int,
        recorder: StageRecorder,
        exhausted: Callable[[], bool] = lambda: False,
    ) -> Floats:
        """The local minimum, by `relaxed` steps as long as they lower the energy by more than a share."""
        value = self.value(vertices, lengths, mu)
        for _ in range(max_iterations):
            vertices = self.relaxed(vertices, lengths, mu, 0.0, recorder)
            before, value = value, self.value(vertices, lengths, mu)
            if exhausted() or not value < (1 - share) * before:
                break
        return vertices
