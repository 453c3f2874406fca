"""Newton's method on the radii of a generalized polytope over the given triangles.

The pyramids over the *given* triangles, of the given lengths, with a common apex, fit together in space when
their curvatures vanish, whether the edges be convex or not (Bobenko and Izmestiev, Annales de l'Institut
Fourier 58, 2008, who need convexity for existence only).  So the radii are all that has to be found: one
unknown a vertex, and a matrix with the pattern of the triangulation, in the place of three unknowns and the
edges.  They are led there from equal radii at once, or else from those of a polyhedron nearby.  The positions
follow at the end.
"""

from dataclasses import dataclass, replace

import numpy as np

from isoembed.aim.adiabatic_pullback import extrapolated
from isoembed.alexandrov.doubly_covered import FLAT_LIMIT
from isoembed.alexandrov.homotopy import (
    CONVEX,
    HOMOTOPY,
    Stalled,
    Waypoint,
    follow_path,
    follow_path_without_flips,
)
from isoembed.alexandrov.newton import Analyses, Solution, forcing_term, pinned
from isoembed.alexandrov.placement import placed, realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.space import Space
from isoembed.surface.measures import outward
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class RadiiNewtonThresholds:
    """Thresholds of Newton's method on the radii."""

    parts: int = threshold(4, "count", "Steps of the way to a metric that is not convex.")
    converging: float = threshold(0.5, "relative", "Share of the curvatures that each step leaves at most.")
    descending: float = threshold(0.9, "relative", "The same after a path without flips.")
    flat: float = threshold(0.1, "vertices", "Share of flat ones from which that path is not tried.")
    nearly: float = threshold(1e-4, "mean deficits", "Curvatures that end a step on the way.")
    closely: float = threshold(1e-9, "radians", "Curvatures that do not fall any more, but may be rounding.")
    settled: float = threshold(1e-12, "radians", "Curvatures that are left to the polish.")
    steps: int = threshold(20, "count", "Newton steps at most, for each step of the way.")
    loosest: float = threshold(1e-3, "relative", "Largest residual of Newton's linear equations.")
    stale: int = threshold(6, "GMRES iterations", "More of them ask for a fresh factorization afterwards.")
    nudge: float = threshold(1e-3, "mean edge lengths", "Change of height to see curvature bend.")
    trusted: float = threshold(0.25, "heights on a sphere", "Largest branch deviation that is trusted.")
    resolved: float = threshold(0.1, "deficits", "Curvature of a vertex at which its height is decided.")
    followed: float = threshold(0.3, "deficits", "The same at the end of a path without flips.")
    solved: float = threshold(0.4, "relative", "Share of all work done when vertices can be placed.")


RADII_NEWTON = RadiiNewtonThresholds()


