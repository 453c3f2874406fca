"""Drawing of lines on a surface among its faces, by the painter's algorithm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.plot.view import View
from isoembed.surface.segments import Segments

if TYPE_CHECKING:
    from matplotlib.collections import PolyCollection


class Shapes(NamedTuple):
    """Faces and lines in drawing order.

    Attributes
    ----------
    polygons : sequence of ndarray, shape (m, 2)
        Polygons; lines have two corners.
    fills, rims : ndarray, shape (n, 3)
        Colors of the interiors and of the outlines.
    widths : ndarray, shape (n,)
        Widths of the outlines.
    """

    polygons: Sequence[Floats]
    fills: Floats
    rims: Floats
    widths: Floats

    def collection(self, opacity: float = 1.0) -> PolyCollection:
        """Collection for matplotlib."""
        from matplotlib.collections import PolyCollection

        return PolyCollection(
            self.polygons,
            facecolors=self.fills,
            edgecolors=self.rims,
            linewidths=self.widths,
            joinstyle="round",
            alpha=None if opacity == 1.0 else opacity,
            clip_on=False,  # silhouette edges have a width
        )


def among_faces(view: View, faces: Shapes, lines: Sequence[tuple[Segments, Floats, float]]) -> Shapes:
    """Insert lines among the visible faces.

    Parameters
    ----------
    view : View
    faces : Shapes
        Faces of the view, farthest first.
    lines : sequence of (Segments, ndarray, float)
        Lines, colors, and widths; colors (n, 3) are those of lines beside each face, (3,) of all lines.
    """
    n = len(view.faces)
    indices = [view.faces, *(segments.faces for segments, *_ in lines)]
    place = np.full(1 + max(int(index.max(initial=0)) for index in indices), -1)
    place[view.faces] = np.arange(n)
    polygons, places, colors, widths = [*faces.polygons], [np.arange(float(n))], [], [faces.widths]
    for segments, color, width in lines:
        beside = place[segments.faces].max(axis=1)
        visible = beside[beside >= 0]
        polygons += [*view.put(segments.ends[beside >= 0])]
        places.append(visible + 0.5)
        colors.append(np.broadcast_to(color, faces.fills.shape)[visible])
        widths.append(np.full(len(visible), width))
    order = np.argsort(np.concatenate(places), kind="stable")
    return Shapes(
        [polygons[k] for k in order],
        np.concatenate([faces.fills, *colors])[order],
        np.concatenate([faces.rims, *colors])[order],
        np.concatenate(widths)[order],
    )
