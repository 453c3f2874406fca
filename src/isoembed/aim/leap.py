"""The leap: Newton's method on the radii of a generalized polytope, from the waypoint to the given triangles.

The pyramids over the *given* triangles, of the given lengths, with a common apex, fit together in space when
their curvatures vanish, whether the edges be convex or not (Bobenko and Izmestiev, Annales de l'Institut
Fourier 58, 2008, who need convexity for existence only).  So the radii of a polyhedron nearby are all that
has to be put right: one unknown a vertex, and a matrix with the pattern of the triangulation, in the place of
three unknowns and the edges.  The positions follow at the end, all at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from isoembed.alexandrov.doubly_covered import THIN
from isoembed.alexandrov.homotopy import CLOSE, Solution, held, walk
from isoembed.alexandrov.placement import realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.flips import HalfEdges
from isoembed.metric.glued import GluedMetric
from isoembed.stages import Log, Tally
from isoembed.surface.measures import outward

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CONVERGING = 0.5  # of the curvatures is left, or less, after each step
NEARLY, SETTLED = 1e-9, 1e-12  # radians: curvatures that may be rounding, and that are left to the polish
STEPS = 20
STALE = 10  # GMRES iterations beyond which a fresh factorization is cheaper
LOOSEST, TIGHTEST = 1e-3, 1e-6  # residual of Newton's linear equations
USUAL, STEPPED = 4, 0.4  # steps as a rule, and the share of all work that they are


@dataclass(frozen=True, eq=False)
class Approach:
    """A polytope over the waypoint with little curvature, or none.

    Attributes
    ----------
    found : Polytope or Solution
    order : ndarray of int64, shape (V,)
        Its vertices in the numbers of the metric.
    """

    found: Polytope | Solution
    order: Indices


@dataclass(frozen=True, eq=False)
class Landing:
    """Where a leap ends.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    pointed : ndarray, shape (V, 3)
        The same with the radii that the first step pointed at.
    """

    vertices: Floats
    pointed: Floats


def approach(
    given: GluedMetric, waypoint: GluedMetric, log: Log, backend: str | None = None
) -> Approach | None:
    """Lead a polytope over the waypoint to where the leap may begin.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    waypoint : GluedMetric
        A convex metric near it, on the same vertices; it may be the given one.
    log : Log
    backend : str, optional
        As in `isoembed.linalg.analyze`.

    Returns
    -------
    Approach or None
        None where the waypoint is flat at a vertex, whose radius nothing determines, or all of it is.
    """
    if (waypoint.deficits <= deficit_rounding(waypoint.faces, waypoint.face_lengths)).any():
        return None
    tables = HalfEdges.of(waypoint.faces, waypoint.twins, waypoint.face_lengths)
    order = tables.order_in_memory()
    deficits, kept = waypoint.deficits[order], log.resumed_at("polytopes")
    # With the given metric itself, the leap changes triangles only, and need not begin at the polyhedron.
    close = CLOSE * float(deficits.max()) if waypoint is given else 0.0
    with log.stage("polytopes") as tally:
        radii = None if kept is None else kept["radii"][order]
        for found in walk(tables.in_order(order), deficits, tally, backend, radii):
            if isinstance(found, Solution) or np.abs(found.curvatures).max() <= close:
                return Approach(found, order)
            if found.lowest < THIN:
                return None
            tally.keep(radii=found.radii[np.argsort(order)])
    return None


def leap(
    given: GluedMetric, approach: Approach | None, log: Log, backend: str | None = None
) -> Landing | None:
    """Realize a metric that is convex or nearly so.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    approach : Approach or None
        Not needed to go on with a leap that was interrupted.
    log : Log
    backend : str, optional
        As in `isoembed.linalg.analyze`.

    Returns
    -------
    Landing or None
        None where Newton's method does not converge at once.
    """
    kept = log.resumed_at("leap")
    tables = HalfEdges.of(given.faces, given.twins, given.face_lengths)
    if kept is not None:
        order = tables.order_in_memory()
        radii, pointed = kept["radii"][order], kept["pointed"][order]
    elif approach is not None:
        order, found, pointed = approach.order, approach.found, None
        radii = found.polytope.radii if isinstance(found, Solution) else found.radii
    else:
        return None
    back = np.argsort(order)
    with log.stage("leap") as tally:
        try:
            p = Polytope.on(tables.in_order(order), radii)
            landed = None if p is None else _without_curvature(p, pointed, back, tally, backend)
        except SingularMatrix:
            return None
        if landed is None:
            return None
        solution, pointed = landed
        vertices = outward(given.faces, realized(solution, tally)[back])
    return Landing(vertices, vertices * (pointed / solution.polytope.radii)[back, None])


def _without_curvature(
    p: Polytope, pointed: Floats | None, back: Indices, tally: Tally, backend: str | None
) -> tuple[Solution, Floats] | None:
    """Newton's method while it converges; and the radii after its first step."""
    state, forcing = held(p, tally, backend), LOOSEST
    for _ in range(STEPS):
        if np.abs(p.curvatures).max() <= SETTLED:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        q = Polytope.on(p.tables, p.radii + dr)
        if q is None:
            return None
        ratio = float(np.linalg.norm(q.curvatures) / np.linalg.norm(p.curvatures))
        if not ratio < CONVERGING:
            if np.abs(p.curvatures).max() > NEARLY:
                return None
            break
        pointed = q.radii if pointed is None else pointed
        tally.iterations += 1
        tally.keep(radii=q.radii[back], pointed=pointed[back])
        tally.show(
            residual=float(np.abs(q.curvatures).max()), done=STEPPED * min(tally.iterations / USUAL, 1)
        )
        # As Newton's method converges, so do its linear equations (Eisenstat and Walker).
        p, forcing = q, float(np.clip(ratio**2, TIGHTEST, LOOSEST))
        state = held(p, tally, backend) if iterations > STALE else replace(state, polytope=p)
    return state, p.radii if pointed is None else pointed
