"""Browser page of a net: folding with a slider, and the drawing beside it."""

from __future__ import annotations

import base64
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import signed_area
from isoembed.io.files import Writer
from isoembed.mesh.triangulation import Triangulation
from isoembed.method import TOLERANCE
from isoembed.metric.distances import lengths_between
from isoembed.metric.given_mesh import triangle_mesh
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.papercraft.drawing import Drawing
from isoembed.papercraft.folding import partly_folded
from isoembed.papercraft.svg import svg
from isoembed.plot.film import Frame
from isoembed.plot.page import page_writer
from isoembed.space import EUCLIDEAN
from isoembed.surface.flat_faces import FlatFaces
from isoembed.surface.measures import volume
from isoembed.surface.surface import Surface

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

FRAMES = 40  # of the film


@dataclass(frozen=True, eq=False, repr=False)
class _NetSurface(Surface):
    """Surface of a net in space, with the faces of the solid."""

    of_triangles: Indices | None = None

    @cached_property
    def flat_faces(self) -> FlatFaces:
        assert self.of_triangles is not None
        nowhere = np.zeros(self.triangulation.n_vertices, dtype=np.bool_)
        return FlatFaces(self.triangulation, self.of_triangles, self._lengths, nowhere)


@dataclass(frozen=True, eq=False, repr=False)
class _FoldedNet(Embedding):
    """Net in space, for pictures with the faces of the solid."""

    of_triangles: Indices | None = None

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        return super()._made_surface(_NetSurface, of_triangles=self.of_triangles, **more)

    def _shaped(self, vertices: Floats, message: str) -> _FoldedNet:
        """Return the net with other vertices, with its faces."""
        return _FoldedNet(
            self.metric, vertices, method="", tolerance=1.0, message=message, of_triangles=self.of_triangles
        )


def folding_page_writer(path: str | os.PathLike[str], unfolding: Unfolding, pages: Drawing) -> Writer:
    """Writer of the page; see `isoembed.io.write_atomically`.

    Parameters
    ----------
    path : path
        Ends with ``.html``.
    unfolding : Unfolding
    pages : Drawing
        Drawing of the net.

    Raises
    ------
    InvalidParameter
        The net has several sheets.
    """
    if len(unfolding.sheets) > 1:
        raise InvalidParameter(
            f"the net has {len(unfolding.sheets)} sheets: a page shows the folding of a single sheet"
        )
    flat, faces = partly_folded(unfolding, 0.0)
    points, triangles, _ = triangle_mesh(flat, faces)
    triangulation = Triangulation(triangles)  # the sheet is a disk: narrow slits stay open
    metric = PolyhedralMetric.on(triangulation, lengths_between(triangulation, points, EUCLIDEAN))
    sizes = np.array([len(face) for face in faces])
    owners = np.repeat(np.arange(len(faces)), sizes - 2)
    shares = (1 - np.cos(np.linspace(0.0, np.pi, FRAMES))) / 2
    frames = [Frame("folding", None, None, partly_folded(unfolding, share)[0]) for share in shares]
    solid = _FoldedNet(
        metric, frames[-1].vertices, method="folding", tolerance=TOLERANCE, of_triangles=owners
    )
    picture = base64.b64encode(svg(pages).encode()).decode("ascii")
    return page_writer(
        path,
        solid,
        title=Path(path).stem,
        frames=frames,
        caption=str(unfolding),
        tables=_counted(unfolding, pages.net, volume(triangles, solid.vertices)),
        beside=f'<p><img width="100%" alt="The net" src="data:image/svg+xml;base64,{picture}"></p>\n',
    )


def _counted(unfolding: Unfolding, printed: Unfolding, enclosed: float) -> dict[str, dict[str, float]]:
    """Counts and measures of the solid, and of the printed net, by table."""
    ((sheet,), (folds,), (faces,)) = unfolding.sheets, unfolding.folds, unfolding.faces
    solid: dict[str, float] = {
        "vertices": len(np.unique(unfolding.corners[0])),
        "edges": len(sheet) - len(unfolding.sides) + len(folds),
        "faces": len(faces),
        "area": signed_area(sheet),
    }
    if not unfolding.any_surface:
        solid["volume"] = enclosed
    net = {"pairs_of_sides": len(printed.sides), "folds": sum(map(len, printed.folds))}
    return {"solid": solid, "net": {"sheets": len(printed.sheets), **net}}
