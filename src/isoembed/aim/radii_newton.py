"""Newton's method on the radii of a generalized polytope over the given triangles.

The pyramids over the *given* triangles, of the given lengths, with a common apex, fit together in space when
their curvatures vanish, whether the edges be convex or not (Bobenko and Izmestiev, Annales de l'Institut
Fourier 58, 2008, who need convexity for existence only).  So the radii are all that has to be found: one
unknown a vertex, and a matrix with the pattern of the triangulation, in the place of three unknowns and the
edges.  They are led there from equal radii at once, or else from those of a polyhedron nearby
(`isoembed.aim.radii_leap`).  The positions follow at the end.
"""

from dataclasses import dataclass, replace

import numpy as np

from isoembed.alexandrov.homotopy import CONVEX, NEWTON_CURVATURE, Waypoint, follow_path_without_flips
from isoembed.alexandrov.newton import Analyses, Solution, forcing_term, pinned
from isoembed.alexandrov.placement import realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices, Mask
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.measures import outward
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class RadiiNewtonThresholds:
    """Thresholds of Newton's method on the radii."""

    converging: float = threshold(0.5, "relative", "Share of the curvatures that each step leaves at most.")
    descending: float = threshold(0.9, "relative", "The same after the path that comes first.")
    flat: float = threshold(0.1, "vertices", "Share of flat ones from which that path is not tried.")
    closely: float = threshold(1e-9, "radians", "Curvatures that do not fall any more, but may be rounding.")
    settled: float = threshold(1e-12, "radians", "Curvatures that are left to the polish.")
    steps: int = threshold(20, "count", "Newton steps at most, for each step of the way.")
    loosest: float = threshold(1e-3, "relative", "Largest residual of Newton's linear equations.")
    stale: int = threshold(6, "GMRES iterations", "More of them ask for a fresh factorization afterwards.")
    followed: float = threshold(0.3, "deficits", "Curvature of a vertex at which that path may end.")


RADII_NEWTON = RadiiNewtonThresholds()


def newton_on_radii_at_once(
    given: GluedMetric, analyses: Analyses, log: Log, numbers: Indices
) -> Floats | None:
    """Realize a metric that is convex or nearly so, with nothing but its own triangles on the way.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    analyses : Analyses
        Of the given triangles.
    log : Log
    numbers : ndarray of int, shape (V,)
        Other numbers of the vertices, by which they are shown and returned.

    Returns
    -------
    ndarray, shape (V, 3), or None
        None where the path or Newton's method meets anything in the way, or ends where ``-d kappa / d r`` has
        more than the one negative eigenvalue of convex bodies: there something may be turned inside out.
    """
    tables, deficits = given.half_edges(directed=False), given.deficits
    rounding = deficit_rounding(given.faces, given.face_lengths, given.curvature)
    flat = np.mean(np.abs(deficits) <= rounding)  # where nothing determines a radius
    if not deficits.max() > 0 or flat > RADII_NEWTON.flat:
        return None
    near = np.full(deficits.size, NEWTON_CURVATURE * deficits.max())
    if (deficits > rounding).all():
        near = np.minimum(near, RADII_NEWTON.followed * deficits)
    kept = log.resumed_at("radii")
    with log.stage("radii") as recorder:
        recorder.show(level=f"{given.n_vertices:,} vertices")
        try:
            begun = None if kept is None else Waypoint.of_arrays(kept)
            p = follow_path_without_flips(tables, deficits, recorder, analyses, near, begun)
            if p is None:
                return None
            found = without_curvature(
                pinned(p, analyses, recorder), RADII_NEWTON.settled, recorder, RADII_NEWTON.descending
            )
            if found is None or inverted_vertices(found[0].polytope).any():
                return None
            state = found[0].refactorized(found[0].polytope, recorder)
        except SingularMatrix:
            return None
        if state.inverse.negative_pivots != CONVEX:
            return None
        vertices = outward(given.faces, realized(state, recorder))[np.argsort(numbers)]
        recorder.show(vertices=vertices, t=0.0)
    return vertices


def inverted_vertices(p: Polytope) -> Mask:
    """The vertices of which all edges are concave, shape (V,)."""
    return np.bincount(p.tables.corners[p.coupling >= 0], minlength=p.radii.size) == 0


def without_curvature(
    state: Solution,
    settled: float,
    recorder: StageRecorder,
    converging: float = RADII_NEWTON.converging,
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
    p, forcing = state.polytope, RADII_NEWTON.loosest
    first = p.radii
    for step in range(RADII_NEWTON.steps):
        if np.abs(p.curvatures).max() <= settled:
            break
        dr, iterations = state.solve(p.curvatures, forcing)
        q = Polytope.on(p.tables, p.radii + dr)
        if q is None:
            return None
        ratio = float(np.linalg.norm(q.curvatures) / np.linalg.norm(p.curvatures))
        if not ratio < converging:
            if np.abs(p.curvatures).max() > RADII_NEWTON.closely:
                return None
            break
        first = first if step else q.radii
        recorder.iterations += 1
        recorder.show(residual=float(np.abs(q.curvatures).max()))
        p, forcing = q, forcing_term(ratio, RADII_NEWTON.loosest)
        stale = iterations > RADII_NEWTON.stale
        state = state.refactorized(p, recorder) if stale else replace(state, polytope=p)
    return state, first
