"""Folding of crease patterns by their fold angles."""

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.gluing.polygon import consecutive
from isoembed.mesh.merging import representatives

MEETS = 1e-4  # sizes of the sheet: largest distance of coincident corners

Side = tuple[int, int]


def meeting_corners(
    places: Floats, faces: Sequence[Sequence[int]], sheets: Indices, tolerance: float
) -> Indices:
    """Vertex labels of a folded sheet, equal for coincident boundary vertices, shape (V,).

    Parameters
    ----------
    places : ndarray, shape (V, 3)
    faces : sequence of sequences of int
    sheets : ndarray of int, shape (F,)
        Sheets and places from `fold_up`.
    tolerance : float
        Corners within this distance in space are identified.

    Raises
    ------
    InvalidMetric
        There are several sheets; corner names are required.
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
    """Distance in space within which corners of a folded sheet are identified."""
    return MEETS * (float(np.ptp(points, axis=0).max()) or 1.0)


def _owners(faces: Sequence[Sequence[int]]) -> dict[Side, list[tuple[int, int, int]]]:
    """Faces at each side (smaller, larger vertex), with its endpoints in the order around the face."""
    owners: dict[Side, list[tuple[int, int, int]]] = {}
    for f, face in enumerate(faces):
        for a, b in consecutive(face):
            owners.setdefault((min(a, b), max(a, b)), []).append((f, a, b))
    return owners


def fold_up(
    points: Floats, faces: Sequence[Sequence[int]], angles: Mapping[Side, float], tolerance: float
) -> tuple[Floats, Indices]:
    """Fold sheets: the first face of each stays fixed, and the others follow across the creases.

    Parameters
    ----------
    points : ndarray, shape (V, 2)
    faces : sequence of sequences of int
        Vertices around each face, counterclockwise.
    angles : mapping
        Fold angle of each crease (smaller, larger vertex) in radians, positive for valleys.
    tolerance : float
        Largest distance between the positions of a vertex computed from two faces.

    Returns
    -------
    places : ndarray, shape (V, 3)
        Vertices in space, separately for each sheet; NaN for vertices in no face.
    sheets : ndarray of int, shape (F,)
        Sheet of each face, numbered from 0.

    Raises
    ------
    InvalidMetric
        A crease has no angle, or the angles are inconsistent.
    """
    size = float(np.ptp(points, axis=0).max()) or 1.0  # prevents underflow and overflow of squares
    points, tolerance, owners = points / size, tolerance / size, _owners(faces)
    flat = np.column_stack([points, np.zeros(len(points))])
    places = np.full_like(flat, np.nan)
    turns: dict[int, tuple[Floats, Floats]] = {}  # rigid motion x = R p + t of each face
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
            for a, b in consecutive(faces[f]):
                side = min(a, b), max(a, b)
                for g, *_ in owners[side]:
                    if g == f:
                        continue
                    if side not in angles:
                        raise InvalidMetric(
                            f"the edge {list(side)} between faces {f} and {g} has no fold angle"
                        )
                    # A valley raises the face on the right of a -> b, rotating it about b -> a.
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
    """Assemble folded sheets: each sheet is aligned with its common vertices with those placed before.

    Parameters
    ----------
    places : ndarray, shape (V, 3)
    faces : sequence of sequences of int
    sheets : ndarray of int, shape (F,)
        Sheets and places from `fold_up`.
    corners : sequence of ndarray of int
        Vertices of the solid around each face.

    Returns
    -------
    ndarray, shape (n, 3), or None
        NaN for vertices inside sides.  None if the common vertices of a sheet are collinear.
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
        placed = [np.isfinite(found[vertices, 0]) for vertices, _ in own]
        # Three noncollinear points fix a sheet, the better the farther they are from a line.
        widths = [
            np.linalg.svd(points[here] - points[here].mean(axis=0), compute_uv=False)[1]
            if here.sum() > 2
            else 0
            for here, (_, points) in zip(placed, own, strict=True)
        ]
        k = int(np.argmax(widths))
        if widths[k] < MEETS:
            return None
        here, (vertices, points) = placed[k], own.pop(k)
        center, target = points[here].mean(axis=0), found[vertices[here]].mean(axis=0)
        turn = Rotation.align_vectors(found[vertices[here]] - target, points[here] - center)[0]
        moved = turn.apply(points - center) + target
        found[vertices[~here]] = moved[~here]
    return found * size


def _put(places: Floats, face: Sequence[int], found: Floats, f: int, tolerance: float) -> None:
    """Set the positions of a face's corners; corners already placed must agree."""
    apart = np.linalg.norm(places[face] - found, axis=1)  # NaN for new corners
    if (apart > tolerance).any():
        v = face[int(np.nanargmax(apart))]
        raise InvalidMetric(f"the fold angles tear the sheet: vertex {v} of face {f} is in two places")
    places[face] = np.where(np.isnan(places[face]), found, places[face])


def _about(axis: Floats, angle: float) -> Floats:
    """Rotation about an axis by an angle, counterclockwise as seen from the tip of the axis."""
    x, y, z = axis / (float(np.linalg.norm(axis)) or 1.0)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
