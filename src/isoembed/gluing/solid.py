"""Embedding of nets: folded by their fold angles, or as the convex polyhedron."""

import numpy as np

from isoembed.errors import InvalidMetric
from isoembed.gluing.net import Net
from isoembed.linalg import SingularMatrix
from isoembed.method import TOLERANCE, solve
from isoembed.methods import configured
from isoembed.metric.convexity import deficit_rounding
from isoembed.progress.stages import Checkpoint, Listener, Log
from isoembed.surface.embedding import Embedding
from isoembed.surface.rigidity import LengthSystem, length_residuals


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
        polyhedron of its metric, by the method ``"alexandrov"``.  Where fold angles are far off, what
        ``"aim"`` finds on the faces between the folds.

    Raises
    ------
    InvalidMetric
        The metric is not convex, and the net does not say how it is folded.
    NotEmbedded
        No surface was found.
    """
    folded = None if net.folded is None else _folded(net, tolerance, progress)
    if folded is not None and folded.concave_edges.any():
        return folded
    v = int(np.argmin(net.deficits))
    if net.deficits[v] >= -deficit_rounding(net.faces, net.face_lengths, net.curvature)[v]:
        return solve(net, configured("alexandrov"), tolerance=tolerance, progress=progress, resume=resume)
    if net.folded is None:  # the triangles of its polygons are none of the faces of the solid
        raise InvalidMetric(
            f"vertex {v} has total angle {2 * np.pi - net.deficits[v]:.10g} > 2 pi: the metric is not "
            "convex, and the net does not tell how one sheet of it is folded: 'isoembed unfold' writes nets "
            "that do, as .json with folds or as .fold with edges_foldAngle"
        )
    return folded or solve(
        net.simplicial(), configured("aim"), tolerance=tolerance, progress=progress, resume=resume
    )


def _folded(net: Net, tolerance: float, progress: Listener | None) -> Embedding | None:
    """The folded vertices moved until they have the lengths of the net; None if they do not come to that."""
    metric = net.simplicial()
    if net.folded is None or len(net.folded) != metric.triangulation.n_vertices:
        return None
    unit = metric.normalized
    vertices, lengths = net.folded / metric.unit, unit.lengths
    log = Log(progress)
    with log.stage("folding") as recorder:
        system = LengthSystem(metric.triangulation)
        residuals = length_residuals(metric.triangulation, vertices, lengths)
        # Angles are known to a few digits at least: Newton's method gains as many at each of a few steps.
        for _ in range(10):
            recorder.iterations += 1
            try:
                moved = vertices - system.step(vertices, lengths, residuals)
            except SingularMatrix:
                break
            after = length_residuals(metric.triangulation, moved, lengths)
            if not np.abs(after).max() < np.abs(residuals).max() / 2:
                break
            vertices, residuals = moved, after
    embedding = Embedding(
        metric, metric.unit * vertices, method="folding", tolerance=tolerance, stages=log.stages
    )
    return embedding if embedding.converged else None
