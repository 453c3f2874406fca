"""Folding of a crease pattern by its fold angles to a solid."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.mesh.merging import representatives
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class CreaseThresholds:
    """Thresholds of crease patterns that are folded up."""

    meets: float = threshold(
        1e-4, "size of the sheet", "Corners as near in space are one, and sides that differ by as much equal."
    )


CREASES = CreaseThresholds()

Side = tuple[int, int]


def meeting_corners(
    places: Floats, faces: Sequence[Sequence[int]], sheets: Indices, tolerance: float
) -> Indices:
    """Names of the vertices of a folded sheet, the same for those on its boundary that meet, shape (V,).

    Parameters
    ----------
    places : ndarray, shape (V, 3)
    faces : sequence of sequences of int
    sheets : ndarray of int, shape (F,)
        With the places, from `fold_up`.
    tolerance : float
        Corners as near as this in space are one.

    Raises
    ------
    InvalidMetric
        There are several sheets.
    """
    if sheets.any():
        raise InvalidMetric(
            f"face {np.argmax(sheets)} has no side in common with the sheet of face 0: without names of the "
            "corners, one sheet is folded up"
        )
    rim = np.unique([v for side, (_, *others) in _owners(faces).items() if not others for v in side])
    names = np.arange(len(places))
    if len(rim):
        names[rim] = rim[representatives(places[rim], tolerance)]
    return names


def meeting_tolerance(points: Floats) -> float:
    """Distance within which corners of a folded sheet are the same point."""
    return CREASES.meets * (float(np.ptp(points, axis=0).max()) or 1.0)


def _owners(faces: Sequence[Sequence[int]]) -> dict[Side, list[tuple[int, int, int]]]:
    """The faces with each side, (smaller, larger vertex), and its ends as they are around the face."""
    owners: dict[Side, list[tuple[int, int, int]]] = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            owners.setdefault((min(a, b), max(a, b)), []).append((f, a, b))
    return owners


def fold_up(
    points: Floats, faces: Sequence[Sequence[int]], angles: Mapping[Side, float], tolerance: float
) -> tuple[Floats, Indices]:
    """Fold sheets up: the first face of each stays, others follow across the creases.

    Parameters
    ----------
    points : ndarray, shape (V, 2)
    faces : sequence of sequences of int
        The vertices around each, counterclockwise.
    angles : mapping
        By how many radians each crease, (smaller, larger vertex), is folded: positive of valleys.
    tolerance : float
        How far apart the places of a vertex in two faces may be.

    Returns
    -------
    places : ndarray, shape (V, 3)
        The vertices in space, of each sheet by itself; NaN in no face.
    sheets : ndarray of int, shape (F,)
        The sheet of each face, from 0 on.

    Raises
    ------
    InvalidMetric
        Faces have no angle between them, or come apart.
    """
    size = float(np.ptp(points, axis=0).max()) or 1.0  # keeps the squares from under- and overflowing
    points, tolerance, owners = points / size, tolerance / size, _owners(faces)
    flat = np.column_stack([points, np.zeros(len(points))])
    places = np.full_like(flat, np.nan)
    turns: dict[int, tuple[Floats, Floats]] = {}  # x = R p + t
    sheets = np.zeros(len(faces), dtype=np.int64)
    for first in range(len(faces)):
        if first in turns:
            continue
        turns[first] = np.eye(3), np.zeros(3)
        places[faces[first]] = flat[faces[first]]
        sheets[first] = sheets.max() + bool(first)
        waiting = deque([first])
        while waiting:
            f = waiting.popleft()
            turn, shift = turns[f]
            for a, b in zip(faces[f], [*faces[f][1:], faces[f][0]], strict=True):
                side = min(a, b), max(a, b)
                for g, *_ in owners[side]:
                    if g == f:
                        continue
                    if side not in angles:
                        raise InvalidMetric(
                            f"the edge {list(side)} between faces {f} and {g} has no fold angle"
                        )
                    # The face on the right of a -> b is raised by a valley, which turns it about b -> a.
                    own = turn @ _about(flat[a] - flat[b], angles[side])
                    moved = own, turn @ flat[a] + shift - own @ flat[a]
                    _put(places, faces[g], flat[faces[g]] @ own.T + moved[1], g, tolerance)
                    if g not in turns:
                        turns[g], sheets[g] = moved, sheets[first]
                        waiting.append(g)
    return places * size, sheets


def put_together(
    places: Floats, faces: Sequence[Sequence[int]], sheets: Indices, corners: Sequence[Indices]
) -> Floats | None:
    """The vertices of a solid whose sheets are folded: each is moved to where it meets those before it.

    Parameters
    ----------
    places : ndarray, shape (V, 3)
    faces : sequence of sequences of int
    sheets : ndarray of int, shape (F,)
        As of `fold_up`.
    corners : sequence of ndarray of int
        The vertices of the solid around each face.

    Returns
    -------
    ndarray, shape (n, 3), or None
        NaN for vertices inside sides.  None if a sheet may turn about the line in which it meets the others.
    """
    from scipy.spatial.transform import Rotation  # slow to import, and seldom needed

    found = np.full((max(int(c.max()) for c in corners) + 1, 3), np.nan)
    size = float(np.ptp(places[np.isfinite(places[:, 0])], axis=0).max()) or 1.0
    own = [
        (np.concatenate([corners[f] for f in some]), np.concatenate([places[faces[f]] for f in some]) / size)
        for some in (np.flatnonzero(sheets == s).tolist() for s in range(sheets.max() + 1))
    ]
    own.sort(key=lambda sheet: len(sheet[0]))
    vertices, points = own.pop()
    found[vertices] = points
    while own:
        known = [np.isfinite(found[vertices, 0]) for vertices, _ in own]
        # Three points that are not in line hold a sheet: the farther from a line, the better.
        widths = [
            np.linalg.svd(points[here] - points[here].mean(axis=0), compute_uv=False)[1]
            if here.sum() > 2
            else 0
            for here, (_, points) in zip(known, own, strict=True)
        ]
        k = int(np.argmax(widths))
        if widths[k] < CREASES.meets:
            return None
        here, (vertices, points) = known[k], own.pop(k)
        center, target = points[here].mean(axis=0), found[vertices[here]].mean(axis=0)
        turn = Rotation.align_vectors(found[vertices[here]] - target, points[here] - center)[0]
        moved = turn.apply(points - center) + target
        found[vertices[~here]] = moved[~here]
    return found * size


def _put(places: Floats, face: Sequence[int], found: Floats, f: int, tolerance: float) -> None:
    """Put the corners of a face where none are yet; those that are must be there."""
    apart = np.linalg.norm(places[face] - found, axis=1)  # NaN of new ones
    if (apart > tolerance).any():
        v = face[int(np.nanargmax(apart))]
        raise InvalidMetric(f"the fold angles tear the sheet: vertex {v} of face {f} is in two places")
    places[face] = np.where(np.isnan(places[face]), found, places[face])


def _about(axis: Floats, angle: float) -> Floats:
    """Rotation by an angle, counterclockwise about an axis that points at us."""
    x, y, z = axis / (float(np.linalg.norm(axis)) or 1.0)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
