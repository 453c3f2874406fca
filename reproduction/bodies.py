"""Meshed surfaces of the gallery and their embeddings, made once for all studies."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

from isoembed import Embedding, Method, NotEmbedded, Paper, PolyhedralMetric, embed
from isoembed.gallery import Surface, triangulate
from isoembed.progress.stages import Progress
from reproduction.arrays import Floats

TOLERANCE = 1e-6  # mean edge lengths: the paper's, of the residual
SAME = 1e-3  # mean edge lengths: nearer surfaces are one; other realizations were 70 times farther


@dataclass(frozen=True, eq=False)
class Body:
    """A closed-form surface and a mesh on it.

    Attributes
    ----------
    surface : Surface
    vertices : ndarray, shape (V, 3)
        On the surface; only comparisons use them.
    metric : PolyhedralMetric
        The lengths of the edges between them.
    """

    surface: Surface
    vertices: Floats
    metric: PolyhedralMetric

    @cached_property
    def exact(self) -> Embedding:
        """The vertices on the surface, as an embedding of their lengths."""
        return Embedding(self.metric, self.vertices, method="exact", tolerance=TOLERANCE)

    def percent_error(self, integrated_mean_curvature: float) -> float:
        """Error of int H dA, in percent of the smooth surface's."""
        return 100 * (integrated_mean_curvature / self.surface.integrated_mean_curvature - 1)


@cache
def meshed(surface: Surface, n: int) -> Body:
    """The surface with a mesh of n vertices."""
    vertices, faces = triangulate(surface, n)
    return Body(surface, vertices, PolyhedralMetric.from_mesh(vertices, faces))


@cache
def embedding_of(body: Body, method: str | Paper, tolerance: float) -> Embedding:
    """`isoembed.embed` of the lengths of a body."""
    return embed(body.metric, method=method, tolerance=tolerance)


def attempted(
    metric: PolyhedralMetric,
    method: str | Method,
    tolerance: float,
    progress: Callable[[Progress], None] | None = None,
) -> Embedding:
    """`isoembed.embed`, or where it fails its best attempt, which says so itself (`Embedding.converged`)."""
    try:
        return embed(metric, method=method, tolerance=tolerance, progress=progress)
    except NotEmbedded as error:
        return error.embedding
