"""Glue tabs: trapezoids on one of two glued sides."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from isoembed.arrays import Floats
from isoembed.gluing.line_graph import is_inside
from isoembed.gluing.polygon import Side, interior_angles, segments
from isoembed.papercraft.convex import Pieces, overlaps
from isoembed.papercraft.labels import SHRINK

DEPTH, LEAST = 7.0, 0.8  # mm, largest and smallest depth
SLANT = np.radians(55.0)  # largest angle of a leg to the side
CLEAR = 1.1  # clearance: a tab this much deeper must not meet anything either


def tabs(outlines: Sequence[Floats], sides: Sequence[tuple[Side, Side]]) -> dict[Side, Floats]:
    """Tabs that overlap neither sheets nor each other.

    Parameters
    ----------
    outlines : sequence of ndarray, shape (n, 2)
        Outlines of the sheets, counterclockwise, in mm on the paper.
    sides : sequence of pairs
        Pairs of glued sides ``((p, k), (q, m))``.

    Returns
    -------
    dict
        Outer corners, (2, 2), of the tab on side ``(p, k)``, in the order of the side.  Pairs without room
        for a tab are omitted.
    """
    rims, others = Pieces(2, chain.from_iterable(map(segments, outlines))), Pieces(4)
    shapes: dict[Side, Floats] = {}
    for pair in sides:
        best, top = 0.0, np.zeros((2, 2))
        for side, mate in (pair, pair[::-1]):
            depth, found = _deepest(outlines, side, mate, rims, others)
            if depth > best:
                best, top, (p, k) = depth, found, side
        if best:
            shapes[p, k] = top
            ends = outlines[p][[k, (k + 1) % len(outlines[p])]]
            others.add(_piece(ends, top))
    return shapes


def _deepest(
    outlines: Sequence[Floats], side: Side, mate: Side, rims: Pieces, others: Pieces
) -> tuple[float, Floats]:
    """Depth and outer corners of the deepest tab on a side; depth 0 if there is no room."""
    p, k = side
    outline = outlines[p]
    n = len(outline)
    before, start, end, after = outline[[k - 1, k, (k + 1) % n, (k + 2) % n]]
    legs = [
        # Of the angle beside a side, half is left to the tab of another side.
        1 / np.tan(min(SLANT, (0.8 if mate == (p, beside % n) else 0.45) * gap))
        for beside, gap in (
            (k - 1, interior_angles(before - start, end - start)),
            (k + 1, interior_angles(start - end, after - end)),
        )
    ]
    length = float(np.hypot(*(end - start)))
    along = (end - start) / length
    out = np.array([along[1], -along[0]])
    depth = min(DEPTH, 0.4 * length, 0.9 / CLEAR * length / max(sum(legs), 0.1))

    def top(depth: float) -> Floats:
        return np.array([start + depth * (legs[0] * along + out), end + depth * (out - legs[1] * along)])

    ends = np.array([start, end])
    if depth < LEAST:
        return 0.0, ends
    near, pieces = (some.near(np.vstack([ends, top(CLEAR * depth)])) for some in (rims, others))
    joined = (near[:, :, None] == ends).all(axis=3).any(axis=(1, 2))
    while depth >= LEAST:
        deeper = top(CLEAR * depth)
        piece, whole = _piece(ends, deeper), np.vstack([ends, deeper[::-1]])
        # Across a narrow slit, a tab could lie inside a sheet without meeting its sides.
        if (
            not overlaps(piece, near[joined])
            and not overlaps(piece, pieces)
            and not overlaps(whole, near[~joined])
            and not any(is_inside(piece.mean(axis=0), sheet) for sheet in outlines)
        ):
            return depth, top(depth)
        depth *= SHRINK
    return 0.0, ends


def _piece(ends: Floats, top: Floats) -> Floats:
    """Tab outline, (4, 2), slightly detached from the side."""
    foot = ends + 1e-3 * (top - ends)  # the corners are shared with other tabs
    return np.array([foot[0], foot[1], top[1], top[0]])
