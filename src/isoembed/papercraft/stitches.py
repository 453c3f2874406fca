"""Stitching holes: equal numbers on both sides of a seam."""

from collections.abc import Sequence

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.gluing.line_graph import is_inside
from isoembed.gluing.polygon import Side
from isoembed.papercraft.material import Material


def stitches(
    outlines: Sequence[Floats], sides: Sequence[tuple[Side, Side]], material: Material
) -> list[Floats]:
    """Centers of the holes of each sheet, shape (n, 2).

    A side of length l has max(1, floor(l / spacing)) equal parts, with a hole in the middle of each.  Of
    holes inset from their side, those within 1.5 spacings of another side are omitted on both sides of the
    seam, so that holes of different sides are at least half a spacing apart.

    Parameters
    ----------
    outlines : sequence of ndarray, shape (n, 2)
        Outlines of the sheets, counterclockwise, mm.
    sides : sequence of pairs
        Pairs of joined sides ``((p, k), (q, m))``.
    material : Material
    """
    found: list[list[Floats]] = [[] for _ in outlines]
    inset = 0.0 if material.allowance else material.spacing
    for pair in sides:
        ends = [outlines[p][[k, (k + 1) % len(outlines[p])]] for p, k in pair]
        length = float(np.hypot(*(ends[0][1] - ends[0][0])))
        count = max(1, int(length / material.spacing))
        parts = (np.arange(count) + 0.5) / count
        places: list[Floats] = []
        fit = np.ones(count, dtype=np.bool_)
        for (p, k), (start, end) in zip(pair, ends, strict=True):
            along = (end - start) / np.hypot(*(end - start))
            inward = np.array([-along[1], along[0]])
            here = start + parts[:, None] * (end - start) + inset * inward
            clear = _clear(outlines[p], k, here, 1.5 * inset) if inset else np.ones(count, dtype=np.bool_)
            fit &= clear if len(places) == 0 else clear[::-1]  # the sides have opposite directions
            places.append(here)
        for (p, _), here, span in zip(pair, places, (fit, fit[::-1]), strict=True):
            found[p].append(here[span])
    return [np.concatenate([np.empty((0, 2)), *some]) for some in found]


def _clear(outline: Floats, side: int, points: Floats, distance: float) -> Mask:
    """Mask of points beside a side that are on the sheet and far enough from all other sides."""
    starts, ends = np.delete(outline, side, axis=0), np.delete(np.roll(outline, -1, axis=0), side, axis=0)
    step = ends - starts
    away = points[:, None] - starts
    part = np.clip((away * step).sum(axis=2) / (step**2).sum(axis=1), 0.0, 1.0)
    apart = np.hypot(*np.moveaxis(away - part[..., None] * step, 2, 0))
    inside = [is_inside(point, outline) for point in points]
    return np.asarray((apart >= distance).all(axis=1) & inside)
