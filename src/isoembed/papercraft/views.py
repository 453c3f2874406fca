"""Hidden-line drawings of a solid from two sides, with face numbers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices, Mask, chunks
from isoembed.gluing.polygon import consecutive, signed_area
from isoembed.intrinsic.ears import triangulated
from isoembed.papercraft.labels import Label
from isoembed.papercraft.numbers import face_numbers

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

TOWARD = np.array([0.48, -0.72, 0.5])  # preferred direction of view
TURNS = 24  # azimuths of other directions
SAMPLES = 24  # per edge, to determine hidden parts
CLOSE = 1e-6  # of the size of the solid: closer objects do not hide anything


def views(
    unfolding: Unfolding, vertices: Floats, low: Floats, high: Floats
) -> tuple[list[Floats], list[Label]]:
    """Visible edges and face numbers of the solid, seen from two opposite sides, one view above the other.

    The direction minimizes the foreshortening of the faces in the geometric mean.  For a surface with
    boundary, the inside is visible, too.

    Parameters
    ----------
    unfolding : Unfolding
    vertices : ndarray, shape (V, 3)
        Vertices of the solid.
    low, high : ndarray, shape (2,)
        Corners of the rectangle filled by both views, mm.
    """
    vertices = vertices / np.abs(vertices).max()
    vertices = vertices - vertices.mean(axis=0)
    vertices = vertices / np.abs(vertices).max()
    faces = [
        (number, sheet[face], corners[face])
        for sheet, corners, some, numbers in zip(
            unfolding.sheets, unfolding.corners, unfolding.faces, unfolding.numbers, strict=True
        )
        for number, face in zip(numbers.tolist(), some, strict=True)
    ]
    triangles = np.concatenate([_triangles(points, corners) for _, points, corners in faces])
    toward = _toward(vertices[triangles])
    cameras = [_camera(side * toward) for side in (1, -1)]
    flat = [vertices @ camera for camera in cameras]
    half = np.array([high[0] - low[0], 0.48 * (high[1] - low[1])])
    scale = min(float((half / np.ptp(projection[:, :2], axis=0)).min()) for projection in flat)
    lines, labels = [], []
    for k, projection in enumerate(flat):
        middle = (projection[:, :2].max(axis=0) + projection[:, :2].min(axis=0)) / 2
        center = np.array([(low[0] + high[0]) / 2, high[1] - half[1] / 2 if k == 0 else low[1] + half[1] / 2])
        projection = np.column_stack(
            [(projection[:, :2] - middle) * scale + center, projection[:, 2] * scale]
        )
        areas = [signed_area(projection[corners, :2]) for *_, corners in faces]
        front = [
            (number, corners if area > 0 else corners[::-1])
            for (number, _, corners), area in zip(faces, areas, strict=True)
            if (abs(area) if unfolding.any_surface else area) > CLOSE * scale**2
        ]
        before = projection[triangles]
        upward = np.array([signed_area(corners[:, :2]) for corners in before]) > 0
        before = np.concatenate(
            [before[upward], before[~upward, ::-1][: len(before) * unfolding.any_surface]]
        )
        edges = {tuple(sorted(ends)) for _, face in front for ends in consecutive(face)}
        ends = np.array(sorted(edges), dtype=np.int64).reshape(-1, 2)
        visible = _visible(projection[ends], before, CLOSE * scale)
        lines += visible
        numbers = face_numbers(
            [projection[face, :2] for _, face in front],
            [number for number, _ in front],
            lines=visible,
            is_seen=partial(_is_seen, [projection[face] for _, face in front], before, CLOSE * scale),
        )
        labels += [one for one in numbers if one is not None]
    return lines, labels


def _is_seen(faces: Sequence[Floats], triangles: Floats, close: float, k: int, points: Floats) -> Mask:
    """Mask of the points, (n, 2), of the k-th face that are in front of all triangles."""
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    reach = (triangles[:, :, :2].max(axis=1) > low) & (triangles[:, :, :2].min(axis=1) < high)
    near = triangles[reach.all(axis=1)]
    return ~_hidden(np.column_stack([points, _depths(faces[k], points)]), near, close)


def _toward(triangles: Floats) -> Floats:
    """Direction in which triangles, (n, 3, 3), are least foreshortened."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(normals, axis=1)
    normals = normals[sizes > 0] / sizes[sizes > 0, None]
    turns, rises = (
        some.ravel() for some in np.meshgrid(2 * np.pi * np.arange(TURNS) / TURNS, (0.3, 0.5, 0.7))
    )
    level = np.sqrt(1 - rises**2)
    ways = np.vstack([TOWARD, np.column_stack([level * np.sin(turns), -level * np.cos(turns), rises])])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    # Faces seen at smaller cosines are equally invisible.
    visibility = np.log(np.maximum(np.abs(normals @ ways.T), 1e-3)).sum(axis=0)
    return np.asarray(ways[int(np.argmax(visibility.round(9)))])


def _camera(toward: Floats) -> Floats:
    """Camera axes as columns: right, upward and toward the viewer."""
    toward = toward / np.linalg.norm(toward)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(toward, right), toward])


def _triangles(points: Floats, corners: Indices) -> Indices:
    """Triangles of a face, as vertices of the solid."""
    found = triangulated((points - points.min(axis=0)) / np.ptp(points, axis=0).max())
    return corners[found if found is not None else [[0, k, k + 1] for k in range(1, len(corners) - 1)]]


def _depths(face: Floats, points: Floats) -> Floats:
    """Heights toward the viewer of a face's plane at given points, (n, 2)."""
    plane = np.linalg.lstsq(
        np.column_stack([face[:, :2] - face[0, :2], np.ones(len(face))]), face[:, 2], rcond=None
    )[0]
    return np.asarray((points - face[0, :2]) @ plane[:2] + plane[2])


def _visible(edges: Floats, triangles: Floats, close: float) -> list[Floats]:
    """Parts of edges, (n, 2, 3), in front of all triangles."""
    steps = np.linspace(0.0, 1.0, SAMPLES + 1)
    middles = (steps[1:] + steps[:-1]) / 2
    points = edges[:, :1] + middles[:, None] * (edges[:, 1:] - edges[:, :1])
    shown = ~_hidden(points.reshape(-1, 3), triangles, close).reshape(points.shape[:2])
    found = []
    for edge, visible in zip(edges[:, :, :2], shown, strict=True):
        changes = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]]).astype(np.int8)))
        found += [edge[0] + steps[ends, None] * (edge[1] - edge[0]) for ends in changes.reshape(-1, 2)]
    return found


def _hidden(points: Floats, triangles: Floats, close: float) -> Mask:
    """Mask of points, (n, 3), behind any counterclockwise triangle, (m, 3, 3)."""
    hidden = np.zeros(len(points), dtype=np.bool_)
    sides = np.roll(triangles, -1, axis=1) - triangles
    normal = np.cross(sides[:, 0], sides[:, 1])
    for part in chunks(len(points), max(1, (1 << 22) // max(len(triangles), 1))):  # bounds the memory
        some = points[part]
        inside = np.ones((len(some), len(triangles)), dtype=np.bool_)
        for c in range(3):
            x, y = (some[:, None, axis] - triangles[:, c, axis] for axis in (0, 1))
            inside &= sides[:, c, 0] * y - sides[:, c, 1] * x > 0
        to = some[:, None] - triangles[:, 0]
        hidden[part] = (inside & ((to * normal).sum(axis=2) < -close * normal[:, 2])).any(axis=1)
    return hidden
