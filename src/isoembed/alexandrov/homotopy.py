"""Homotopy from large equal radii to the polyhedron: the curvatures of the generalized polytope go to zero.

Bobenko and Izmestiev start from equal radii so large that every curvature nearly is the deficit of its
vertex, and follow ``kappa(t) = (1 - t) kappa(0)``.  Here the radii are moderate from the beginning, the
curvatures are led along ``epsilon delta``, delta being the deficits, and a step need not stay on that path:
it is accepted if it brings the curvatures nearer to where it aims.  Steps are even in the log odds of
epsilon: the polytope over a long body opens like a wedge of angle ``2 pi (1 - epsilon)``, and its aspect goes
with that angle.  One factorization preconditions the whole path, unless a step meets the boundary of what
polytopes there are; a second one serves Newton's method and the placement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.alexandrov.newton import DECREASE, GMRES_ITERATIONS, STALE, Analyses, Solution, newton
from isoembed.alexandrov.polytope import Polytope
from isoembed.alexandrov.starts import equal_radii
from isoembed.arrays import Floats
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.linalg import Factor, SingularMatrix, SymmetricFactor
from isoembed.linalg.krylov import gmres
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.progress.stages import StageRecorder

START_RADII = (2.0, 16.0, 64.0, 256.0)
"""Radii of starts in least radii, tried in turn until a path arrives; then with scaled curvatures.

The deficits around the middle of a needle are so small against those at its tips that a sum of squares
neglects their curvatures.
"""
FORCING = 0.03  # relative residual of the linear equations on the way
EXACT = 1e-4  # the same after a step that was too short: small deficits need it
TOO_SHORT = 4  # halvings with a fresh factorization after which the equations are solved again
SHORTEST_STEP = 1e-3  # log odds: a path that needs a shorter step is given up
MOST_ODDS = 1e9  # of epsilon, where it is near 1 or beyond
NEWTON_CURVATURE = 3e-3  # largest deficits: curvatures from which Newton's method is tried
CONVEX = 1
"""Negative eigenvalues of ``-d kappa / d r`` of convex polytopes, by the Alexandrov-Fenchel inequalities.

