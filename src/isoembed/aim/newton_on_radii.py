"""Newton's method on the radii of a generalized polytope, without flips of the given triangles.

The pyramids over the *given* triangles, of the given lengths, with a common apex, fit together in space when
their curvatures vanish, whether the edges be convex or not (Bobenko and Izmestiev, Annales de l'Institut
Fourier 58, 2008, who need convexity for existence only).  So the radii are all that has to be found: one
unknown a vertex, and a matrix with the pattern of the triangulation, in place of three unknowns and the
edges.  They are led there from equal radii at once, or else from those of a polyhedron nearby
(`isoembed.aim.newton_from_polytope`).  The positions follow at the end.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from isoembed.alexandrov.homotopy import CONVEX, NEWTON_CURVATURE, Waypoint, follow_path_without_flips
from isoembed.alexandrov.newton import Analyses, Solution, forcing_term, pinned
from isoembed.alexandrov.placement import realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Mask
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.progress.stages import Log, StageRecorder

SETTLED = 1e-12  # radians: curvatures that are left to the polish
LOOSEST = 1e-3  # largest residual of Newton's linear equations, relative


def newton_on_radii(
    given: GluedMetric, analyses: Analyses, log: Log, ordered: Callable[[Floats], Floats]
) -> Floats | None:
    """Realize a metric that is convex or nearly so, with nothing but its own triangles on the way.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    analyses : Analyses
        Of the given triangles.
    log : Log
    ordered : callable
        Takes vertices to the order and orientation in which they are shown and returned.

    Returns
    -------
    ndarray, shape (V, 3), or None
        None where the path or Newton's method meets anything in the way, or ends where ``-d kappa / d r`` has
        more than the one negative eigenvalue of convex bodies: there something may be turned inside out.
    """
    tables, deficits = given.half_edges(directed=False), given.deficits
    rounding = deficit_rounding(given)
    flat = np.mean(np.abs(deficits) <= rounding)  # where nothing determines a radius
    if not deficits.max() > 0 or flat > 0.1:  # more flat vertices and the path is not tried
        return None
    near = np.full(deficits.size, NEWTON_CURVATURE * deficits.max())
    if (deficits > rounding).all():
        near = np.minimum(near, 0.3 * deficits)  # deficits: curvature of a vertex at which the path may end
    kept = log.checkpoints.resume()
    with log.stage("radii") as recorder:
        recorder.show(level=f"{given.n_vertices:,} vertices")
        try:
            begun = None if kept is None else Waypoint.of_arrays(kept)
            p = follow_path_without_flips(tables, deficits, recorder, analyses, near, begun)
            if p is None:
                return None
            found = without_curvature(
                pinned(p, analyses),
                SETTLED,
                recorder,
                0.9,  # less is asked after the path
            )
            if found is None or inverted_vertices(found[0].polytope).any():
                return None
            state = found[0].refactorized(found[0].polytope)
        except SingularMatrix:
            return None
        if state.inverse.negative_pivots != CONVEX:
            return None
        vertices = ordered(realized(state, recorder))
        recorder.show(vertices=vertices, t=0.0)
    return vertices


def inverted_vertices(p: Polytope) -> Mask:
    """The vertices of which all edges are concave, shape (V,)."""
    return np.bincount(p.tables.corners[p.coupling >= 0], minlength=p.radii.size) == 0


def without_curvature(
    state: Solution,
    settled: float,
    recorder: StageRecorder,
    converging: float = 0.5,  # share of the curvatures that a step leaves
) -> tuple[Solution, Floats] | None:
    """Newton's method while it converges; and the radii after its first step.

    Parameters
    ----------
    state : Solution
        Where it begins, whatever the curvatures.
    settled : float
        Curvatures at which it ends.
    recorder : StageRecorder
    converging : float
        Share of the curvatures that each step leaves at most.
    """
    p, forcing = state.polytope, LOOSEST
    first = p.radii
    for step in range(20):
        if np.abs(p.curvatures).max() <= settled:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        q = Polytope.on(p.tables, p.radii + dr)
        if q is None:
            return None
        ratio = float(np.linalg.norm(q.curvatures) / np.linalg.norm(p.curvatures))
        if not ratio < converging:
            # Radians: smaller curvatures that do not fall any more may be rounding.
            if np.abs(p.curvatures).max() > 1e-9:
                return None
            break
        first = first if step else q.radii
        recorder.iterations += 1
        recorder.show(residual=float(np.abs(q.curvatures).max()))
        p, forcing = q, forcing_term(ratio, LOOSEST)
        stale = iterations > 6  # GMRES iterations: more ask for a fresh factorization
        state = state.refactorized(p) if stale else replace(state, polytope=p)
    return state, first
