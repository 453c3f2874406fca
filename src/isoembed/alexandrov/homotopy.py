"""Homotopy from equal radii to the polyhedron: curvatures tend to 0, the Jacobian keeps its inertia.

Bobenko and Izmestiev start from equal radii so large that every curvature is nearly the deficit of its
vertex, and follow ``kappa(t) = (1 - t) kappa(0)``.  Here the initial radii are moderate, the curvatures
follow ``epsilon delta`` with the deficits delta, and a step need not stay on that path: it is accepted if it
brings the curvatures closer to its target.  Steps are uniform in the log odds of epsilon: the polytope over a
long body opens like a wedge of angle ``2 pi (1 - epsilon)``, and its aspect ratio depends on that angle.  One
factorization preconditions the whole path, unless a step meets the boundary of the domain of polytopes; a
second one serves Newton's method and the placement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, fields, replace
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
"""Initial radii in units of the least one, tried in turn until a path arrives; then with scaled curvatures.

The deficits around the middle of a needle are so small compared to those at its tips that a sum of squares
neglects their curvatures.
"""
FORCING = 0.03  # relative residual of the linear equations along the path
EXACT = 1e-4  # the same after a step that was too short, as needed for small deficits
TOO_SHORT = 4  # halvings with a fresh factorization after which the equations are solved again
SHORTEST_STEP = 1e-3  # log odds: a path that needs shorter steps is abandoned
MOST_ODDS = 1e9  # upper limit of the odds of epsilon close to 1 or beyond
NEWTON_CURVATURE = 3e-3  # in largest deficits: curvatures at which Newton's method is tried
CONVEX = 1
"""Number of negative eigenvalues of ``-d kappa / d r`` of convex polytopes (Alexandrov-Fenchel inequalities).