@dataclass(frozen=True, eq=False)
class RadiiSolution:
    """Where Newton's method on the radii ends.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    branch_deviation : float
        The most that the height of a vertex above its neighbors, measured in radii, differed from what was
        expected, over what such heights are on a sphere.  Newton's method can cross over to a neighboring
        realization, with some vertices turned inside out, that has the same lengths.
    """

    vertices: Floats
    branch_deviation: float


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
    near = np.full(deficits.size, HOMOTOPY.close * deficits.max())
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
            found = _without_curvature(
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


def radii_start(given: GluedMetric, convex: GluedMetric, analyses: Analyses, log: Log) -> Floats | None:
    """Lead a polytope over a convex metric to where Newton's method may begin.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    convex : GluedMetric
        A convex metric near it, on the same vertices; it may be the given one.
    analyses : Analyses
        Of the given triangles.
    log : Log

    Returns
    -------
    ndarray or None
        Radii, shape (V,), if the convex metric is the given one: triangles change only, and the polyhedron
        need not be reached, as long as every vertex has come near to where it will be, by its own deficit.
        Otherwise the vertices of the polyhedron, shape (V, 3).  None where the convex metric is flat at a
        vertex, whose radius nothing determines, or all of it is.
    """
    if (convex.deficits <= deficit_rounding(convex.faces, convex.face_lengths, convex.curvature)).any():
        return None
    deficits, kept = convex.deficits, log.resumed_at("polytopes")
    close = np.minimum(HOMOTOPY.close * deficits.max(), RADII_NEWTON.resolved * deficits)
    with log.stage("polytopes") as recorder:
        recorder.show(level=f"{given.n_vertices:,} vertices")
        path = follow_path(
            convex.half_edges(directed=False),
            deficits,
            recorder,
            lambda here: recorder.keep(**here.arrays()),
            None if kept is None else Waypoint.of_arrays(kept),
            close,
            analyses,
        )
        for found in path:
            if isinstance(found, Stalled):
                continue
            p = found.polytope if isinstance(found, Solution) else found
            if convex is given and (np.abs(p.curvatures) <= close).all():
                return p.radii
            if isinstance(found, Solution):
                vertices = realized(found, recorder) if convex is given else placed(found)
                return convex.space.centered(vertices)
            if p.lowest < FLAT_LIMIT.thin:
                return None
    return None


def newton_on_radii(
    given: GluedMetric,
    start: Floats,
    analyses: Analyses,
    log: Log,
    numbers: Indices | None = None,
) -> RadiiSolution | None:
    """Realize a metric that is convex or nearly so.

    Parameters
    ----------
    given : GluedMetric
        Of mean edge length 1 or so.
    start : ndarray, shape (V,) or (V, 3)
        Radii or vertices, from `radii_start`.
    analyses : Analyses
        Of the given triangles.
    log : Log
    numbers : ndarray of int, shape (V,), optional
        Other numbers of the vertices, by which they are shown and returned.

    Returns
    -------
    RadiiSolution or None
        None where Newton's method does not converge at once.

    Notes
    -----
    From radii, Newton's method is applied once.  From vertices it follows the lengths
    ``l(t) = l(0)^{1-t} l(1)^t`` in a few steps, l(1) being the distances of the vertices: where a surface is
    nearly flat, one step would be decided by chance.
    """
    with log.stage("leap") as recorder:
        recorder.show(level=f"{given.n_vertices:,} vertices")
        recorder.keep(start=start)
        try:
            found = _followed(given.half_edges(directed=False), start, analyses, recorder)
        except SingularMatrix:
            return None
        if found is None:
            return None
        solution, branch_deviation = found
        vertices = outward(given.faces, realized(solution, recorder))
        if numbers is not None:
            vertices = vertices[np.argsort(numbers)]
        recorder.show(vertices=vertices)
    return RadiiSolution(vertices, branch_deviation)


def _followed(
    tables: HalfEdges, start: Floats, analyses: Analyses, recorder: StageRecorder
) -> tuple[Solution, float] | None:
    """From radii in one step, or from vertices in several; and the branch deviation."""
    space, ends = Space(tables.curvature), (tables.corners, tables.corners[tables.twins])
    if start.ndim == 1:
        steps, ratio, directions = 1, np.ones(tables.lengths.size), None
    else:
        steps = RADII_NEWTON.parts
        ratio = space.distances(start[ends[0]], start[ends[1]]) / tables.lengths
        sines = np.linalg.norm(start, axis=1)
        directions, start = start / sines[:, None], space.asn(sines)
    degrees, mean = np.bincount(ends[0]), start.mean()
    round_height = np.mean(tables.lengths**2) * space.cs(mean) / (2 * space.sn(mean))

    nearly = RADII_NEWTON.nearly * 4 * np.pi / start.size

    def heights(radii: Floats) -> Floats:
        return radii - np.bincount(ends[0], radii[ends[1]]) / degrees

    known: list[tuple[float, Floats]] = [(1.0, start)]
    state: Solution | None = None
    branch_deviation = 0.0
    for t in np.linspace(1, 0, steps + 1)[1:].tolist():
        p = Polytope.on(tables._replace(lengths=tables.lengths * ratio**t), extrapolated(known[-3:], t))
        if p is None:
            return None
        state = replace(state, polytope=p) if state else pinned(p, analyses, recorder, directions)
        found = _without_curvature(state, RADII_NEWTON.settled if t == 0 else nearly, recorder)
        if found is None:
            return None
        state, expected = found
        if len(known) > 1:
            expected = p.radii
        change = np.abs(heights(state.polytope.radii - expected)).max() / round_height
        branch_deviation = max(branch_deviation, float(change))
        known.append((t, state.polytope.radii))
        recorder.show(t=t, done=RADII_NEWTON.solved * (1 - t))
    return None if state is None else (_reflected(state, recorder), branch_deviation)


def _reflected(state: Solution, recorder: StageRecorder) -> Solution:
    """Turn out the vertices all of whose edges are concave, where that gives another realization.

    Where the metric is nearly flat, Newton's method may find either.  Of the height of one vertex alone, the
    curvature there is a parabola: the other root is as far from its top.
    """
    p = state.polytope
    inverted = inverted_vertices(p)
    if not inverted.any():
        return state
    nudge = RADII_NEWTON.nudge * float(p.tables.lengths.mean())
    nudged = Polytope.on(p.tables, p.radii + nudge * inverted)
    if nudged is None:
        return state
    with np.errstate(all="ignore"):
        across = np.where(inverted, -2 * nudge * p.diagonal / (nudged.diagonal - p.diagonal), 0.0)
    q = Polytope.on(p.tables, p.radii + across) if np.isfinite(across).all() else None
    if q is None:
        return state
    found = _without_curvature(state.refactorized(q, recorder), RADII_NEWTON.settled, recorder)
    if found is None or inverted_vertices(found[0].polytope).sum() >= inverted.sum():
        return state
    return found[0]


def inverted_vertices(p: Polytope) -> Mask:
    """The vertices of which all edges are concave, shape (V,)."""
    return np.bincount(p.tables.corners[p.coupling >= 0], minlength=p.radii.size) == 0


def _without_curvature(
    state: Solution,
    settled: float,
    recorder: StageRecorder,
    converging: float = RADII_NEWTON.converging,
) -> tuple[Solution, Floats] | None:
    """Newton's method while it converges; and the radii after its first step."""
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
