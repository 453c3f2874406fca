"""From a ball to the polyhedron: the curvatures of the generalized polytope are led to zero.

Bobenko and Izmestiev start from equal radii so large that every curvature nearly is the deficit of its
vertex, and follow ``kappa(t) = (1 - t) kappa(0)``.  Here the radii are moderate from the beginning, the
curvatures are led along ``epsilon delta``, delta being the deficits, and a step need not stay on that path:
it is accepted if it brings the curvatures nearer to where it aims.  One factorization preconditions the whole
path, unless a step meets the boundary of what polytopes there are; a second one serves Newton's method and
the placement.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.csgraph import dijkstra

from isoembed.alexandrov.polytope import Polytope
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.linalg import Factor, SingularMatrix, Solver, analyze, dissect
from isoembed.linalg.krylov import gmres
from isoembed.metric.curvature import Triangles
from isoembed.progress.stages import StageRecorder

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# All numbers are ratios.  They were chosen on random bodies up to 300 : 1; none is delicate.
LADDER = (2.0, 4.0, 16.0, 64.0, 256.0)  # start radii over the least that may do, until one arrives
FORCING = 0.03  # residual of the linear equations on the way
STALE = 10  # GMRES iterations beyond which a fresh factorization is cheaper
MOST_ITERATIONS = 30
DECREASE = 0.25  # least decrease, over what the linear model promises
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.5, 0.9, 1e-4
HALVINGS, HALVINGS_IF_STALE = 30, 3
CLOSE, CLOSEST = 3e-3, 1e-9  # largest curvature over largest deficit at which Newton's method is tried
MOST_STEPS, NEWTON_STEPS = 1000, 40
CREEP, LEAST_PROGRESS = 50, 0.999  # so many steps have to bring the curvatures down by this factor
ARRIVED = 0.7  # share of all work that is done where Newton's method begins
LOOSEST, TIGHTEST = 1e-2, 1e-6  # residual of Newton's linear equations
EXACT, FLOOR, ROUNDING = (
    1e-9,
    1e-4,
    1e-13,
)  # curvatures of a solution: radians, of the smallest deficit, of zero


@dataclass(frozen=True, eq=False)
class Solution:
    """A polytope without curvature, and the means to place it.

    Attributes
    ----------
    polytope : Polytope
    pins : ndarray of int, shape (3,)
        Vertices in independent directions from the apex.
    solver : Solver
        Of the triangles of the polytope that was factored.
    factor : Factor
        Of ``-d kappa / d r`` nearby, the rows and columns of the pins replaced by those of the identity.
    """

    polytope: Polytope
    pins: Indices
    solver: Solver
    factor: Factor

    @property
    def free(self) -> Floats:
        """1 where a radius may change, 0 at the pins, shape (V,)."""
        return _free(self.polytope, self.pins)

    def renewed(self, p: Polytope, recorder: StageRecorder) -> Solution:
        """Factor another polytope of the same triangles, lengths and radii being others."""
        recorder.factorizations += 1
        return replace(self, polytope=p, factor=self.solver.factor(_pinned(p, _free(p, self.pins)).data))

    def solve(self, b: Floats, tolerance: float) -> tuple[Floats, int]:
        """``(-d kappa / d r)^-1 b`` with the pins left at zero; and the iterations that it took.

        Parameters
        ----------
        b : ndarray, shape (V,) or (V, n)
        tolerance : float
            Relative residual.
        """
        free = self.free if b.ndim == 1 else self.free[:, None]
        return gmres(
            lambda v: free * -self.polytope.times_jacobian(v),
            lambda v: self.factor.solve(v, sweeps=0),
            free * b,
            tolerance,
            MOST_ITERATIONS,
        )


def walk(
    tables: HalfEdges,
    deficits: Floats,
    recorder: StageRecorder,
    backend: str | None = None,
    radii: Floats | None = None,
) -> Iterator[Polytope | Solution]:
    """Yield the polytopes of the path, and at last, if one start arrives, the solution.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation of the metric.
    deficits : ndarray, shape (V,)
        All positive; V is at least 4.
    recorder : StageRecorder
        Counts steps and factorizations.
    backend : str, optional
        As in `isoembed.linalg.analyze`.
    radii : ndarray, shape (V,), optional
        Of a polytope on the path, to go on from.
    """
    tables = tables.copy()
    make_delaunay(tables, np.zeros(deficits.size))
    triangles = Triangles.of(tables.face_lengths)
    areas = triangles.areas * triangles.unit**2
    # The polytope of equal radii exists if every circle around a triangle is smaller; and its curvatures sum
    # to about 4 pi - A / R^2.
    circumradius = float((tables.face_lengths.prod(axis=1) / (4 * areas)).max())
    least = max(circumradius, float(np.sqrt(areas.sum() / (4 * np.pi))))
    starts = [np.full(deficits.size, factor * least) for factor in LADDER]
    for start in starts if radii is None else (radii, *starts):
        polytope = Polytope.over(tables, start)
        if polytope is None:
            continue
        try:
            arrived = yield from _attempt(polytope, deficits, recorder, backend)
        except SingularMatrix:
            continue
        if arrived:
            return


def _attempt(
    p: Polytope, deficits: Floats, recorder: StageRecorder, backend: str | None
) -> Generator[Polytope | Solution, None, bool]:
    """Go from one start to the solution, trying Newton's method whenever it may work; return if it did."""
    close = CLOSE
    while close >= CLOSEST:
        path = _path(p, deficits, recorder, backend)
        for p in path:
            yield p
            if np.abs(p.curvatures).max() <= close * deficits.max():
                break
        else:
            return False
        path.close()  # lets its factor go, which is as large as the next one
        solution = newton(p, deficits, recorder, backend)
        if solution is not None:
            yield solution
            return True
        close /= 10
    return False