It is the same with three radii pinned where the curvatures vanish.
"""


@dataclass(frozen=True, eq=False)
class Waypoint:
    """Restart point of the path with a fresh factorization, independent of the preceding steps.

    Attributes
    ----------
    polytope : Polytope
    start : int
        Number of the start: index in `START_RADII`, plus its length on the second pass (scaled curvatures).
    close : float
        Largest curvature at which Newton's method is tried, over the largest deficit.
    step : float
        Log odds by which the next step lowers epsilon.
    count : int
        Number of steps since the start.
    odds, norm, deviation : float
        Odds of epsilon, norm of the curvatures, and their largest deviation from ``epsilon delta`` relative
        to delta, at the last check for slow progress.
    target : float
        Target epsilon not yet reached; NaN if the next step sets a new one.
    way : float
        Norm of the missing curvatures when the target was set.
    residual : float
        Relative residual of the linear equations.
    """

    polytope: Polytope
    start: int
    close: float
    step: float = 1.0  # log odds by which the first step lowers epsilon
    count: int = 0
    odds: float = np.inf
    norm: float = np.inf
    deviation: float = np.inf
    target: float = np.nan
    way: float = 0.0
    residual: float = FORCING

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Waypoint | None:
        """Waypoint restored from the result of `arrays`."""
        polytope = Polytope.of_arrays(arrays)
        if polytope is None:
            return None
        names = ("close", "step", "odds", "norm", "deviation", "target", "way", "residual")
        numbers = {name: float(arrays[name]) for name in names}
        return cls(polytope, int(arrays["start"]), count=int(arrays["count"]), **numbers)

    def arrays(self) -> dict[str, ArrayLike]:
        """Arrays that define the waypoint, for a checkpoint."""
        numbers = {field.name: getattr(self, field.name) for field in fields(self)[1:]}
        return {**self.polytope.arrays(), **numbers}


@dataclass(frozen=True, eq=False)
class Stalled:
    """Point at which Newton's method did not converge and the path continues.

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
    """Yield the polytopes of the path, points where it stalled, and finally the solution if it is reached.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation of the metric.
    deficits : ndarray, shape (V,)
        Positive deficits; V is at least 4.
    recorder : StageRecorder
        Counter of steps and factorizations.
    keep : callable, optional
        Called with every waypoint, before continuing from it.
    resumed : Waypoint, optional
        Waypoint to continue from, exactly like the original path.
    near : ndarray, shape (V,), optional
        Curvatures to reach before Newton's method begins, possibly somewhat beyond `NEWTON_CURVATURE`;
        Newton's method may then end at a fraction of them.
    analyses : Analyses, optional
        Analyses for triangulations of this metric or of a nearby one.
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
    """Follow the path on fixed triangles to the start of Newton's method.

    Edges may be reflex along the path and at its end, and deficits negative.  The path ends if a factor has
    more negative pivots than that of a convex polytope.

    Parameters
    ----------
    tables : HalfEdges
    deficits : ndarray, shape (V,)
        Deficits, some of them positive.
    recorder : StageRecorder
        Counter of steps and factorizations; stores every waypoint.
    analyses : Analyses
        Analyses for these triangles.
    near : ndarray, shape (V,)
        Positive curvatures to reach.
    resumed : Waypoint, optional
        Waypoint to continue from, exactly like the original path.

    Returns
    -------
    Polytope or None
        None if the path fails, for example on triangles far from a Delaunay triangulation.

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
    """Start of a path, in hyperbolic space including its first target.

    The deficits sum to 4 pi - k A, but for k < 0 the sum of the curvatures tends to at most 4 pi with growing
    radii: a target with a larger sum makes the radii diverge.  Curvatures of equal radii do not approach
    multiples of the deficits, but the deficits of plane triangles with the chords as sides, and some of
    these may be negative.  Starts with larger radii first make them proportional: curvatures of other large
    radii are those of discretely conformal triangles, which realize every multiple of the deficits (Bobenko,
    Pinkall and Springborn, Discrete conformal maps and ideal hyperbolic polyhedra, Geometry and Topology 19,
    2015).
    """
    here = Waypoint(p, number, NEWTON_CURVATURE)
    if p.tables.curvature >= 0:
        return here
    target = float(p.curvatures.sum() / deficits.sum())
    if number == 0 and _lowered(_share(p.curvatures, deficits), here.step) <= target:
        return here
    way = _norm(p.curvatures - target * deficits, _unit(number, deficits))
    # After a failure in hyperbolic space, the part not proportional to the deficits is reduced to a tenth.
    return replace(here, target=target, way=way * (0.1 if number else 1.0))


