"""Embedding of nets, by their fold angles or as convex polyhedra."""

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
from isoembed.reprs import listed
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.newton_on_lengths import nearest_with_lengths
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem


def embed_net(
    net: Net,
    *,
    tolerance: float = TOLERANCE,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Embed a net.

    Parameters
    ----------
    net : Net
    tolerance, progress, resume
        See `isoembed.embed`, which calls this function for a net without a method.

    Returns
    -------
    Embedding
        The folded solid, if the net has fold angles and is not convex.  Otherwise the convex polyhedron of
        its metric, by the method ``"alexandrov"``.  If there is none, or the fold angles are inaccurate, a
        solution of ``"aim"`` with flat polygons between the folds.  With boundary or handles, the folded
        surface as a `SheetEmbedding`.

    Raises
    ------
    InvalidMetric
        The net has a boundary or handles but no fold angles; or its metric is not convex, it has no fold
        angles, and no solid was found whose faces are its polygons.
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
            f"more than a full turn of paper, {360 - np.degrees(net.deficits[v]):.6g} degrees, meets "
            f"at {_places(net, v)} (vertex {v}): are the right sides glued? If so, the solid is not "
            'convex, and the net lacks its fold angles: "folds" (.json), for each polygon a list of '
            "[corner, corner, degrees], edges_foldAngle (.fold) or data-angle (.svg), as "
            "isoembed.io.write_net writes them"
        )
    return folded or solve(
        net.simplicial(), as_method("aim"), tolerance=tolerance, progress=progress, resume=resume
    )


def _places(net: Net, v: int) -> str:
    """Points of the sheets that are glued to a vertex, as text."""
    points = np.concatenate(net.polygons)[np.concatenate(net.outlines) == v]
    places = list(dict.fromkeys(f"[{', '.join(f'{x:.6g}' for x in point)}]" for point in points))
    return listed(places)


def _with_flat_polygons(net: Net, tolerance: float, progress: Listener | None) -> Embedding | None:
    """Solid whose faces are the polygons or parts of them, if one is found."""
    if len(net.polygons) < 4:  # folded sheets: their triangles are not faces of the solid
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
    """Reason why a net with boundary or handles lacks folding data; empty if it has them."""
    if net.folded is None:
        return (
            "the net has a boundary or handles and no fold angles, and lengths alone do not determine "
            "the surface"
        )
    if len(net.folded) != net.simplicial().triangulation.n_vertices:
        return (
            "faces of the net have several sides in common, and the positions of the vertices that "
            "distinguish them are unknown"
        )
    return ""


def _folded_sheet(net: Net, tolerance: float, progress: Listener | None) -> SheetEmbedding:
    """Folded surface of a net with boundary or handles.

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
        # With more lengths than unknowns, rounded lengths cannot all be satisfied.
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
    """Solid from the folded vertices, corrected to the lengths of the net; None if this fails."""
    metric = net.simplicial()
    if net.folded is None or len(net.folded) != metric.triangulation.n_vertices:
        return None
    log = Log(progress)
    with log.stage("folding") as recorder:
        # Angles have at least a few digits, and each Newton step doubles their number.
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