With three radii pinned they are as many where the curvatures vanish.
"""


@dataclass(frozen=True, eq=False)
class Waypoint:
    """Point of the path with a fresh factorization: what follows depends on nothing before it.

    Attributes
    ----------
    polytope : Polytope
    start : int
        The number of the start on the ladder.
    close : float
        Largest curvature at which Newton's method is tried, over the largest deficit.
    step : float
        Log odds by which the next step is to lower epsilon.
    count : int
        Steps since the path began.
    odds, norm : float
        Of epsilon and of the curvatures where creeping was last looked for.
    target : float
        The epsilon that the last step did not reach; not a number if the next one sets its own.
    way : float
        Norm of what was missing when it was set.
    residual : float
        Of the linear equations.
    """

    polytope: Polytope
    start: int
    close: float
    step: float = 1.0  # log odds, by which the first step is to lower epsilon
    count: int = 0
    odds: float = np.inf
    norm: float = np.inf
    target: float = np.nan
    way: float = 0.0
    residual: float = FORCING

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Waypoint | None:
        """The waypoint of what `arrays` gave."""
        polytope = Polytope.of_arrays(arrays)
        if polytope is None:
            return None
        names = ("close", "step", "odds", "norm", "target", "way", "residual")
        numbers = {name: float(arrays[name]) for name in names}
        return cls(polytope, int(arrays["start"]), count=int(arrays["count"]), **numbers)

    def arrays(self) -> dict[str, ArrayLike]:
        """Arrays that define the waypoint, for a checkpoint."""
        names = ("start", "close", "step", "count", "odds", "norm", "target", "way", "residual")
        return {**self.polytope.arrays(), **{name: getattr(self, name) for name in names}}


@dataclass(frozen=True, eq=False)
class Stalled:
    """Point from which Newton's method did not converge: the path goes on from here.

    Attributes
    ----------
    polytope : Polytope
    """

    polytope: Polytope


def follow_path(
    tables: HalfEdges,
    deficits: Floats,
    recorder: StageRecorder,
    keep: Callable[[Waypoint], None] = lambda _: None,
    resumed: Waypoint | None = None,
    near: Floats | None = None,
    analyses: Analyses | None = None,
) -> Iterator[Polytope | Stalled | Solution]:
    """Yield the polytopes of the path, where it stalled, and at last, if one start arrives, the solution.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation of the metric.
    deficits : ndarray, shape (V,)
        All positive; V is at least 4.
    recorder : StageRecorder
        Counts steps and factorizations.
    keep : callable, optional
        Takes every waypoint, before the work that follows it.
    resumed : Waypoint, optional
        To go on from, exactly as the path that kept it.
    near : ndarray, shape (V,), optional
        Curvatures to which the path is followed before Newton's method begins, if need be some way beyond
        `NEWTON_CURVATURE`; that may then end at a share of them.
    analyses : Analyses, optional
        Of triangulations of this metric, or of one nearby.
    """
    analyses = analyses or Analyses.of(tables, recorder.work)
    tables = tables.copy()
    make_delaunay(tables, np.zeros(deficits.size))
    radii = equal_radii(tables, START_RADII)
    for number, radius in enumerate([*radii, *radii]):
        if resumed is not None and number <= resumed.start:
            here = resumed if number == resumed.start else None
        else:
            polytope = Polytope.over(tables, np.full(deficits.size, radius))
            here = None if polytope is None else _start(polytope, number, deficits)
        if here is None:
            continue
        try:
            arrived = yield from _attempt(here, deficits, analyses, recorder, keep, near)
        except SingularMatrix:
            continue
        if arrived:
            return


def follow_path_without_flips(
    tables: HalfEdges,
    deficits: Floats,
    recorder: StageRecorder,
    analyses: Analyses,
    near: Floats,
    resumed: Waypoint | None = None,
) -> Polytope | None:
    """Lead the curvatures over triangles as they are to where Newton's method begins.

    Edges may be reflex on the way and in the end, and deficits negative.  The path ends where a factor has
    more negative pivots than that of a convex polytope.

    Parameters
    ----------
    tables : HalfEdges
    deficits : ndarray, shape (V,)
        Some positive.
    recorder : StageRecorder
        Counts steps and factorizations, and keeps every waypoint.
    analyses : Analyses
        Of these triangles.
    near : ndarray, shape (V,)
        Curvatures to which the path is followed, positive.
    resumed : Waypoint, optional
        To go on from, exactly as the path that kept it.

    Returns
    -------
    Polytope or None
        None where anything is in the way: triangles that are far from a Delaunay triangulation, say.

    Raises
    ------
    SingularMatrix
    """
    here = resumed
    if here is None:
        radius = equal_radii(tables, START_RADII)[0]
        p = Polytope.over(tables, np.full(deficits.size, radius), flips=False)
        here = None if p is None else _start(p, 0, deficits)
    if here is None:
        return None
    path = _path(here, deficits, analyses, recorder, lambda w: recorder.keep(**w.arrays()), flips=False)
    return next((p for p in path if (np.abs(p.curvatures) <= near).all()), None)


def _start(p: Polytope, number: int, deficits: Floats) -> Waypoint:
    """Start of a path, and in hyperbolic space also its first target.

    The deficits sum to 4 pi - k A, but the curvatures of radii that grow to 4 pi at most, where k < 0: an aim
    must not sum to more, or the radii run away.  Those of equal radii do not become like the deficits, but
    tend to those of the triangles of the plane with the chords for sides, some of which may be negative.
    Higher starts make them alike first: those of other large radii are of discretely conformal triangles,
    among which are some with any share of the deficits (Bobenko, Pinkall and Springborn, Discrete conformal
    maps and ideal hyperbolic polyhedra, Geometry and Topology 19, 2015).
    """
    here = Waypoint(p, number, NEWTON_CURVATURE)
    if p.tables.curvature >= 0:
        return here
    target = float(p.curvatures.sum() / deficits.sum())
    if number == 0 and _lowered(_share(p.curvatures, deficits), here.step) <= target:
        return here
    way = _norm(p.curvatures - target * deficits, _unit(number, deficits))
    # The part unlike the deficits falls to a tenth, in hyperbolic space after a failure.
    return replace(here, target=target, way=way * (0.1 if number else 1.0))


def _attempt(
    here: Waypoint,
    deficits: Floats,
    analyses: Analyses,
    recorder: StageRecorder,
    keep: Callable[[Waypoint], None],
    near: Floats | None,
) -> Generator[Polytope | Stalled | Solution, None, bool]:
    """Go on to the solution, trying Newton's method whenever it may work; return if it did."""
    while here.close >= 1e-9:  # largest deficits
        path = _path(here, deficits, analyses, recorder, keep)
        for p in path:
            yield p
            largest, close = np.abs(p.curvatures).max(), here.close * deficits.max()
            if largest <= close and (
                # Where the path is to be followed farther, a hundredth of `close` ends it.
                near is None or largest <= 0.01 * close or (np.abs(p.curvatures) <= near).all()
            ):
                break
        else:
            if near is None or largest > close:
                return False
        path.close()  # lets its factor go, which is as large as the next one
        keep(Waypoint(p, here.start, here.close))
        # Newton's method may end at a hundredth of the curvatures where the path may.
        solution = newton(p, deficits, analyses, recorder, None if near is None else 0.01 * near)
        if solution is not None:
            yield solution
            return True
        yield Stalled(p)
        here = Waypoint(p, here.start, here.close / 10)
    return False


