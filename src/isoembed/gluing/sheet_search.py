"""Search for edge unfoldings without overlap: few sheets, short cuts, strips or single faces."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidParameter
from isoembed.gluing.edge_choice import forest
from isoembed.gluing.faces import Faces
from isoembed.gluing.loops import joined

Objective = Literal["sheets", "length", "strips", "faces"]
Sheets = tuple[Floats, Indices, Indices]
"""Joined sheets, as returned by `joined`."""


EXCHANGES = 450  # attempts to improve the best net


def found_sheets(
    faces: Faces,
    steps: Floats,
    chosen: tuple[Mask, Indices],
    objective: Objective,
    room: Floats,
) -> Sheets:
    """Search for the best sheets.

    Parameters
    ----------
    faces : Faces
        Faces, scaled to a size of at most 1.
    steps : ndarray, shape (S, 3)
        Vector along each side, in space.
    chosen : ndarray of bool, ndarray of int
        Cut and kept sides, from `chosen_sides`.
    objective : str
    room : ndarray, shape (2,)
        Rectangle, as in `joined`.

    Raises
    ------
    InvalidParameter
        Faces kept together overlap or are not a strip, or the objective is unknown.
    """
    if objective not in get_args(Objective):
        raise InvalidParameter(f"objective is {objective!r}, not one of {', '.join(get_args(Objective))}")
    is_cut, edges = chosen
    anything = len(steps), np.full(2, np.inf)
    _check_kept(faces, edges, anything, "join overlap")
    if objective == "faces":
        return joined(faces, edges, *anything)
    limits = 2 if objective == "strips" else len(steps), room
    _check_kept(faces, edges, (limits[0], anything[1]), "join do not form a strip")
    _check_kept(faces, edges, limits, "join do not fit in the rectangle")
    lengths = np.linalg.norm(steps, axis=1)
    directions = steps / lengths[:, None]
    rng = np.random.default_rng(0)
    free = ~is_cut
    free[edges] = False

    def start(by_length: bool) -> Indices:
        if by_length:
            order = np.argsort(-lengths, kind="stable")
            order = order[order < faces.twins[order]]
        else:
            order = _order(faces, directions, rng.normal(size=3))
        return order[free[order]]

    def tried(order: Indices) -> Sheets:
        return joined(faces, np.concatenate([edges, order]), *limits)

    def cost(found: Sheets) -> float:
        return float(lengths[found[1] >= 0].sum()) if objective == "length" else len(np.unique(found[2]))

    one_start = objective == "length"
    order = start(one_start)
    best = tried(order)
    lowest = cost(best)
    # Without overlaps, faces would be joined to trees, along long sides if the cuts are to be short.
    tree = forest(faces, np.concatenate([edges, order]))
    bound = float(len(faces.first) - 1 - len(tree))
    if objective == "length":
        bound = float(lengths.sum() - 2 * lengths[tree].sum()) * (1 + 1e-12)
    last = 50  # directions; this attempt starts with sides ordered by length
    for k in range(last + 1 if one_start else 1, last + 1 + EXCHANGES):
        if lowest <= bound:
            break
        exchange = k > last
        if exchange:  # first join two sheets that stayed separate, or faces that were cut apart
            between = np.flatnonzero(best[2][order] != best[2][faces.twins[order]])
            if not len(between):
                between = np.flatnonzero(best[1][order] >= 0)
            first = rng.choice(between)
            changed = np.concatenate([[order[first]], np.delete(order, first)])
        else:
            changed = start(k == last)
        found = tried(changed)
        value = cost(found)
        if value < lowest or (exchange and value == lowest):
            lowest, best, order = value, found, changed
    return best


def _check_kept(faces: Faces, kept: Indices, limits: tuple[int, Floats], why: str) -> None:
    apart = joined(faces, kept, *limits)[1][kept] >= 0
    if apart.any():
        s = kept[np.argmax(apart)]
        a, b = faces.corners[s], faces.ends[s]
        raise InvalidParameter(
            f"the edge ({a}, {b}) cannot be kept: faces that it and the previous edges {why}"
        )


def _order(faces: Faces, directions: Floats, up: Floats) -> Indices:
    """Sides ordered by preference for joining the faces across them."""
    slopes = directions @ (up / np.linalg.norm(up))
    sharp = np.abs(faces.angles) > 1e-3  # radians; smaller ones are cut only if no others can be
    faceted = np.bincount(faces.corners, sharp) > 0
    boundary = np.zeros(len(faceted), dtype=np.bool_)
    boundary[faces.corners[faces.twins == np.arange(len(slopes))]] = True
    # The steepest ascending side at each interior vertex is cut; diagonals of flat faces are not.
    climb = np.where((sharp | ~faceted[faces.corners]) & ~boundary[faces.corners], slopes, 0.0)
    by_climb = np.lexsort([climb, faces.corners])
    steepest = by_climb[np.append(np.diff(faces.corners[by_climb]) != 0, True)]
    cut = np.zeros(len(slopes), dtype=np.bool_)
    cut[steepest] = climb[steepest] > 0
    cut |= cut[faces.twins]
    along = np.where(sharp, np.abs(slopes), -1.0)
    along[cut] = 1.0 + np.abs(slopes[cut])
    order = np.argsort(along, kind="stable")
    return order[order < faces.twins[order]]
