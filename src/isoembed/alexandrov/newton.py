"""Inexact Newton's method on the radii with flips, from a nearly flat polytope to the polyhedron.

Three radii are pinned, which fixes the apex: the curvatures do not determine its position.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_array

from isoembed.alexandrov.pins import independent_directions, rough_directions
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.linalg import Dissection, SingularMatrix, Solver, SymmetricFactor, Work, analyze, dissect
from isoembed.linalg.krylov import gmres
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.progress.stages import StageRecorder

STALE = 10  # GMRES iterations: more cost as much as a fresh factorization
GMRES_ITERATIONS = 30
DECREASE = 0.25  # least decrease relative to that of the linear model
MAX_STEPS = 40
LOOSEST = 1e-2  # largest relative residual of the linear equations
CREEPING = 0.9  # ratio of curvatures after and before a slow step: three in a row end the iteration


@dataclass(eq=False)
class Analyses:
    """Symbolic analyses shared by factorizations of ``-d kappa / d r`` on flipped triangulations.

    Attributes
    ----------
    dissection : Dissection
        Nested dissection of the vertices.
    work : Work
        Counter of factorizations.
    last : Solver or None
        Solver for the last triangulation.
    """

    dissection: Dissection
    work: Work
    last: Solver | None = None

    @classmethod
    def of(cls, tables: HalfEdges, work: Work) -> Analyses:
        """Start from any triangulation of a metric."""
        ones = np.ones(tables.corners.size)
        count = int(tables.corners.max()) + 1
        return cls(dissect(vertex_matrix(tables.corners, tables.twins, ones, ones[:count])), work)

    def solver(self, matrix: csc_array) -> Solver:
        """Solver for matrices with the pattern of this one."""
        last = self.last
        if last is None or not (
            np.array_equal(last.pattern.indptr, matrix.indptr)
            and np.array_equal(last.pattern.indices, matrix.indices)
        ):
            del last
            self.last = None  # memory does not suffice for two on large bodies
            order = self.dissection.order_of(matrix)
            self.last = last = analyze(matrix, order, definite=False, work=self.work)
        return last


@dataclass(eq=False)
class Preconditioner:
    """Last factor of a nearby ``-d kappa / d r``, with rows and columns of the pins from the identity.

    It is replaced by new ones: memory does not suffice for two on large bodies.
    """

    solver: Solver
    factor: SymmetricFactor | None = None

    def renew(self, data: Floats) -> None:
        """Factor another matrix of the same triangulation; in double precision if single fails."""
        self.factor = None
        try:
            self.factor = self.solver.factor(data, single=True)
        except SingularMatrix:  # indefinite without pivoting: some pivots of large bodies are small
            self.factor = self.solver.factor(data)

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the last matrix."""
        return self._last.negative_pivots

    def solve(self, b: Floats) -> Floats:
        """Solution for b, (V,) or (V, n), by the last factor without refinement."""
        return self._last.solve(b, sweeps=0)

    @property
    def _last(self) -> SymmetricFactor:
        if self.factor is None:
            raise SingularMatrix("the last matrix had no factors")
        return self.factor


@dataclass(frozen=True, eq=False)
class Solution:
    """Polytope without curvature, with the factor to place it.

    Attributes
    ----------
    polytope : Polytope
    pins : ndarray of int, shape (3,)
        Vertices in linearly independent directions from the apex.
    inverse : Preconditioner
        Factor shared by all solutions on the same triangulation.
    """

    polytope: Polytope
    pins: Indices
    inverse: Preconditioner

    def refactorized(self, p: Polytope) -> Solution:
        """Factor another polytope on the same triangulation, with other lengths and radii."""
        self.inverse.renew(_pinned_matrix(p, self.pins).data)
        return replace(self, polytope=p)

    def solve(self, b: Floats, tolerance: float) -> tuple[Floats, int]:
        """Solution ``(-d kappa / d r)^-1 b`` with zeros at the pins, and the number of iterations.

        Parameters
        ----------
        b : ndarray, shape (V,) or (V, n)
        tolerance : float
            Relative residual.
        """

        def kept_at_pins(v: Floats) -> Floats:
            v[self.pins] = 0.0
            return v

        return gmres(
            lambda v: kept_at_pins(-self.polytope.times_jacobian(v)),
            self.inverse.solve,
            kept_at_pins(b.copy()),
            tolerance,
            GMRES_ITERATIONS,
        )