def _attempt(
    here: Waypoint,
    deficits: Floats,
    analyses: Analyses,
    recorder: StageRecorder,
    keep: Callable[[Waypoint], None],
    near: Floats | None,
) -> Generator[Polytope | Stalled | Solution, None, bool]:
    """Continue to the solution, trying Newton's method when it may converge; return whether it did."""
    while here.close >= 1e-9:  # largest deficits
        path = _path(here, deficits, analyses, recorder, keep)
        for p in path:
            yield p
            largest, close = np.abs(p.curvatures).max(), here.close * deficits.max()
            if largest <= close and (
                # With `near`, the path ends at the latest at a hundredth of `close`.
                near is None or largest <= 0.01 * close or (np.abs(p.curvatures) <= near).all()
            ):
                break
        else:
            if near is None or largest > close:
                return False
        path.close()  # frees its factor, which is as large as the next one
        keep(Waypoint(p, here.start, here.close))
        # Newton's method may end at a hundredth of the curvatures at the end of the path.
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
    """Follow the curvatures toward zero along ``epsilon delta``; without flips, while factors permit."""
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
        if count % 50 == 0:  # steps within which the odds, the norm or the deviation must decrease
            odds, norm = _odds(epsilon), _norm(p.curvatures, unit)
            deviation = _deviation(p.curvatures, epsilon, deficits)
            # Small deficits are far from the path at first, and close to it many steps later.
            stays = deviation > 0.1 * here.deviation
            if odds > 0.9 * here.odds and norm > 0.999 * here.norm and stays:  # progress too slow
                return
            here = replace(here, odds=odds, norm=norm, deviation=deviation)
        if np.isnan(here.target):
            target = _lowered(epsilon, here.step)
            here = replace(here, target=target, way=_norm(p.curvatures - target * deficits, unit))
        missing = p.curvatures - here.target * deficits
        dr, iterations = _solved(p, inverse, missing, here.residual)
        if iterations > STALE and not fresh:
            inverse = None
            continue
        # With a stale factorization, two successive steps are halved at most twice together; from step 20 on,
        # none is halved.
        stale = max(3 - halving, 1) if count < 20 else 1
        goal, trials = here.target * deficits, 30 if fresh else stale
        stepped = _halved(p, dr, goal, unit, trials, flips)
        too_short = stepped is None or stepped.halving > TOO_SHORT
        if too_short and fresh and here.residual > EXACT:
            here = replace(here, residual=EXACT)
            dr, _ = _solved(p, inverse, missing, here.residual)
            stepped = _halved(p, dr, goal, unit, trials, flips) or stepped
        if stepped is None:
            halving = trials - 1
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
        if left <= 0.6 * here.way:  # close enough to the target to set the next epsilon
            # A full step is followed by a longer one.
            step, target = here.step * (1.5 if halving == 0 else 2 * fraction), np.nan
        else:
            # The step is shortened for another try.
            step, target = here.step * max(fraction, 0.7), here.target
        step = min(max(step, SHORTEST_STEP), 2.5)
        here = replace(here, step=step, target=target)
        recorder.iterations += 1
        # Newton's method begins after 70 % of the work.
        progress = np.log(max(epsilon, NEWTON_CURVATURE)) / np.log(NEWTON_CURVATURE) * 0.7
        shown = min(shown, epsilon)
        recorder.show(t=shown, residual=float(np.abs(p.curvatures).max()), done=float(progress))
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
    """Scale of the curvatures on the path from this start."""
    if start < len(START_RADII):
        return 1.0
    return np.sqrt(np.maximum(deficits, 1e-6 * deficits.max()))  # smaller ones need no scale of their own


def _norm(curvatures: Floats, unit: Floats | float) -> float:
    return float(np.linalg.norm(curvatures / unit))


def _halved(
    p: Polytope, dr: Floats, goal: Floats, unit: Floats | float, trials: int, flips: bool
) -> _Step | None:
    """Step toward these curvatures, halved until they are closer; None if all `trials` fail."""
    size = _norm(p.curvatures - goal, unit)
    search = LineSearch(DECREASE, shortest=2.0 ** (1 - trials))
    for halving, fraction in enumerate(search.parameters()):
        q = Polytope.over(p.tables, p.radii + fraction * dr, flips=flips)
        if q is not None:
            left = _norm(q.curvatures - goal, unit)
            if search.accepts(left, size, fraction):
                return _Step(q, halving, left)
    return None


def _solved(p: Polytope, inverse: Factor, b: Floats, residual: float) -> tuple[Floats, int]:
    """Approximate ``(-d kappa / d r)^-1 b`` by GMRES, preconditioned by the factor of a nearby polytope."""
    return gmres(
        lambda v: -p.times_jacobian(v),
        lambda v: inverse.solve(v, sweeps=0),
        b,
        residual,
        GMRES_ITERATIONS,
    )


def _deviation(curvatures: Floats, epsilon: float, deficits: Floats) -> float:
    """Largest deviation of the curvatures from ``epsilon delta``, relative to delta."""
    nonzero = deficits != 0
    return float(np.abs(curvatures[nonzero] / deficits[nonzero] - epsilon).max())


def _share(curvatures: Floats, deficits: Floats) -> float:
    """Least-squares epsilon for ``epsilon delta`` as an approximation of the curvatures."""
    return float(curvatures @ deficits / (deficits @ deficits))