def _path(
    here: Waypoint,
    deficits: Floats,
    analyses: Analyses,
    recorder: StageRecorder,
    keep: Callable[[Waypoint], None],
    *,
    flips: bool = True,
) -> Generator[Polytope, None, None]:
    """Lead the curvatures toward zero along ``epsilon delta``; without flips, while factors allow."""
    p = here.polytope
    unit = _unit(here.start, deficits)
    epsilon = _share(p.curvatures, deficits)
    inverse: SymmetricFactor | None = None
    fresh, halving, shown = True, 0, epsilon
    yield p
    for count in range(here.count, 1000):
        if inverse is None:
            here = replace(here, polytope=p, count=count)
            keep(here)
            inverse, fresh = _factor(p, analyses), True
            if not flips and inverse.negative_pivots != CONVEX:
                return
        if count % 50 == 0:  # steps in which the odds or the norm have to fall
            odds, norm = _odds(epsilon), _norm(p.curvatures, unit)
            if odds > 0.9 * here.odds and norm > 0.999 * here.norm:  # a path that creeps is given up
                return
            here = replace(here, odds=odds, norm=norm)
        if np.isnan(here.target):
            target = _lowered(epsilon, here.step)
            here = replace(here, target=target, way=_norm(p.curvatures - target * deficits, unit))
        missing = p.curvatures - here.target * deficits
        dr, iterations = _solved(p, inverse, missing, here.residual)
        if iterations > STALE and not fresh:
            inverse = None
            continue
        # Less is allowed after a step, with the same factorization, that was halved itself.
        # With an older factorization two steps in a row are halved three times together; later none is.
        stale = max(3 - halving, 1) if count < 20 else 1
        goal, most = here.target * deficits, 30 if fresh else stale
        stepped = _halved(p, dr, goal, unit, most, flips)
        too_short = stepped is None or stepped.halving > TOO_SHORT
        if too_short and fresh and here.residual > EXACT:
            here = replace(here, residual=EXACT)
            dr, _ = _solved(p, inverse, missing, here.residual)
            stepped = _halved(p, dr, goal, unit, most, flips) or stepped
        if stepped is None:
            halving = most - 1
            if not fresh:
                inverse = None
                continue
            here = replace(here, step=here.step / 4, target=np.nan)
            if here.step < SHORTEST_STEP:
                return
            continue
        q, halving, left = stepped
        fraction = 0.5**halving
        p, fresh = q, False
        epsilon = _share(p.curvatures, deficits)
        if left <= 0.6 * here.way:  # share of the way that may be left when the next epsilon is set
            # A step accepted whole is followed by a longer one.
            step, target = here.step * (1.5 if halving == 0 else 2 * fraction), np.nan
        else:
            # Share of a step that is kept for another try.
            step, target = here.step * max(fraction, 0.7), here.target
        step = min(max(step, SHORTEST_STEP), 2.5)
        here = replace(here, step=step, target=target)
        recorder.iterations += 1
        # Share of the work that is done where Newton's method begins.
        done = np.log(max(epsilon, NEWTON_CURVATURE)) / np.log(NEWTON_CURVATURE) * 0.7
        shown = min(shown, epsilon)
        recorder.show(t=shown, residual=float(np.abs(p.curvatures).max()), done=float(done))
        yield p


def _odds(epsilon: float) -> float:
    if epsilon <= 0:
        return 0.0
    return min(epsilon / (1 - epsilon), MOST_ODDS) if epsilon < 1 else MOST_ODDS


def _lowered(epsilon: float, step: float) -> float:
    odds = _odds(epsilon) * math.exp(-step)
    return odds / (1 + odds)


def _factor(p: Polytope, analyses: Analyses) -> SymmetricFactor:
    matrix = p.jacobian()
    matrix.data *= -1
    return analyses.solver(matrix).factor(matrix.data, single=True)


class _Step(NamedTuple):
    """End of a step, the number of halvings, and the norm of the remaining error."""

    polytope: Polytope
    halving: int
    left: float


def _unit(start: int, deficits: Floats) -> Floats | float:
    """Unit of curvatures on the path from this start."""
    if start < len(START_RADII):
        return 1.0
    return np.sqrt(np.maximum(deficits, 1e-6 * deficits.max()))  # smaller ones are met by the way


def _norm(curvatures: Floats, unit: Floats | float) -> float:
    return float(np.linalg.norm(curvatures / unit))


def _halved(
    p: Polytope, dr: Floats, goal: Floats, unit: Floats | float, most: int, flips: bool
) -> _Step | None:
    """The step to these curvatures, halved until they come nearer; None if none of so many does."""
    size = _norm(p.curvatures - goal, unit)
    search = LineSearch(DECREASE, shortest=2.0 ** (1 - most))
    for halving, fraction in enumerate(search.parameters()):
        q = Polytope.over(p.tables, p.radii + fraction * dr, flips=flips)
        if q is not None:
            left = _norm(q.curvatures - goal, unit)
            if search.accepts(left, size, fraction):
                return _Step(q, halving, left)
    return None


def _solved(p: Polytope, inverse: Factor, b: Floats, residual: float) -> tuple[Floats, int]:
    """``(-d kappa / d r)^-1 b``, roughly, preconditioned by the factor of a polytope nearby."""
    return gmres(
        lambda v: -p.times_jacobian(v),
        lambda v: inverse.solve(v, sweeps=0),
        b,
        residual,
        GMRES_ITERATIONS,
    )


def _share(curvatures: Floats, deficits: Floats) -> float:
    """The epsilon for which ``epsilon delta`` is nearest to the curvatures."""
    return float(curvatures @ deficits / (deficits @ deficits))
