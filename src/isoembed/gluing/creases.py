"""A crease pattern folded by the angles of its creases: where its boundary meets, it is glued."""

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


def meeting_corners(places: Floats, faces: Sequence[Sequence[int]], tolerance: float) -> Indices:
    """Names of the vertices of a folded sheet, the same for those on its boundary that meet, shape (V,).

    Parameters
    ----------
    places : ndarray, shape (V, 3)
        From `fold_up`.
    faces : sequence of sequences of int
    tolerance : float
        Corners as near as this in space are one.

    Raises
    ------
    InvalidMetric
        There are several sheets.
    """
    for f, face in enumerate(faces):
        if np.isnan(places[face]).any():
            raise InvalidMetric(
                f"face {f} has no side in common with the sheet of face 0: one sheet is folded up"
            )
    rim = np.unique([v for side, (_, *others) in _owners(faces).items() if not others for v in side])
    names = np.arange(len(places))
    if len(rim):
        names[rim] = rim[representatives(places[rim], tolerance)]
    return names


def meeting_tolerance(points: Floats) -> float:
    """How near corners of a sheet that is folded up are to one another if they are one."""
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
) -> Floats:
    """The vertices in space, (V, 3): face 0 stays, others follow across the creases; NaN in other sheets.

    Parameters
    ----------
    points : ndarray, shape (V, 2)
    faces : sequence of sequences of int
        The vertices around each, counterclockwise.
    angles : mapping
        By how many radians each crease, (smaller, larger vertex), is folded: positive of valleys.
    tolerance : float
        How far apart the places of a vertex in two faces may be.

    Raises
    ------
    InvalidMetric
        Faces have no angle between them, or come apart.
    """
    size = float(np.ptp(points, axis=0).max()) or 1.0  # keeps the squares from under- and overflowing
    points, tolerance, owners = points / size, tolerance / size, _owners(faces)
    flat = np.column_stack([points, np.zeros(len(points))])
    places = np.full_like(flat, np.nan)
    turns = {0: (np.eye(3), np.zeros(3))}  # x = R p + t
    places[faces[0]] = flat[faces[0]]
    waiting = deque([0])
    while waiting:
        f = waiting.popleft()
        turn, shift = turns[f]
        for a, b in zip(faces[f], [*faces[f][1:], faces[f][0]], strict=True):
            side = min(a, b), max(a, b)
            for g, *_ in owners[side]:
                if g == f:
                    continue
                if side not in angles:
                    raise InvalidMetric(f"the edge {list(side)} between faces {f} and {g} has no fold angle")
                # The face on the right of a -> b is raised by a valley, which turns it about b -> a.
                own = turn @ _about(flat[a] - flat[b], angles[side])
                moved = own, turn @ flat[a] + shift - own @ flat[a]
                _put(places, faces[g], flat[faces[g]] @ own.T + moved[1], g, tolerance)
                if g not in turns:
                    turns[g] = moved
                    waiting.append(g)
    return places * size


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
