"""FOLD, the origami format (https://github.com/edemaine/fold, specification 1.2): faces and folds in JSON.

A frame with coordinates is read as a mesh, one with only edge lengths as a metric.  Convex folds, seen from
outside, are mountain folds.
"""

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from json import dumps
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.io import json
from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format, Polygons, at_vertices, flattened
from isoembed.io.input_file import InputFile
from isoembed.mesh.polygons import next_corners, polygon_normals
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.precision import Precision
from isoembed.surface.curvature import FLAT_ANGLE, SHUT, bend_errors
from isoembed.version import __version__

Frame = dict[str, Any]

NAMES = {
    "faces": "faces_vertices",
    "vertices": "vertices_coords",
    "edges": "edges_vertices",
    "lengths": "edges_length",
    "length_errors": "edges_isoembed:length_error",
}
WHOLE = {
    **{"curvature": "isoembed:curvature", "model": "isoembed:model"},
    **{"precision": "isoembed:precision", "rounding_error": "isoembed:rounding_error"},
}
"""FOLD names of the curvature, the model and the precision of the coordinates."""
CORNERS = "vertices_isoembed:corner"  # the solid's vertex to which a net's corner belongs


def read(file: InputFile) -> Tables:
    """Read the first frame that is a closed surface, or else the first with faces.

    Raises
    ------
    FileError
        The file is not FOLD, has no faces, or is a flat sheet with boundary.
    InvalidMetric
        A table holds values other than numbers.
    """
    return json.parse(file.data, str(file), lambda document: _tables(document, str(file)))


def _tables(document: Frame, name: str) -> Frame:
    """Tables of a surface or a metric, with FOLD names replaced."""
    frames = [frame for frame in _frames(document, name) if frame.get(NAMES["faces"]) is not None]
    if not frames:
        raise FileError(
            f"{name} has no faces_vertices: a surface needs them, with vertices_coords or edges_length"
        )
    frame = next((frame for frame in frames if _open_side(frame) is None), frames[0])
    tables = {ours: frame[theirs] for ours, theirs in NAMES.items() if frame.get(theirs) is not None}
    if "vertices" in tables:
        points = tables["vertices"]
        if _is_flat(points):
            if (side := _open_side(frame)) is not None:
                if CORNERS in frame:
                    raise FileError(f"{name} is a net: glue it first, with isoembed.glue({name!r})")
                raise FileError(
                    f"{name} is a flat sheet with a boundary, as from vertex {side[0]} to {side[1]}: name "
                    f"its corners, {CORNERS}, or give edges_foldAngle, for isoembed.glue, or give the "
                    "closed form"
                )
            tables["vertices"] = [[*point, 0.0] for point in points]
        mesh = {key: tables[key] for key in ("vertices", "faces")}  # these determine the lengths
        return mesh | {key: document[name] for key, name in WHOLE.items() if name in document}
    sizes = [len(face) if isinstance(face, list) else 0 for face in _list(tables["faces"])]
    if "lengths" in tables and max(sizes, default=0) > 3:
        k = next(k for k, size in enumerate(sizes) if size > 3)
        raise FileError(
            f"{name}: face {k} has {sizes[k]} corners, and its side lengths do not determine its "
            "shape: cut it into triangles"
        )
    return tables


def _list(entry: Any) -> list[Any]:
    """The given list; empty if it is something else, which a later check rejects."""
    return entry if isinstance(entry, list) else []


def _frames(document: Frame, name: str) -> Iterator[Frame]:
    """All frames, with inherited entries."""
    others = document.get("file_frames") or []
    if not isinstance(others, list) or not all(isinstance(frame, dict) for frame in others):
        raise FileError(f"{name}: its file_frames are not a list of frames")
    frames = [document, *others]
    for k, frame in enumerate(frames):
        inherited, at, visited = dict(frame), k, {k}
        while at > 0 and frames[at].get("frame_inherit") is True:
            at = frames[at].get("frame_parent", 0)
            if isinstance(at, bool) or not isinstance(at, int) or not 0 <= at < len(frames) or at in visited:
                raise FileError(f"{name}: frame {k} inherits from frame {at!r}, which it cannot")
            visited.add(at)
            inherited = frames[at] | inherited
        yield inherited


