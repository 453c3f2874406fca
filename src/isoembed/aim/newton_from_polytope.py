"""Start from the polytope of a nearby convex metric, then Newton's method on the radii without flips.

The polyhedron is that of the metric itself, on its own triangulation, or of a nearby convex metric.  The
path to it follows `isoembed.alexandrov`, with flips; from there one or a few Newton solves lead back to the
given triangles.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from isoembed.aim.newton_on_lengths import BranchSolution
from isoembed.aim.newton_on_radii import SETTLED, inverted_vertices, without_curvature
from isoembed.alexandrov.doubly_covered import THIN
from isoembed.alexandrov.homotopy import NEWTON_CURVATURE, Stalled, Waypoint, follow_path
from isoembed.alexandrov.newton import Analyses, Solution, pinned
from isoembed.alexandrov.placement import placed, realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.linalg import SingularMatrix
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.nonlinear.continuation import extrapolated
from isoembed.progress.stages import Log, StageRecorder
from isoembed.space import Space


def polytope_start(original: GluedMetric, convex: GluedMetric, analyses: Analyses, log: Log) -> Floats | None:
    """Start of Newton's method, from generalized polytopes over a convex metric.

    Parameters
    ----------
    original : GluedMetric
        Scaled to a mean edge length of about 1.
    convex : GluedMetric
        A nearby convex metric on the same vertices, possibly the given one.
    analyses : Analyses
        Symbolic factorizations of the given triangles.
    log : Log

    Returns
    -------
    ndarray or None
        Radii, shape (V,), if the convex metric is the given one: the polyhedron need not be reached, as long
        as the curvature of each vertex is small compared with its deficit.  Otherwise the vertices of the
        polyhedron, shape (V, 3).  None if the convex metric is flat at a vertex, whose radius is then not
        determined, or the polyhedron is thin.
    """
    if (convex.deficits <= deficit_rounding(convex)).any():
        return None
    deficits, checkpoint = convex.deficits, log.checkpoints.resume()
    # Share of the deficits; with less curvature the side of a vertex is determined.
    close = np.minimum(NEWTON_CURVATURE * deficits.max(), 0.1 * deficits)
    with log.stage("polytopes") as recorder:
        recorder.show(level=f"{original.n_vertices:,} vertices")
        path = follow_path(
            convex.half_edges(directed=False),
            deficits,
            recorder,
            lambda here: recorder.keep(**here.arrays()),
            None if checkpoint is None else Waypoint.of_arrays(checkpoint),
            close,
            analyses,
        )
        for found in path:
            if isinstance(found, Stalled):
                continue
            p = found.polytope if isinstance(found, Solution) else found
            if convex is original and (np.abs(p.curvatures) <= close).all():
                return p.radii
            if isinstance(found, Solution):
                vertices = realized(found, recorder) if convex is original else placed(found)
                return convex.space.centered(vertices)
            if p.lowest < THIN:
                return None
    return None


def newton_from_polytope(
    original: GluedMetric,
    start: Floats,
    analyses: Analyses,
    log: Log,
    ordered: Callable[[Floats], Floats],
) -> BranchSolution | None:
    """Realize a convex or nearly convex metric.

    Parameters
    ----------
    original : GluedMetric
        Scaled to a mean edge length of about 1.
    start : ndarray, shape (V,) or (V, 3)
        Radii or vertices, from `polytope_start`.
    analyses : Analyses
        Symbolic factorizations of the given triangles.
    log : Log
    ordered : callable
        Function that takes vertices to the order and orientation of the result.

    Returns
    -------
    BranchSolution or None
        None if Newton's method does not converge immediately.

    Notes
    -----
    From radii, Newton's method is applied once.  From vertices it follows the lengths
    ``l(t) = l(0)^{1-t} l(1)^t`` in a few steps, where l(1) are the distances of the vertices: on nearly flat
    surfaces, the result of a single step would be arbitrary.
    """
    with log.stage("leap") as recorder:
        recorder.show(level=f"{original.n_vertices:,} vertices")
        try:
            found = _followed(original.half_edges(directed=False), start, analyses, recorder)
        except SingularMatrix:
            return None
        if found is None:
            return None
        solution, branch_deviation = found
        vertices = ordered(realized(solution, recorder))
        recorder.show(vertices=vertices)
    return BranchSolution(vertices, branch_deviation)


def _followed(
    tables: HalfEdges, start: Floats, analyses: Analyses, recorder: StageRecorder
) -> tuple[Solution, float] | None:
    """Solution by Newton's method, from radii in one step or vertices in several; and branch deviation."""
    space, ends = Space(tables.curvature), (tables.corners, tables.corners[tables.twins])
    if start.ndim == 1:
        steps, ratio, directions = 1, np.ones(tables.lengths.size), None
    else:
        steps = 4  # steps to a metric that is not convex
        ratio = space.distances(start[ends[0]], start[ends[1]]) / tables.lengths
        sines = np.linalg.norm(start, axis=1)
        directions, start = start / sines[:, None], space.asn(sines)
    degrees, mean = np.bincount(ends[0]), start.mean()
    round_height = np.mean(tables.lengths**2) * space.cs(mean) / (2 * space.sn(mean))

    nearly = 1e-4 * 4 * np.pi / start.size  # share of the mean deficit, for intermediate steps

    def heights(radii: Floats) -> Floats:
        return radii - np.bincount(ends[0], radii[ends[1]]) / degrees

    history: list[tuple[float, Floats]] = [(1.0, start)]
    state: Solution | None = None
    branch_deviation = 0.0
    for t in np.linspace(1, 0, steps + 1)[1:].tolist():
        p = Polytope.on(tables._replace(lengths=tables.lengths * ratio**t), extrapolated(history[-3:], t))
        if p is None:
            return None
        state = replace(state, polytope=p) if state else pinned(p, analyses, directions)
        found = without_curvature(state, SETTLED if t == 0 else nearly, recorder)
        if found is None:
            return None
        state, expected = found
        if len(history) > 1:
            expected = p.radii
        change = np.abs(heights(state.polytope.radii - expected)).max() / round_height
        branch_deviation = max(branch_deviation, float(change))
        history.append((t, state.polytope.radii))
        recorder.show(t=t, done=0.4 * (1 - t))  # share of the work before the placement
    return None if state is None else (_reflected(state, recorder), branch_deviation)


def _reflected(state: Solution, recorder: StageRecorder) -> Solution:
    """Reflect the vertices with concave edges only, if that gives another realization.

    Where the metric is nearly flat, Newton's method may find either one.  The curvature at a vertex is a
    parabola in its height: the other root is at the same distance from the extremum.
    """
    p = state.polytope
    inverted = inverted_vertices(p)
    if not inverted.any():
        return state
    nudge = 1e-3 * float(p.tables.lengths.mean())  # mean edge lengths
    nudged = Polytope.on(p.tables, p.radii + nudge * inverted)
    if nudged is None:
        return state
    with np.errstate(all="ignore"):
        across = np.where(inverted, -2 * nudge * p.diagonal / (nudged.diagonal - p.diagonal), 0.0)
    q = Polytope.on(p.tables, p.radii + across) if np.isfinite(across).all() else None
    if q is None:
        return state
    found = without_curvature(state.refactorized(q), SETTLED, recorder)
    if found is None or inverted_vertices(found[0].polytope).sum() >= inverted.sum():
        return state
    return found[0]
