"""The surface, or the best attempt at it: studies measure both."""

from __future__ import annotations

from isoembed._embed import Method, embed
from isoembed.errors import NotEmbedded
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Listener
from isoembed.surface.embedding import Embedding


def attempted(
    metric: PolyhedralMetric, method: str | Method, tolerance: float, progress: Listener | None = None
) -> Embedding:
    """`isoembed.embed`, or where it fails its best attempt, which says so itself (`Embedding.converged`)."""
    try:
        return embed(metric, method=method, tolerance=tolerance, progress=progress)
    except NotEmbedded as error:
        return error.embedding