def newton(
    p: Polytope,
    deficits: Floats,
    analyses: Analyses,
    recorder: StageRecorder,
    enough: Floats | None = None,
) -> Solution | None:
    """Newton's method with three radii pinned, which fixes the apex; None if it does not converge.

    Parameters
    ----------
    p : Polytope
        Polytope near a solution.
    deficits : ndarray, shape (V,)
    analyses : Analyses
    recorder : StageRecorder
    enough : ndarray, shape (V,), optional
        Curvatures at which the iteration may end.
    """
    state, fresh = pinned(p, analyses), True
    forcing, converged, creeping = LOOSEST, False, 0
    for _ in range(MAX_STEPS):
        if enough is not None and (np.abs(p.curvatures) <= enough).all():
            return state
        largest = float(np.abs(p.curvatures).max())
        # Tolerances in radians and relative to the smallest deficit; 1e-13 is rounding.
        converged = largest <= min(1e-9, max(1e-4 * float(deficits.min()), 1e-13))
        size = float(np.linalg.norm(p.curvatures))
        if size == 0:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        renew = iterations > STALE
        tries = 0 if renew and not fresh else 1 if converged else 8
        search = LineSearch(DECREASE, shortest=2.0 ** (1 - tries))
        for fraction in search.parameters():
            q = Polytope.over(p.tables, p.radii + fraction * dr)
            if q is not None and search.accepts(float(np.linalg.norm(q.curvatures)), size, fraction):
                ratio = float(np.linalg.norm(q.curvatures) / size)
                forcing = forcing_term(ratio, LOOSEST)
                creeping = creeping + 1 if ratio > CREEPING else 0
                p, fresh = q, False
                state = replace(state, polytope=p)
                break
        else:
            if converged:  # the rounding floor
                break
            if fresh:
                return None
            state, fresh = _pinned_at(p, state.pins, analyses), True
            continue
        recorder.iterations += 1
        recorder.show(t=0.0, residual=float(np.abs(p.curvatures).max()))
        if creeping == 3 and not converged:  # large flat faces are retriangulated at each step by n^2 flips
            return None
    return state if converged else None


def forcing_term(ratio: float, loosest: float) -> float:
    """Forcing term of inexact Newton: relative residual of the linear equations (Eisenstat and Walker).

    Parameters
    ----------
    ratio : float
        Ratio of the curvatures after and before a step.
    loosest : float
    """
    return float(np.clip(ratio**2, 1e-6, loosest))


def pinned(p: Polytope, analyses: Analyses, directions: Floats | None = None) -> Solution:
    """Pin three radii of a polytope, of any curvatures, and factor the remaining matrix.

    Parameters
    ----------
    p : Polytope
    analyses : Analyses
    directions : ndarray, shape (V, 3), optional
        Directions of the vertices from the apex, if known.

    Raises
    ------
    SingularMatrix
    """
    if directions is None:
        directions = rough_directions(p, analyses.dissection)
    return _pinned_at(p, independent_directions(p, directions), analyses)


def _pinned_at(p: Polytope, pins: Indices, analyses: Analyses) -> Solution:
    matrix = _pinned_matrix(p, pins)
    inverse = Preconditioner(analyses.solver(matrix))
    inverse.renew(matrix.data)
    return Solution(p, pins, inverse)


def _pinned_matrix(p: Polytope, pins: Indices) -> csc_array:
    """``-d kappa / d r`` with the rows and columns of the pins replaced by those of the identity."""
    matrix = p.jacobian()
    matrix.data *= -1
    for pin in pins.tolist():
        column = slice(*matrix.indptr[pin : pin + 2])
        rows = matrix.indices[column]
        for row in rows.tolist():
            across = slice(*matrix.indptr[row : row + 2])
            matrix.data[across][matrix.indices[across] == pin] = 0.0
        matrix.data[column] = rows == pin
    return matrix
