"""Nets in FOLD: crease patterns whose vertices say which corner of the solid they become.

FOLD has no word for what is glued.  The corners have names, in a field of our own: sides whose ends have the
same two names are glued.  Where there are none, the sheet is folded up by its fold angles, and what meets is.
"""

import math
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.gluing import Net, glue
from isoembed.gluing.creases import meeting_corners
from isoembed.gluing.unfolding import Unfolding
from isoembed.io import json
from isoembed.io.files import FileError
from isoembed.io.fold import CORNERS
from isoembed.io.input_file import InputFile
from isoembed.version import __version__

ANGLES = "edges_foldAngle"  # in degrees
GAP = 0.1  # between sheets, of the width of the one before


def read_crease_pattern(file: InputFile) -> Net:
    """Read the faces of a crease pattern and glue them by the names of their corners, or as they fold up.

    Raises
    ------
    FileError
        It has no faces, points of the plane, or neither names nor fold angles.
    InvalidMetric, InvalidParameter
        The faces make no metric, or the fold angles tear them apart.
    """

    def chosen(document: dict[str, Any]) -> dict[str, Any]:
        names = {"faces": "faces_vertices", "vertices": "vertices_coords", "corners": CORNERS}
        if not document.get(CORNERS) and document.get(ANGLES):
            names |= {"edges": "edges_vertices", "corners": ANGLES}
        for name in names.values():
            if not document.get(name):
                raise FileError(
                    f"{file} has no {name}: a net is a crease pattern with names of its corners, or with "
                    f"{ANGLES}"
                )
        return {ours: document[theirs] for ours, theirs in names.items()}

    tables = json.parse(file.data, str(file), chosen)
    points, corners = tables["vertices"], tables["corners"]
    if points.shape[1:] != (2,):
        raise FileError(
            f"{file}: its vertices_coords are not points [x, y], as those of a crease pattern are"
        )
    if not (finite := np.isfinite(points).all(axis=1)).all():
        v = int(np.argmin(finite))
        raise FileError(f"{file}: vertex {v} is at {points[v].tolist()}, which is not finite")
    faces = [[int(v) if v in range(len(points)) else -1 for v in face] for face in tables["faces"]]
    for k, face in enumerate(faces):
        if not face or -1 in face:
            raise FileError(f"{file}: face {k} is not made of the {len(points)} vertices")
    if "edges" in tables:
        corners = meeting_corners(points, faces, _angles(tables["edges"], corners, file)).tolist()
    elif not isinstance(corners, list) or len(corners) != len(points):
        raise FileError(f"{file}: {CORNERS} is not a list of {len(points)} names, one for each vertex")
    return glue([points[face] for face in faces], corners=[[corners[v] for v in face] for face in faces])


def _angles(edges: Any, degrees: Any, file: InputFile) -> dict[tuple[int, int], float]:
    """The fold angles in radians by the ends of the edges, the smaller first."""
    if not isinstance(degrees, list) or len(degrees) != len(edges):
        raise FileError(f"{file}: {ANGLES} is not a list of {len(edges)} angles, one for each edge")
    angles = {}
    for e, (edge, angle) in enumerate(zip(edges, degrees, strict=True)):
        if len(edge) != 2 or not np.isfinite(edge).all():
            raise FileError(f"{file}: edge {e} does not have two ends")
        if angle is None:  # of a boundary
            continue
        if isinstance(angle, bool) or not isinstance(angle, int | float) or not abs(angle) <= 180:
            raise FileError(f"{file}: the fold angle of edge {e} is {angle!r}, not from -180 to 180")
        a, b = edge
        angles[int(min(a, b)), int(max(a, b))] = math.radians(angle)
    return angles


def crease_pattern(unfolding: Unfolding) -> dict[str, Any]:
    """The sheets beside one another, as an object of FOLD; mountains bend away from who sees the outside."""
    points, edges, faces = [], [], []
    letters, angles = [], []
    first, right = 0, 0.0
    for sheet, folds, bends in zip(unfolding.sheets, unfolding.folds, unfolding.angles, strict=True):
        n = len(sheet)
        low, high = sheet.min(axis=0), sheet.max(axis=0)
        points.append(sheet - low + [right, 0.0])
        right += (1 + GAP) * (high[0] - low[0])
        chords = _nearest(sheet, folds)
        edges += [[first + k, first + (k + 1) % n] for k in range(n)]
        edges += (first + chords).tolist()
        letters += ["B"] * n + ["M" if bend > 0 else "V" for bend in bends]
        angles += [0.0] * n + (-np.degrees(bends)).tolist()
        faces += [[first + k for k in face] for face in _faces(n, chords)]
        first += n
    return {
        "file_spec": 1.2,
        "file_creator": f"isoembed {__version__}",
        "file_classes": ["singleModel"],
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D", "manifold", "orientable"],
        "vertices_coords": np.concatenate(points),
        CORNERS: np.concatenate(unfolding.corners),
        "edges_vertices": edges,
        "edges_assignment": letters,
        ANGLES: angles,
        "faces_vertices": faces,
    }


def _nearest(sheet: Floats, folds: Floats) -> Indices:
    """The corners at the ends of the folds, shape (m, 2)."""
    size = np.ptp(sheet, axis=0).max()  # keeps the squares from under- and overflowing
    apart = np.linalg.norm(folds[:, :, None] / size - sheet / size, axis=3)
    return np.argmin(apart, axis=2)


def _faces(n: int, chords: Indices) -> list[list[int]]:
    """The parts of a polygon of n corners that chords which do not cross cut it into."""
    ways = [[(k + 1) % n, (k - 1) % n] for k in range(n)]
    for a, b in chords.tolist():
        ways[a].append(b)
        ways[b].append(a)
    for k, some in enumerate(ways):
        some.sort(key=lambda other: (other - k) % n)
    left = {(k, other) for k, some in enumerate(ways) for other in some[:-1]}
    faces = []
    for begin in sorted(left):
        a, b = begin
        face = []
        while (a, b) in left:
            left.remove((a, b))
            face.append(a)
            a, b = b, ways[b][ways[b].index(a) - 1]
        if face:
            faces.append(face)
    return faces