def held(p: Polytope, recorder: StageRecorder, backend: str | None = None) -> Solution:
    """Hold three radii of a polytope and factor what is left, whatever its curvatures.

    Raises
    ------
    SingularMatrix
    """
    return _held_at(p, independent_directions(p), recorder, backend)


def _held_at(p: Polytope, pins: Indices, recorder: StageRecorder, backend: str | None) -> Solution:
    matrix = _pinned(p, _free(p, pins))
    recorder.factorizations += 1
    solver = _analyzed(matrix, backend)
    return Solution(p, pins, solver, solver.factor(matrix.data))


def _free(p: Polytope, pins: Indices) -> Floats:
    free = np.ones(p.radii.size)
    free[pins] = 0.0
    return free


def _path(
    p: Polytope, deficits: Floats, recorder: StageRecorder, backend: str | None
) -> Generator[Polytope, None, None]:
    """Lead the curvatures toward zero along ``epsilon delta``."""
    inverse, fresh = _factor(-p.jacobian(), recorder, backend), True
    epsilon = _share(p.curvatures, deficits)
    step, before = FIRST_STEP, np.inf
    yield p
    for count in range(MOST_STEPS):
        if count % CREEP == 0:
            if np.linalg.norm(p.curvatures) > LEAST_PROGRESS * before:
                return
            before = float(np.linalg.norm(p.curvatures))
        aim = max(epsilon, 0.0) * (1 - step) * deficits
        missing = p.curvatures - aim
        dr, iterations = _solved(p, inverse, missing)
        if iterations > STALE and not fresh:
            inverse, fresh = _factor(-p.jacobian(), recorder, backend), True
            continue
        size = np.linalg.norm(missing)
        for halving in range(HALVINGS if fresh else HALVINGS_IF_STALE):
            fraction = 0.5**halving
            q = Polytope.over(p.tables, p.radii + fraction * dr)
            if q is not None and np.linalg.norm(q.curvatures - aim) <= (1 - DECREASE * fraction) * size:
                break
        else:
            if not fresh:
                inverse, fresh = _factor(-p.jacobian(), recorder, backend), True
                continue
            step /= 4
            if step < SHORTEST_STEP:
                return
            continue
        p, fresh = q, False
        epsilon = _share(p.curvatures, deficits)
        step = min(step + 0.1, LONGEST_STEP) if halving == 0 else max(2 * step * fraction, 0.01)
        recorder.iterations += 1
        done = np.log(max(epsilon, CLOSE)) / np.log(CLOSE) * ARRIVED
        recorder.show(t=epsilon, residual=float(np.abs(p.curvatures).max()), done=float(done))
        yield p


