"""Camera, pose by principal axes, visibility and lighting of a surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.io.format import Polygons, flattened
from isoembed.mesh.polygons import polygon_normals
from isoembed.surface.principal_axes import SAME, principal_axes

AZIMUTH, ELEVATION = np.radians(24.0), np.radians(20.0)
LIGHT = np.array([-0.5, 0.8, 0.8])  # right, up, toward the viewer


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of a surface: principal axes, longest first, and half diameter.

    Attributes
    ----------
    center : ndarray, shape (3,)
    axes : ndarray, shape (3, 3)
        Columns, right-handed.
    size : float
        Half diameter, in the unit of the vertices.
    """

    center: Floats
    axes: Floats
    size: float

    @classmethod
    def of(cls, vertices: Floats, faces: Polygons | None = None) -> Pose:
        """Pose by the principal axes of a surface; the outer side of a surface with boundary faces up."""
        center = vertices.mean(axis=0)
        centered = vertices - center
        largest = float(np.abs(centered).max()) or 1.0  # all vertices may coincide
        centered /= largest
        axes = principal_axes(centered, centered.T @ centered)
        if faces is not None and (_area_vector(centered, faces) @ axes[:, 2]) < -SAME:
            axes[:, 1:] *= -1.0
        return cls(center, axes, largest * float(np.linalg.norm(centered, axis=1).max()) or 1.0)

    def put(self, vertices: Floats) -> Floats:
        """Vertices, (V, 3), in coordinates along the long, middle and short axis."""
        return (vertices - self.center) / self.size @ self.axes


def _area_vector(points: Floats, faces: Polygons) -> Floats:
    """Vector area divided by the area; 0 without a boundary."""
    corners, sizes = flattened(faces)
    normals = polygon_normals(points[corners], sizes)
    total = np.linalg.norm(normals, axis=1).sum()
    return normals.sum(axis=0) / total if total > 0 else np.zeros(3)


def _has_boundary(corners: Indices, sizes: Indices) -> bool:
    """Whether flattened polygons have an edge in only one of them."""
    ends = np.cumsum(sizes)
    after = np.arange(1, len(corners) + 1)
    after[ends - 1] = ends - sizes
    a, b, n = corners, corners[after], int(corners.max(initial=0)) + 1
    return not np.array_equal(np.sort(a * n + b), np.sort(b * n + a))


@dataclass(frozen=True)
class View:
    """Visible faces of a surface in orthographic projection, farthest first.

    For a closed surface these are the faces turned toward the viewer, for one with boundary all faces.

    Attributes
    ----------
    polygons : sequence of ndarray, shape (m, 2)
        Right and up coordinates, in half diameters of the surface.
    faces : ndarray of int, shape (n,)
        Indices of the visible faces.
    light : ndarray, shape (n,)
        Diffuse light, 0 to about 1.
    gloss : ndarray, shape (n,)
        Specular light, 0 to 1.
    inside : ndarray of bool, shape (n,)
        Mask of faces seen from inside.
    pose : Pose
        Pose of the surface.
    camera : ndarray, shape (3, 3)
        Rotation from the pose's axes to right, up and toward the viewer.
    """

    polygons: Floats | Sequence[Floats]
    faces: Indices
    light: Floats
    gloss: Floats
    inside: Mask
    pose: Pose
    camera: Floats

    @classmethod
    def of(cls, vertices: Floats, faces: Polygons, pose: Pose | None = None, turn: float = 0.0) -> View:
        """View of a surface: its longest axis lies across the picture, its shortest one points up.

        Parameters
        ----------
        vertices : ndarray, shape (V, 3)
        faces : ndarray of int, shape (F, 3), or sequence of such arrays of any lengths
            Vertices around each face, counterclockwise seen from outside.
        pose : Pose, optional
            Pose of the surface; by default by its principal axes.
        turn : float
            Rotation of the viewer about the shortest axis, in radians.
        """
        pose, turned = pose or Pose.of(vertices, faces), camera(turn)
        points = pose.put(vertices) @ turned.T
        corners, sizes = flattened(faces)
        ends = np.cumsum(sizes)
        normals = polygon_normals(points[corners], sizes)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        inside = normals[:, 2] < 0
        if _has_boundary(corners, sizes):
            normals[inside] *= -1.0
        front = np.flatnonzero(normals[:, 2] > 0)
        depths = np.add.reduceat(points[corners, 2], ends - sizes) / sizes
        front = front[np.argsort(depths[front])]
        toward = LIGHT / np.linalg.norm(LIGHT)
        halfway = toward + np.array([0.0, 0.0, 1.0])
        halfway /= np.linalg.norm(halfway)
        light = np.maximum(normals[front] @ toward, 0.0)
        gloss = np.maximum(normals[front] @ halfway, 0.0) ** 20
        visible = faces[front] if isinstance(faces, np.ndarray) else [faces[f] for f in front.tolist()]
        flat = points[:, :2]
        polygons = flat[visible] if isinstance(visible, np.ndarray) else [flat[face] for face in visible]
        return cls(polygons, front, light, gloss, inside[front], pose, turned)

    @property
    def extent(self) -> tuple[Floats, Floats]:
        """Lower left and upper right corner of the visible faces; a default extent if there are none."""
        points = np.concatenate([*self.polygons] or [np.array([[-1.0, -1.0], [1.0, 1.0]])])
        return points.min(axis=0), points.max(axis=0)

    def put(self, points: Floats) -> Floats:
        """Coordinates (right, up) in the view of points (..., 3) of the surface."""
        return self.pose.put(points) @ self.camera[:2].T

    def shade(self, colors: Floats) -> Floats:
        """Shaded colors (n, 3) of the visible faces."""
        # Ambient and diffuse light outside, less inside, and reflections.
        lit = colors * np.where(self.inside, 0.4, 0.66 + 0.42 * self.light)[:, None]
        return np.clip(lit + 0.14 * self.gloss[:, None], 0.0, 1.0)


def camera(turn: float = 0.0) -> Floats:
    """Rotation from the (long, middle, short) axes to right, up and toward the viewer, for a given turn."""
    (ca, sa), (ce, se) = ((np.cos(x), np.sin(x)) for x in (AZIMUTH + turn, ELEVATION))
    right, toward = np.array([ca, sa, 0.0]), np.array([sa * ce, -ca * ce, se])
    return np.array([right, np.cross(toward, right), toward])
