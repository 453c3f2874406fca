"""Islands: partition of sheets larger than a page by cuts along folds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.gluing.polygon import consecutive
from isoembed.mesh.triangulation import frozen
from isoembed.papercraft.packing import SLACK

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

Fold = tuple[int, int]
"""Corners of a sheet at the ends of a fold, in the order around the face nearer to the root."""

KEPT = 12  # partitions of a subtree for each number of islands


@dataclass(frozen=True, eq=False)
class _Partition:
    """A partition of a subtree of faces, with an open island that contains the root face.

    Attributes
    ----------
    islands : int
        Number of islands without the open one.
    length : float
        Total length of the cuts.
    support : ndarray, shape (4, D)
        Support function of the open island in each direction and at right angles to it.
    cuts : tuple
        Folds that are cut, in nested tuples.
    """

    islands: int
    length: float
    support: Floats
    cuts: tuple[Any, ...]


def partition(sheet: Floats, faces: Sequence[Indices], room: Floats) -> list[Fold]:
    """Folds along which to cut a sheet so that every piece fits into a rectangle, in some orientation.

    Dynamic programming on the tree of faces: from the leaves to the root, each subtree has partitions with
    the fewest islands, and with one more.  Among these, some are kept with short cuts and with a small open
    island, which continues beyond the root of the subtree.  Fewer islands take precedence over shorter cuts.
    More islands than the minimum do not reduce the total: the fold above may be cut instead.

    Parameters
    ----------
    sheet : ndarray, shape (n, 2)
    faces : sequence of ndarray of int
        Corners around each uncut part, as from `parts`; each fits on its own.
    room : ndarray, shape (2,)
        Width and height, in the unit of the sheet.
    """
    order, parents, folds = _tree(faces)
    directions = _directions(sheet, faces)
    reach = [_reach(sheet[face] - sheet[0], directions) for face in faces]
    lengths = [0.0 if fold is None else float(np.hypot(*(sheet[fold[1]] - sheet[fold[0]]))) for fold in folds]
    open_ = [[_Partition(0, 0.0, support, ())] for support in reach]
    for child in reversed(order[1:]):
        parent, below, fold, length = parents[child], open_[child], folds[child], lengths[child]
        shortest = {one.islands: one for one in sorted(below, key=lambda one: -one.length)}
        found = [
            _Partition(
                one.islands + closed.islands + 1, one.length + closed.length + length, one.support,
                (one.cuts, closed.cuts, fold),
            )
            for one in open_[parent]
            for closed in shortest.values()
        ]  # fmt: skip
        supports = np.maximum(
            np.array([one.support for one in open_[parent]])[:, None],
            np.array([one.support for one in below]),
        )
        fits = _needed(supports, room) <= 1 + SLACK
        found += [
            _Partition(
                one.islands + other.islands, one.length + other.length, supports[i, j], (one.cuts, other.cuts)
            )
            for i, one in enumerate(open_[parent])
            for j, other in enumerate(below)
            if fits[i, j]
        ]
        open_[parent] = _best(found, room)
        open_[child] = []
    return list(_flat(min(open_[order[0]], key=lambda one: (one.islands, one.length)).cuts))


def _tree(faces: Sequence[Indices]) -> tuple[list[int], list[int], list[Fold | None]]:
    """Faces in order from the root, the parent of each, and the fold shared with it, as in the parent."""
    owner = {ends: f for f, face in enumerate(faces) for ends in consecutive(face)}
    beside: list[list[tuple[int, Fold]]] = [[] for _ in faces]
    for (a, b), f in owner.items():
        if (b, a) in owner:
            beside[f].append((owner[b, a], (a, b)))
    order, parents = [0], [-1] * len(faces)
    folds: list[Fold | None] = [None] * len(faces)
    for f in order:
        for g, fold in beside[f]:
            if g != parents[f]:
                parents[g], folds[g] = f, fold
                order.append(g)
    return order, parents, folds


def _directions(sheet: Floats, faces: Sequence[Indices]) -> Floats:
    """Directions in a right angle, radians: evenly spaced ones, and those of the longest sides of faces."""
    count = min(max(100_000 // len(faces), 90), 720)  # limits the memory for many faces
    sides = np.concatenate([sheet[np.roll(face, -1)] - sheet[face] for face in faces])
    longest = sides[np.argsort(-np.hypot(*sides.T), kind="stable")[: 2 * count]]
    along = np.arctan2(longest[:, 1], longest[:, 0]) % (np.pi / 2)
    return np.unique(np.concatenate([np.arange(count) * np.pi / 2 / count, along]).round(12))


def _reach(points: Floats, directions: Floats) -> Floats:
    """Support function of points in each direction and at right angles to it, shape (4, D)."""
    angles = directions + np.pi / 2 * np.arange(4)[:, None]
    x, y = points[:, :, None, None].transpose(1, 0, 2, 3)
    return np.asarray((x * np.cos(angles) + y * np.sin(angles)).max(axis=0))


def _needed(supports: Floats, room: Floats) -> Floats:
    """Size of islands in the best direction, relative to the rectangle."""
    first, second = supports[..., 0, :] + supports[..., 2, :], supports[..., 1, :] + supports[..., 3, :]
    upright = np.maximum(first / room[0], second / room[1])
    return np.minimum(upright, np.maximum(first / room[1], second / room[0])).min(axis=-1)


def _best(found: Sequence[_Partition], room: Floats) -> list[_Partition]:
    """Undominated partitions with the fewest islands and with one more, at most `KEPT` each, shortest first.

    One additional island may permit shorter cuts in total.  A partition is dominated by another with cuts no
    longer and an open island no larger.
    """
    fewest = min(one.islands for one in found)
    candidates = []
    for islands in (fewest, fewest + 1):
        some = [one for one in found if one.islands == islands]
        if not some:
            continue
        supports = np.array([one.support for one in some])
        order = np.lexsort((_needed(supports, room), np.array([one.length for one in some])))
        useful: list[int] = []
        for k in order.tolist():
            if len(useful) < KEPT and not (supports[useful] <= supports[k] + 1e-12).all(axis=(1, 2)).any():
                useful.append(k)
        candidates += [some[k] for k in useful]
    return candidates


def _flat(cuts: tuple[Any, ...]) -> Iterator[Fold]:
    """Folds in nested tuples."""
    stack = [cuts]
    while stack:
        some = stack.pop()
        if len(some) == 2 and isinstance(some[0], int):
            yield some
        else:
            stack += some


def parts(unfolding: Unfolding, p: int) -> list[tuple[str, Indices]]:
    """Uncut parts of a sheet: faces, and faces joined by `kept` folds.

    Returns
    -------
    list of (str, ndarray of int)
        Name with the number of the first face, and the corners of the sheet around the part.
    """
    corners, faces, numbers = unfolding.corners[p].tolist(), unfolding.faces[p], unfolding.numbers[p]
    if not unfolding.kept:
        return [(f"face {number}", face) for number, face in zip(numbers.tolist(), faces, strict=True)]
    loose = {
        fold
        for fold in _tree(faces)[2]
        if fold is not None and (corners[fold[0]], corners[fold[1]]) not in unfolding.kept
    }
    return [
        (
            f"face {numbers[first]}{' with the faces kept attached to it' if others else ''}",
            np.array(_outline([faces[f] for f in (first, *others)])),
        )
        for first, *others in _components(faces, loose)
    ]


def cut_along(unfolding: Unfolding, cuts: Sequence[Sequence[Fold]]) -> Unfolding:
    """Cut sheets along folds, which yields more sheets and pairs of sides, and fewer folds.

    Parameters
    ----------
    unfolding : Unfolding
    cuts : sequence of sequence of (int, int)
        For each sheet, the corners at the ends of the folds to be cut.
    """
    sheets: list[Floats] = []
    corners, folds, angles, faces, numbers = [], [], [], [], []
    place: dict[tuple[int, int, int], tuple[int, int]] = {}  # new side, by old sheet and corners
    for p, (sheet, cut) in enumerate(zip(unfolding.sheets, cuts, strict=True)):
        for mine in _components(unfolding.faces[p], {*cut, *((b, a) for a, b in cut)}):
            ring = _outline([unfolding.faces[p][f] for f in mine])
            number = {corner: k for k, corner in enumerate(ring)}
            for k, (a, b) in enumerate(consecutive(ring)):
                place[p, a, b] = len(sheets), k
            inside = [
                m
                for m, (a, b) in enumerate(unfolding.fold_corners[p].tolist())
                if a in number and b in number and (p, a, b) not in place and (p, b, a) not in place
            ]
            sheets.append(frozen(sheet[ring]))
            corners.append(frozen(unfolding.corners[p][ring]))
            folds.append(frozen(unfolding.folds[p][inside]))
            angles.append(frozen(unfolding.angles[p][inside]))
            faces.append(
                tuple(frozen(np.array([number[c] for c in unfolding.faces[p][f].tolist()])) for f in mine)
            )
            numbers.append(frozen(unfolding.numbers[p][mine]))

    def moved(side: tuple[int, int]) -> tuple[int, int]:
        p, k = side
        return place[p, k, (k + 1) % len(unfolding.sheets[p])]

    sides = [(moved(one), moved(other)) for one, other in unfolding.sides]
    sides += [(place[p, a, b], place[p, b, a]) for p, cut in enumerate(cuts) for a, b in cut]
    return replace(
        unfolding, sheets=tuple(sheets), corners=tuple(corners), sides=tuple(sides), folds=tuple(folds),
        angles=tuple(angles), faces=tuple(faces), numbers=tuple(numbers),
    )  # fmt: skip


def _components(faces: Sequence[Indices], cut: set[Fold]) -> list[list[int]]:
    """Faces of each piece, in order."""
    order, parents, folds = _tree(faces)
    first = list(range(len(faces)))
    for f in order[1:]:
        if folds[f] not in cut:
            first[f] = first[parents[f]]
    pieces: dict[int, list[int]] = {}
    for f, root in enumerate(first):
        pieces.setdefault(root, []).append(f)
    return list(pieces.values())


def _outline(faces: Sequence[Indices]) -> list[int]:
    """Corners around joined faces, starting at the lowest."""
    sides = {ends for face in faces for ends in consecutive(face)}
    after = {a: b for a, b in sides if (b, a) not in sides}
    ring = [min(after)]
    while (corner := after[ring[-1]]) != ring[0]:
        ring.append(corner)
    return ring
