"""Newton's method on the radii with flips, from a nearly flat polytope to the polyhedron.

Three radii are pinned, which fixes the apex: it may move, so the curvatures do not determine it.
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
DECREASE = 0.25  # least decrease over that of the linear model
MAX_STEPS = 40
LOOSEST = 1e-2  # largest residual of the linear equations, relative
CREEPING = 0.9  # share of the curvatures that a step leaves: three such in a row end the iteration


@dataclass(eq=False)
class Analyses:
    """Analyses that factorizations of ``-d kappa / d r`` share while the triangles are flipped.

    Attributes
    ----------
    dissection : Dissection
        Of the vertices.
    work : Work
        Counts the factorizations.
    last : Solver or None
        Of the last triangles.
    """

    dissection: Dissection
    work: Work
    last: Solver | None = None

    @classmethod
    def of(cls, tables: HalfEdges, work: Work) -> Analyses:
        """Begin with any triangles of a metric."""
        ones = np.ones(tables.corners.size)
        count = int(tables.corners.max()) + 1
        return cls(dissect(vertex_matrix(tables.corners, tables.twins, ones, ones[:count])), work)

    def solver(self, matrix: csc_array) -> Solver:
        """The solver of matrices like this one."""
        last = self.last
        if last is None or not (
            np.array_equal(last.pattern.indptr, matrix.indptr)
            and np.array_equal(last.pattern.indices, matrix.indices)
        ):
            del last
            self.last = None  # large bodies have no room for two
            order = self.dissection.order_of(matrix)
            self.last = last = analyze(matrix, order, definite=False, work=self.work)
        return last


@dataclass(eq=False)
class Preconditioner:
    """The last factor of ``-d kappa / d r`` nearby, rows and columns of the pins replaced by the identity's.

    A new one takes its place: large bodies have no room for two.
    """

    solver: Solver
    factor: SymmetricFactor | None = None

    def renew(self, data: Floats) -> None:
        """Factor another matrix of the same triangles; in double precision where single loses it."""
        self.factor = None
        try:
            self.factor = self.solver.factor(data, single=True)
        except SingularMatrix:  # pivots of both signs are not exchanged, and of large bodies some are small
            self.factor = self.solver.factor(data)

    @property
    def negative_pivots(self) -> int:
        """Negative eigenvalues of the last matrix."""
        return self._last.negative_pivots

    def solve(self, b: Floats) -> Floats:
        """Solution for b, (V,) or (V, n), with the last factor and no refinement."""
        return self._last.solve(b, sweeps=0)

    @property
    def _last(self) -> SymmetricFactor:
        if self.factor is None:
            raise SingularMatrix("the last matrix had no factors")
        return self.factor


@dataclass(frozen=True, eq=False)
class Solution:
    """A polytope without curvature, and the means to place it.

    Attributes
    ----------
    polytope : Polytope
    pins : ndarray of int, shape (3,)
        Vertices in independent directions from the apex.
    inverse : Preconditioner
        Shared by all solutions that follow from one another without flips.
    """

    polytope: Polytope
    pins: Indices
    inverse: Preconditioner

    def refactorized(self, p: Polytope) -> Solution:
        """Factor another polytope of the same triangles, lengths and radii being others."""
        self.inverse.renew(_pinned_matrix(p, self.pins).data)
        return replace(self, polytope=p)

    def solve(self, b: Floats, tolerance: float) -> tuple[Floats, int]:
        """``(-d kappa / d r)^-1 b`` with the pins left at zero; and the iterations that it took.

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
        Near to a solution.
    deficits : ndarray, shape (V,)
    analyses : Analyses
    recorder : StageRecorder
    enough : ndarray, shape (V,), optional
        Curvatures at which it may end before they vanish.
    """
    state, fresh = pinned(p, analyses), True
    forcing, done, creeping = LOOSEST, False, 0
    for _ in range(MAX_STEPS):
        if enough is not None and (np.abs(p.curvatures) <= enough).all():
            return state
        largest = float(np.abs(p.curvatures).max())
        # Radians, and in units of the smallest deficit; 1e-13 is rounding.
        done = largest <= min(1e-9, max(1e-4 * float(deficits.min()), 1e-13))
        size = float(np.linalg.norm(p.curvatures))
        if size == 0:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        renew = iterations > STALE
        tries = 0 if renew and not fresh else 1 if done else 8
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
            if done:  # the rounding floor
                break
            if fresh:
                return None
            state, fresh = _pinned_at(p, state.pins, analyses), True
            continue
        recorder.iterations += 1
        recorder.show(t=0.0, residual=float(np.abs(p.curvatures).max()))
        if creeping == 3 and not done:  # large flat faces are cut anew at each step, which takes n^2 flips
            return None
    return state if done else None


def forcing_term(ratio: float, loosest: float) -> float:
    """Residual asked of Newton's linear equations: they converge as it does (Eisenstat and Walker).

    Parameters
    ----------
    ratio : float
        Of the curvatures after a step and before it.
    loosest : float
    """
    return float(np.clip(ratio**2, 1e-6, loosest))


def pinned(p: Polytope, analyses: Analyses, directions: Floats | None = None) -> Solution:
    """Pin three radii of a polytope and factor what is left, whatever its curvatures.

    Parameters
    ----------
    p : Polytope
    analyses : Analyses
    directions : ndarray, shape (V, 3), optional
        Of the vertices from the apex, if they are known.

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
