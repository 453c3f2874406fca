"""Where the viewer stands: a surface in its principal axes, seen a little from above, and its light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.surface.embedding import Embedding
from isoembed.surface.measures import face_normals

Floats = NDArray[np.float64]

AZIMUTH, ELEVATION = np.radians(24.0), np.radians(20.0)
LIGHT = np.array([-0.5, 0.8, 0.8])  # right, up, toward the viewer
AMBIENT, DIFFUSE, GLOSS, SHARPNESS = 0.66, 0.42, 0.14, 20


@dataclass(frozen=True)
class View:
    """The visible triangles of a surface in orthographic projection, farthest first.

    Attributes
    ----------
    polygons : ndarray, shape (n, 3, 2)
        Right and up, in the unit of the surface's half diameter.
    faces : ndarray of int, shape (n,)
        Which triangles they are.
    light : ndarray, shape (n,)
        Diffuse light on them, 0 to about 1.
    gloss : ndarray, shape (n,)
        Reflected light, 0 to 1.
    """

    polygons: Floats
    faces: NDArray[np.int64]
    light: Floats
    gloss: Floats

    @classmethod
    def of(cls, embedding: Embedding) -> View:
        """Look at a surface: its longest axis lies across the picture, its shortest one points up."""
        points = _principal(embedding.vertices) @ _camera().T
        normals = face_normals(embedding.faces, points)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        front = np.flatnonzero(normals[:, 2] > 0)  # of a closed surface the other side is never seen
        corners = points[embedding.faces[front]]
        order = np.argsort(corners[:, :, 2].mean(axis=1))
        front, corners = front[order], corners[order]
        toward = LIGHT / np.linalg.norm(LIGHT)
        halfway = toward + np.array([0.0, 0.0, 1.0])
        halfway /= np.linalg.norm(halfway)
        light = np.maximum(normals[front] @ toward, 0.0)
        gloss = np.maximum(normals[front] @ halfway, 0.0) ** SHARPNESS
        return cls(corners[:, :, :2], front, light, gloss)

    def shade(self, colors: Floats) -> Floats:
        """Return the colors (n, 3) of the visible triangles under this light."""
        lit = colors * (AMBIENT + DIFFUSE * self.light)[:, None]
        return np.clip(lit + GLOSS * self.gloss[:, None], 0.0, 1.0)


def _principal(vertices: Floats) -> Floats:
    """The vertices in their principal axes, longest first, scaled to half diameter 1."""
    centered = vertices - vertices.mean(axis=0)
    centered /= np.abs(centered).max()
    _, axes = np.linalg.eigh(centered.T @ centered)
    axes = axes[:, ::-1]
    # Eigenvectors have no sign: the heavier tail points along the axis, so that a picture can be made again.
    axes = axes * np.where((np.asarray(centered @ axes) ** 3).sum(axis=0) < 0, -1.0, 1.0)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    turned = centered @ axes
    return turned / np.linalg.norm(turned, axis=1).max()


def _camera() -> Floats:
    """Rotation from (long, middle, short) axes to right, up and toward the viewer."""
    (ca, sa), (ce, se) = ((np.cos(x), np.sin(x)) for x in (AZIMUTH, ELEVATION))
    right, toward = np.array([ca, sa, 0.0]), np.array([sa * ce, -ca * ce, se])
    return np.array([right, np.cross(toward, right), toward])