def newton(
    p: Polytope, deficits: Floats, recorder: StageRecorder, backend: str | None = None
) -> Solution | None:
    """Newton's method with three radii held, which fixes the apex; None if it does not converge.

    Parameters
    ----------
    p : Polytope
        Near to a solution.
    deficits : ndarray, shape (V,)
    recorder : StageRecorder
    backend : str, optional
    """
    state, fresh = held(p, recorder, backend), True
    forcing, done = LOOSEST, False
    for _ in range(NEWTON_STEPS):
        largest = float(np.abs(p.curvatures).max())
        done = largest <= min(EXACT, max(FLOOR * float(deficits.min()), ROUNDING))
        size = np.linalg.norm(p.curvatures)
        if size == 0:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        renew = iterations > STALE
        for halving in range(0 if renew and not fresh else 1 if done else 8):
            q = Polytope.over(p.tables, p.radii + 0.5**halving * dr)
            if q is not None and np.linalg.norm(q.curvatures) <= (1 - DECREASE * 0.5**halving) * size:
                # As Newton's method converges, so do its linear equations (Eisenstat and Walker).
                ratio = float(np.linalg.norm(q.curvatures) / size)
                forcing = float(np.clip(ratio**2, TIGHTEST, LOOSEST))
                p, fresh = q, False
                state = replace(state, polytope=p)
                break
        else:
            if done:  # the rounding floor
                break
            if fresh:
                return None
            state, fresh = _held_at(p, state.pins, recorder, backend), True
            continue
        recorder.iterations += 1
        recorder.show(t=0.0, residual=float(np.abs(p.curvatures).max()))
    return state if done else None


def independent_directions(p: Polytope) -> Indices:
    """Three vertices that are seen from the apex at about right angles, shape (3,)."""
    i, j = p.tables.corners, p.tables.corners[p.tables.twins]
    a, b, l = p.radii[i], p.radii[j], p.tables.lengths
    # Half the angle at the apex between neighbors, from its sine: |x_i - x_j|^2 = (a - b)^2 + 4 a b sin^2.
    sine = np.sqrt(np.maximum((l - (a - b)) * (l + (a - b)), 0.0) / (4 * a * b))
    angles = 2 * np.arcsin(np.minimum(sine, 1.0))
    n = p.radii.size
    loops = i == j
    graph = coo_array((angles[~loops], (i[~loops], j[~loops])), shape=(n, n)).tocsr()
    oblique = np.zeros(n)
    pins = [0]
    while len(pins) < 3:
        oblique = np.maximum(oblique, np.abs(dijkstra(graph, indices=pins[-1]) - np.pi / 2))
        oblique[pins] = np.inf
        pins.append(int(np.argmin(oblique)))
    return np.array(pins)


def _pinned(p: Polytope, free: Floats) -> csc_array:
    """``-d kappa / d r`` with the rows and columns of unfree vertices replaced by those of the identity."""
    matrix = -p.jacobian()
    column = np.repeat(np.arange(free.size), np.diff(matrix.indptr))
    matrix.data *= free[matrix.indices] * free[column]
    matrix.data[(matrix.indices == column) & (free[column] == 0)] = 1.0
    return matrix


def _factor(matrix: csc_array, recorder: StageRecorder, backend: str | None) -> Factor:
    recorder.factorizations += 1
    return _analyzed(matrix, backend).factor(matrix.data)


def _analyzed(matrix: csc_array, backend: str | None) -> Solver:
    # The triangles change with every flip, and with them the separators: an old order would fill in.
    return analyze(matrix, dissect(matrix).vertex_order(), backend, definite=False)


def _solved(p: Polytope, inverse: Factor, b: Floats) -> tuple[Floats, int]:
    """``(-d kappa / d r)^-1 b``, roughly, preconditioned by the factor of a polytope nearby."""
    return gmres(
        lambda v: -p.times_jacobian(v), lambda v: inverse.solve(v, sweeps=0), b, FORCING, MOST_ITERATIONS
    )


def _share(curvatures: Floats, deficits: Floats) -> float:
    """The epsilon for which ``epsilon delta`` is nearest to the curvatures."""
    return float(curvatures @ deficits / (deficits @ deficits))