def _open_side(frame: Frame) -> tuple[int, int] | None:
    """A side of only one face; None if there is none, or the faces are not lists of integers."""
    counts: Counter[tuple[int, int]] = Counter()
    for face in _list(frame[NAMES["faces"]]):
        if not isinstance(face, list) or not all(type(corner) is int for corner in face):
            return None
        counts.update((min(pair), max(pair)) for pair in pairwise([*face, *face[:1]]))
    return next((side for side, count in counts.items() if count == 1), None)


def _is_flat(points: Any) -> bool:
    return isinstance(points, list) and all(isinstance(point, list) and len(point) == 2 for point in points)


def write(path: Path, tables: Tables) -> None:
    """Write vertices, faces, and edges with lengths and fold angles."""
    vertices, faces = np.asarray(tables["vertices"], dtype=np.float64), tables["faces"]
    edges, lengths, angles, inner = _edges(vertices, faces)
    if "rounding_error" in tables and isinstance(faces, np.ndarray):  # polygons have no flat edges inside
        error = Precision("", float(tables["rounding_error"])).vertex_error
        explained = FLAT_ANGLE + bend_errors(Triangulation(faces), vertices, error=error)
        angles[np.abs(angles) <= np.degrees(explained)] = 0.0
    letters = np.where(angles == 0, "F", np.where(angles < 0, "M", "V"))
    metadata = {
        "file_spec": 1.2,
        "file_creator": f"isoembed {__version__}",
        "file_classes": ["singleModel"],
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D", "manifold", "orientable"],
        **{name: np.asarray(tables[key]).item() for key, name in WHOLE.items() if key in tables},
        "edges_assignment": np.where(inner, letters, "B").tolist(),
        "faces_vertices": [np.asarray(face).tolist() for face in faces],
    }
    arrays = {
        "vertices_coords": vertices,
        "edges_vertices": edges,
        "edges_foldAngle": angles,
        "edges_length": lengths,
        **{f"vertices_isoembed:{key}": value for key, value in at_vertices(tables).items()},
    }
    with path.open("w", encoding="utf-8") as file:
        for key, value in metadata.items():
            file.write(("{" if key == "file_spec" else ", ") + f"{dumps(key)}: {dumps(value)}")
        for key, array in arrays.items():
            file.write(f", {dumps(key)}: ")
            file.writelines(json.written(array))
        file.write("}\n")


def _edges(vertices: Floats, faces: Polygons) -> tuple[Indices, Floats, Floats, np.ndarray]:
    """Edges, lengths, fold angles in degrees (mountains negative), and a mask of interior edges."""
    corners, sizes = flattened(faces)
    starts, ends, owners = corners, corners[next_corners(sizes)], np.repeat(np.arange(len(sizes)), sizes)
    rising = starts < ends
    edges, number = np.unique(np.sort(np.column_stack([starts, ends]), axis=1), axis=0, return_inverse=True)
    number = number.ravel()  # a column in NumPy 2.0
    left, right = np.full(len(edges), -1), np.full(len(edges), -1)
    left[number[rising]], right[number[~rising]] = owners[rising], owners[~rising]
    inner = (left >= 0) & (right >= 0)
    size = float(np.abs(vertices).max()) or 1.0
    points = vertices / size
    normals = polygon_normals(points[corners], sizes)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    along = points[edges[:, 1]] - points[edges[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    along /= np.maximum(lengths, np.finfo(float).tiny)[:, None]
    sine = (np.cross(normals[left], normals[right]) * along).sum(axis=1)
    cosine = (normals[left] * normals[right]).sum(axis=1)
    sine = np.where((cosine < 0) & (np.abs(sine) < SHUT), np.abs(sine), sine)
    bend = np.arctan2(sine, cosine)
    bend[~inner | (np.abs(bend) <= FLAT_ANGLE)] = 0.0
    return edges, lengths * size, 0.0 - np.degrees(bend), inner


FORMAT = Format(".fold", read, write, holds_polygons=True)
