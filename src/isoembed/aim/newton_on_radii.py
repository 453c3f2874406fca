"""Newton's method on the radii of a generalized polytope, without flips of the given triangles.

The pyramids over the *given* triangles, with the given lengths and a common apex, fit together in space if
their curvatures vanish, for convex and concave edges alike (Bobenko and Izmestiev, Annales de l'Institut
Fourier 58, 2008, who need convexity for existence only).  The radii are the only unknowns: one for each
vertex, with a matrix in the pattern of the triangulation, instead of three for each vertex and the pattern of
the edges.  The path starts from equal radii, or from those of a nearby polyhedron
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

SETTLED = 1e-12  # radians; curvatures left to the polish
LOOSEST = 1e-3  # largest relative residual of Newton's linear equations


def newton_on_radii(
    glued: GluedMetric, analyses: Analyses, log: Log, ordered: Callable[[Floats], Floats]
) -> Floats | None:
    """Realize a convex or nearly convex metric on its own triangles.

    Parameters
    ----------
    glued : GluedMetric
        Scaled to a mean edge length of about 1.
    analyses : Analyses
        Symbolic factorizations of the given triangles.
    log : Log
    ordered : callable
        Function that takes vertices to the order and orientation of the result.

    Returns
    -------
    ndarray, shape (V, 3), or None
        None if the path or Newton's method fails, or ends where ``-d kappa / d r`` has more than the one
        negative eigenvalue of convex bodies, where vertices may be inverted.
    """
    tables, deficits = glued.half_edges(directed=False), glued.deficits
    rounding = deficit_rounding(glued)
    flat = np.mean(np.abs(deficits) <= rounding)  # vertices of undetermined radius
    if not deficits.max() > 0 or flat > 0.1:  # too many flat vertices for the path
        return None
    near = np.full(deficits.size, NEWTON_CURVATURE * deficits.max())
    if (deficits > rounding).all():
        near = np.minimum(near, 0.3 * deficits)  # share of the deficits at which the path may end
    checkpoint = log.checkpoints.resume()
    with log.stage("radii") as recorder:
        recorder.show(level=f"{glued.n_vertices:,} vertices")
        try:
            begun = None if checkpoint is None else Waypoint.of_arrays(checkpoint)
            p = follow_path_without_flips(tables, deficits, recorder, analyses, near, begun)
            if p is None:
                return None
            found = without_curvature(
                pinned(p, analyses),
                SETTLED,
                recorder,
                0.9,  # slower convergence is acceptable after the path
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
    """Mask of the vertices with concave edges only, shape (V,)."""
    return np.bincount(p.tables.corners[p.coupling >= 0], minlength=p.radii.size) == 0


def without_curvature(
    state: Solution,
    settled: float,
    recorder: StageRecorder,
    converging: float = 0.5,  # largest ratio of curvatures after and before a step
) -> tuple[Solution, Floats] | None:
    """Newton's method as long as it converges, and the radii after its first step.

    Parameters
    ----------
    state : Solution
        Initial guess, with any curvatures.
    settled : float
        Largest curvature of the solution.
    recorder : StageRecorder
    converging : float
        Largest ratio of curvatures after and before a step.
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
            # Radians; smaller curvatures that no longer decrease may be rounding.
            if np.abs(p.curvatures).max() > 1e-9:
                return None
            break
        first = first if step else q.radii
        recorder.iterations += 1
        recorder.show(residual=float(np.abs(q.curvatures).max()))
        p, forcing = q, forcing_term(ratio, LOOSEST)
        stale = iterations > 6  # GMRES iterations before a new factorization
        state = state.refactorized(p) if stale else replace(state, polytope=p)
    return state, first
