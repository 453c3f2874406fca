"""Embedding of nets: chooses between folding by fold angles and the convex polyhedron."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, NotEmbedded
from isoembed.gluing.net import Net
from isoembed.method import TOLERANCE, solve
from isoembed.methods import as_method
from isoembed.metric.convexity import deficit_rounding
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.stopping import never
from isoembed.progress.checkpoints import Checkpoint
from isoembed.progress.stages import Listener, Log
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.newton_on_lengths import nearest_with_lengths
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem

MOST_SAID = 5
"""Places in a message."""


def embed_net(
    net: Net,
    *,
    tolerance: float = TOLERANCE,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Find the solid that a net is folded to.

    Parameters
    ----------
    net : Net
    tolerance, progress, resume
        As of `isoembed.embed`, which calls this for a net without a method.

    Returns
    -------
    Embedding
        Where the net says how it is folded and that is not convex, the solid folded so.  Otherwise the convex
        polyhedron of its metric, by the method ``"alexandrov"``.  Where there is none, or fold angles are far
        off, what ``"aim"`` finds with flat polygons between the folds.  With boundary or handles, the surface
        that the net is folded to, a `SheetEmbedding`.

    Raises
    ------
    InvalidMetric
        The net has a boundary or handles and does not say how it is folded; or the metric is not convex, the
        net does not say it either, and no solid was found whose faces are its polygons.
    NotEmbedded
        No surface was found.
    """
    if not net.is_sphere:
        return _folded_sheet(net, tolerance, progress)
    folded = None if net.folded is None else _folded(net, tolerance, progress)
    if folded is not None and folded.surface.concave_edges.any():
        return folded
    v = int(np.argmin(net.deficits))
    if net.deficits[v] >= -deficit_rounding(net)[v]:
        return solve(net, as_method("alexandrov"), tolerance=tolerance, progress=progress, resume=resume)
    if net.folded is None:
        found = _with_flat_polygons(net, tolerance, progress)
        if found is not None:
            return found
        raise InvalidMetric(
            f"more than a full turn of paper, {360 - np.degrees(net.deficits[v]):.6g} degrees, meets at "
            f"{_places(net, v)} (vertex {v}): are the right sides glued? If so, the solid is not convex, "
            'and the net does not say how it is folded: what is missing is "folds" (.json), for each polygon '
            "a list of [corner, corner, degrees], edges_foldAngle (.fold) or data-angle (.svg), as 'isoembed "
            "unfold' writes them"
        )
    return folded or solve(
        net.simplicial(), as_method("aim"), tolerance=tolerance, progress=progress, resume=resume
    )


def _places(net: Net, v: int) -> str:
    """The points of the sheets that become a vertex, each by the first polygon that has it."""
    points = np.concatenate(net.polygons)[np.concatenate(net.outlines) == v]
    places = list(dict.fromkeys(f"[{', '.join(f'{x:.6g}' for x in point)}]" for point in points))
    return ", ".join(places[:MOST_SAID]) + f" and {len(places) - MOST_SAID} more" * (len(places) > MOST_SAID)


def _with_flat_polygons(net: Net, tolerance: float, progress: Listener | None) -> Embedding | None:
    """The solid whose faces are the polygons, or parts of such, if one is found."""
    if len(net.polygons) < 4:  # a sheet that is folded: its triangles are none of the faces of the solid
        return None
    try:
        found = solve(net.simplicial(), as_method("aim"), tolerance=tolerance, progress=progress)
    except NotEmbedded:
        return None
    allowed = 1e-7 * found.metric.mean_length + 2 * found.surface.vertex_error

    def is_flat(points: Floats) -> bool:
        across = np.linalg.svd(points - points.mean(axis=0))[2][2]
        return float(np.ptp(points @ across)) <= allowed

    solids = (found, *found.others)
    return next((s for s in solids if all(is_flat(s.vertices[outline]) for outline in net.outlines)), None)


def unknown_folding(net: Net) -> str:
    """Reason why a net with boundary or handles does not say how it is folded; empty if it does."""
    if net.folded is None:
        return (
            "the net has a boundary or handles and does not say how it is folded, and lengths alone do not "
            "determine the surface"
        )
    if len(net.folded) != net.simplicial().triangulation.n_vertices:
        return (
            "faces of the net have several sides in common, and where the vertices are that tell these apart "
            "is not known"
        )
    return ""


def _folded_sheet(net: Net, tolerance: float, progress: Listener | None) -> SheetEmbedding:
    """The surface with boundary or handles that a net is folded to.

    Raises
    ------
    InvalidMetric, NotEmbedded
    """
    unknown = unknown_folding(net)
    if net.folded is None or unknown:
        raise InvalidMetric(f"{unknown}: give boundary='free', 'plane', heights or positions")
    metric = net.simplicial()
    t = metric.triangulation
    if net.precision is not None and t.n_edges > 3 * t.n_vertices - 6:
        # Rounding leaves no surface that has all lengths, as there are more of these than unknowns.
        tolerance = max(tolerance, net.precision.vertex_error)
    log = Log(progress)
    with log.stage("folding") as recorder:
        lengths = LengthConstraints(metric.normalized)
        vertices = nearest_with_lengths(lengths, net.folded / metric.unit, recorder)
    found = SheetEmbedding(
        metric,
        metric.unit * vertices,
        method="folding",
        tolerance=tolerance,
        stages=log.stages,
        condition="folded",
    )
    if not found.converged:
        raise NotEmbedded(found.message, found)
    return found


def _folded(net: Net, tolerance: float, progress: Listener | None) -> Embedding | None:
    """The folded vertices moved until they have the lengths of the net; None if they do not come to that."""
    metric = net.simplicial()
    if net.folded is None or len(net.folded) != metric.triangulation.n_vertices:
        return None
    log = Log(progress)
    with log.stage("folding") as recorder:
        # Angles are known to a few digits at least: Newton's method gains as many at each of a few steps.
        vertices = length_newton(
            LengthSystem(metric.triangulation, work=log.work),
            net.folded / metric.unit,
            metric.normalized.lengths,
            contraction(0.5),
            converged=never,
            max_iterations=10,
            recorder=recorder,
        ).point.x
    embedding = Embedding(
        metric, metric.unit * vertices, method="folding", tolerance=tolerance, stages=log.stages
    )
    return embedding if embedding.converged else None
