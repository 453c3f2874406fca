"""Area and volume of a triangulated surface in R^3."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def edge_lengths(edges: Indices, vertices: Floats) -> Floats:
    """Lengths of the edges, (E,)."""
    a, b = edges.T
    return np.linalg.norm(vertices[a] - vertices[b], axis=1)


def face_normals(faces: Indices, vertices: Floats) -> Floats:
    """Normals of the triangles with twice their areas as norms, (F, 3), by the right-hand rule."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def face_areas(faces: Indices, vertices: Floats) -> Floats:
    """Areas of the triangles, (F,)."""
    return np.linalg.norm(face_normals(faces, vertices), axis=1) / 2


def vertex_normals(faces: Indices, vertices: Floats) -> Floats:
    """Unit normals at the vertices, (V, 3): of the triangles, weighted by area; zero where they cancel."""
    corners = faces.ravel()
    normals = face_normals(faces, vertices)
    sums = np.column_stack(
        [np.bincount(corners, np.repeat(normals[:, k], 3), minlength=len(vertices)) for k in range(3)]
    )
    largest = np.abs(sums).max(axis=1, keepdims=True)
    scaled = sums / np.where(largest > 0, largest, 1.0)  # the squares of areas would underflow
    return scaled / np.maximum(np.linalg.norm(scaled, axis=1, keepdims=True), 1.0)


def area(faces: Indices, vertices: Floats) -> float:
    """Area of the surface."""
    return float(face_areas(faces, vertices).sum())


def volume(faces: Indices, vertices: Floats) -> float:
    """Signed enclosed volume, positive where the normals point outward."""
    centered = vertices - vertices.mean(axis=0)
    normals = face_normals(faces, centered)
    return float(np.einsum("ij,ij->", centered[faces[:, 0]], normals) / 6)


def outward(faces: Indices, vertices: Floats) -> Floats:
    """Return the vertices, or their mirror image if the volume is negative."""
    return vertices if volume(faces, vertices) >= 0 else vertices * np.array([1.0, 1.0, -1.0])
