"""Nets in FOLD format: crease patterns with the vertex identifications of the solid.

FOLD has no standard field for gluings.  Corner names are stored in a custom field: sides whose endpoints have
the same two names are glued.  Without names, the sheet is folded by its fold angles and coinciding sides are
glued.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.gluing import Net, glue
from isoembed.gluing.creases import fold_up, meeting_corners, meeting_tolerance, put_together
from isoembed.gluing.net import glue_rounded
from isoembed.gluing.polygon import is_number, points_of_the_plane
from isoembed.gluing.sheet_faces import glued_faces
from isoembed.gluing.unfolding import Unfolding
from isoembed.io import json
from isoembed.io.files import FileError
from isoembed.io.fold import CORNERS
from isoembed.io.input_file import InputFile
from isoembed.metric.precision import Precision
from isoembed.version import __version__

ANGLES = "edges_foldAngle"  # in degrees
PRECISION = "file_isoembed:precision"  # precision of the coordinates of the solid
ANY_SURFACE = "file_isoembed:any_surface"  # true if unglued sides are a boundary
GAP = 0.1  # between sheets, relative to the width of the previous one


def read_crease_pattern(file: InputFile, tolerance: float | None = None) -> Net:
    """Read the faces of a crease pattern and glue them by corner names or by folding.

    The tolerance is that of `isoembed.glue`; it also matches the corners of a folded pattern.

    Raises
    ------
    FileError
        The file lacks faces, planar points, or both names and fold angles.
    InvalidMetric, InvalidParameter
        The faces make no metric, or the fold angles tear them apart.
    """

    def chosen(document: dict[str, Any]) -> dict[str, Any]:
        names = {"faces": "faces_vertices", "vertices": "vertices_coords"}
        if document.get(CORNERS) or not document.get(ANGLES):
            names |= {"corners": CORNERS}
        if document.get(ANGLES):
            names |= {"edges": "edges_vertices", "angles": ANGLES}
        if PRECISION in document:
            names |= {"precision": PRECISION}
        if document.get(ANY_SURFACE):
            names |= {"any_surface": ANY_SURFACE}
        for name in names.values():
            if not document.get(name):
                raise FileError(
                    f"{file} has no {name}: a net is a crease pattern with names of its corners, or with "
                    f"{ANGLES}"
                )
        return {ours: document[theirs] for ours, theirs in names.items()}

    tables = json.parse(file.data, str(file), chosen)
    points, corners = tables["vertices"], tables.get("corners")
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
    near, folded = meeting_tolerance(points) if tolerance is None else tolerance, None
    if "edges" in tables:
        folded = fold_up(points, faces, _angles(tables["edges"], tables["angles"], file), near)
    if corners is None and folded is not None:
        places, sheets = folded
        corners, tolerance = meeting_corners(places, faces, sheets, near).tolist(), near
    elif not isinstance(corners, list) or len(corners) != len(points):
        raise FileError(f"{file}: {CORNERS} is not a list of {len(points)} names, one for each vertex")
    names = [[corners[v] for v in face] for face in faces]
    any_surface = tables.get("any_surface") is True
    polygons = [points[face] for face in faces]
    net = glue(polygons, corners=names, tolerance=tolerance, any_surface=any_surface)
    return with_places(net.knowing(precision=_precision(tables.get("precision"), str(file))), faces, folded)


def creased_net(document: Mapping[str, Any], tolerance: float | None, name: str) -> Net:
    """Glue the ``polygons`` of a document along whole ``sides``, with ``folds`` as from `creases`.

    Raises
    ------
    FileError
        An entry of the named file does not have the form written by ``isoembed unfold``.
    InvalidMetric, InvalidParameter
        See `glue`.
    """
    sides, folds = document["sides"], document["folds"]
    outlines = [points_of_the_plane(sheet, f"polygon {p}") for p, sheet in enumerate(document["polygons"])]
    if not isinstance(folds, list) or len(folds) != len(outlines):
        raise FileError(f"the folds of {name} are not {len(outlines)} lists, one for each polygon")
    faces: list[list[list[int]]] = []
    angles, first = {}, [0]
    for p, (outline, own) in enumerate(zip(outlines, folds, strict=True)):
        n, chords = len(outline), []
        for fold in own if isinstance(own, list) else [own]:
            if not _is_fold(fold, n):
                raise FileError(
                    f"{name}: {str(fold)[:40]} is not a fold of polygon {p}: [corner, corner, degrees], "
                    f"between two of its {n} corners that are not neighbors"
                )
            chords.append(fold[:2])
            a, b = sorted(fold[:2])
            angles[first[-1] + a, first[-1] + b] = -math.radians(fold[2])
        faces.append(_faces(n, np.array(chords, dtype=np.int64).reshape(-1, 2)))
        first.append(first[-1] + n)
    if not isinstance(sides, list) or any(not isinstance(pair, list) or len(pair) != 2 for pair in sides):
        raise FileError(f"the sides of {name} are not a list of pairs")
    for side in (side for pair in sides for side in pair):
        whole = isinstance(side, list) and len(side) == 2 and all(isinstance(x, int) for x in side)
        if not whole or not 0 <= side[0] < len(outlines):
            raise FileError(f"{name} glues {str(side)[:40]}: with folds, sides are [polygon, side]")
        if not 0 <= side[1] < len(outlines[side[0]]):
            raise FileError(
                f"{name} glues side {side[1]} of polygon {side[0]}, which has {len(outlines[side[0]])} sides"
            )
    pairs = glued_faces(faces, sides, list(map(len, outlines)))
    points = np.concatenate(outlines)
    every = [
        [start + corner for corner in face] for start, own in zip(first, faces, strict=False) for face in own
    ]
    rounding, any_surface = _precision(document.get("precision"), name), declared_any_surface(document, name)
    net = glue_rounded([points[face] for face in every], pairs, rounding, tolerance, any_surface)
    folded = fold_up(points, every, angles, meeting_tolerance(points))
    return with_places(net, every, folded)


def declared_any_surface(document: Mapping[str, Any], name: str) -> bool:
    """Whether the unglued sides of the net in the named file are a boundary."""
    value = document.get("any_surface", False)
    if not isinstance(value, bool):
        raise FileError(f"{name}: any_surface is {str(value)[:40]}, not true or false")
    return value


def creases(unfolding: Unfolding) -> list[list[list[Any]]]:
    """Folds of each sheet as [corner, corner, degrees], positive where the solid is convex."""
    return [
        [[*ends, angle] for ends, angle in zip(folds.tolist(), bends, strict=True)]
        for folds, bends in zip(unfolding.fold_corners, map(np.degrees, unfolding.angles), strict=True)
    ]


def solid_entries(unfolding: Unfolding, precision: str, any_surface: str) -> dict[str, Any]:
    """Entries for the precision of the solid, if known, and for surfaces with boundary or handles."""
    entries = {} if unfolding.precision is None else {precision: asdict(unfolding.precision)}
    return {**entries, any_surface: True} if unfolding.any_surface else entries


def _is_fold(fold: Any, n: int) -> bool:
    """Whether the fold is a valid [corner, corner, degrees] of an n-gon."""
    if not isinstance(fold, list) or len(fold) != 3 or not all(type(k) is int for k in fold[:2]):
        return False
    a, b, angle = fold
    inside = min(a, b) >= 0 and max(a, b) < n and (a - b) % n not in (0, 1, n - 1)
    return inside and is_number(angle) and abs(angle) <= 180


def _precision(value: Any, name: str) -> Precision | None:
    """Precision stored in the named file, if any."""
    if value is None:
        return None
    error = value.get("length_error") if isinstance(value, dict) else None
    if not is_number(error) or not 0 < error < math.inf or not isinstance(value.get("name"), str):
        raise FileError(f"{name}: the precision is {str(value)[:40]}, not a name and a length_error")
    return Precision(value["name"], float(error))


def with_places(net: Net, faces: Sequence[Sequence[int]], folded: tuple[Floats, Indices] | None) -> Net:
    """Net with the positions of its folded vertices, if the file has fold angles."""
    if folded is not None:
        places, sheets = folded
        vertices = put_together(places, faces, sheets, net.corners)
        if vertices is not None and len(vertices) == net.n_vertices and np.isfinite(vertices).all():
            net = net.knowing(folded=vertices)
    return net


def _angles(edges: Any, degrees: Any, file: InputFile) -> dict[tuple[int, int], float]:
    """Fold angles in radians, keyed by the endpoints of the edges in increasing order."""
    if not isinstance(degrees, list) or len(degrees) != len(edges):
        raise FileError(f"{file}: {ANGLES} is not a list of {len(edges)} angles, one for each edge")
    angles = {}
    for e, (edge, angle) in enumerate(zip(edges, degrees, strict=True)):
        if len(edge) != 2 or not np.isfinite(edge).all():
            raise FileError(f"{file}: edge {e} does not have two ends")
        if angle is None:  # boundary edge
            continue
        if isinstance(angle, bool) or not isinstance(angle, int | float) or not abs(angle) <= 180:
            raise FileError(f"{file}: the fold angle of edge {e} is {angle!r}, not from -180 to 180")
        a, b = edge
        angles[int(min(a, b)), int(max(a, b))] = math.radians(angle)
    return angles


def crease_pattern(unfolding: Unfolding) -> dict[str, Any]:
    """FOLD object with the sheets side by side; mountain folds bend away from an outside viewer."""
    points, edges, faces = [], [], []
    letters, angles = [], []
    first, right = 0, 0.0
    for sheet, chords, bends in zip(unfolding.sheets, unfolding.fold_corners, unfolding.angles, strict=True):
        n = len(sheet)
        low, high = sheet.min(axis=0), sheet.max(axis=0)
        points.append(sheet - low + [right, 0.0])
        right += (1 + GAP) * (high[0] - low[0])
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
        **solid_entries(unfolding, PRECISION, ANY_SURFACE),
        "vertices_coords": np.concatenate(points),
        CORNERS: np.concatenate(unfolding.corners),
        "edges_vertices": edges,
        "edges_assignment": letters,
        ANGLES: angles,
        "faces_vertices": faces,
    }


def _faces(n: int, chords: Indices) -> list[list[int]]:
    """Faces into which non-crossing chords divide a polygon of n corners."""
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
