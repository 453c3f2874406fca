"""From lengths to a surface: isometric embedding of polyhedral metrics in Euclidean 3-space.

Give the triangles of a closed surface and the length of every edge; get the surface back::

    import isoembed

    metric = isoembed.PolyhedralMetric(faces, lengths, edges)
    surface = isoembed.embed(metric)
    surface.vertices

The public names are imported on first use, so that ``import isoembed`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from isoembed.version import __version__

_HOME = {
    "Interrupted": "isoembed.errors",
    "InvalidMetric": "isoembed.errors",
    "InvalidParameter": "isoembed.errors",
    "MeshNote": "isoembed.errors",
    "NoHorizon": "isoembed.errors",
    "NoMinimum": "isoembed.errors",
    "NotEmbedded": "isoembed.errors",
    "Triangulation": "isoembed.mesh.triangulation",
    "PolyhedralMetric": "isoembed.metric.polyhedral",
    "GluedMetric": "isoembed.metric.glued",
    "glue": "isoembed.gluing.net",
    "unfold": "isoembed.gluing.unfolding",
    "Embedding": "isoembed.surface.embedding",
    "FittedSurface": "isoembed.surface.fitted",
    "embed": "isoembed._embed",
    "Method": "isoembed._embed",
    "Checkpoint": "isoembed.progress.stages",
    "Aim": "isoembed.aim.adaptive",
    "Paper": "isoembed.aim.paper",
    "Alexandrov": "isoembed.alexandrov.method",
    "ConvexPolyhedron": "isoembed.alexandrov.polyhedron",
}

__all__ = ["__version__", *_HOME]

if TYPE_CHECKING:
    from isoembed import progress as progress
    from isoembed._embed import Method as Method
    from isoembed._embed import embed as embed
    from isoembed.aim.adaptive import Aim as Aim
    from isoembed.aim.paper import Paper as Paper
    from isoembed.alexandrov.method import Alexandrov as Alexandrov
    from isoembed.alexandrov.polyhedron import ConvexPolyhedron as ConvexPolyhedron
    from isoembed.errors import Interrupted as Interrupted
    from isoembed.errors import InvalidMetric as InvalidMetric
    from isoembed.errors import InvalidParameter as InvalidParameter
    from isoembed.errors import MeshNote as MeshNote
    from isoembed.errors import NoHorizon as NoHorizon
    from isoembed.errors import NoMinimum as NoMinimum
    from isoembed.errors import NotEmbedded as NotEmbedded
    from isoembed.gluing.net import glue as glue
    from isoembed.gluing.unfolding import unfold as unfold
    from isoembed.mesh.triangulation import Triangulation as Triangulation
    from isoembed.metric.glued import GluedMetric as GluedMetric
    from isoembed.metric.polyhedral import PolyhedralMetric as PolyhedralMetric
    from isoembed.progress.stages import Checkpoint as Checkpoint
    from isoembed.surface.embedding import Embedding as Embedding
    from isoembed.surface.fitted import FittedSurface as FittedSurface


def __getattr__(name: str) -> Any:
    if name == "progress":  # isoembed.progress.bar
        return import_module("isoembed.progress")
    if name not in _HOME:
        raise AttributeError(f"module 'isoembed' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
