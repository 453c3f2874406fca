"""Lengths, normals, area and volume of a triangulated surface in R^3."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.kernel import kernel
from isoembed.metric.polyhedral import edge_lengths as edge_lengths


@kernel
def face_normals(faces: Indices, vertices: Floats) -> Floats:
    """Normals of the triangles with twice their areas as norms, (F, 3), by the right-hand rule."""
    normals = np.empty((len(faces), 3))
    for f in range(len(faces)):
        a, b, c = faces[f]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            normals[f, k] = (vertices[b, i] - vertices[a, i]) * (vertices[c, j] - vertices[a, j]) - (
                vertices[b, j] - vertices[a, j]
            ) * (vertices[c, i] - vertices[a, i])
    return normals


@kernel
def face_areas(faces: Indices, vertices: Floats) -> Floats:
    """Areas of the triangles, (F,)."""
    normals = face_normals(faces, vertices)
    areas = np.empty(len(faces))
    for f in range(len(faces)):
        a, b, c = normals[f, 0], normals[f, 1], normals[f, 2]
        areas[f] = np.sqrt(a * a + b * b + c * c) / 2
    return areas


@kernel
def vertex_normals(faces: Indices, vertices: Floats) -> Floats:
    """Unit normals at the vertices, (V, 3): of the triangles, weighted by area; zero where they cancel."""
    sums = np.zeros((len(vertices), 3))
    normals = face_normals(faces, vertices)
    for f in range(len(faces)):
        for corner in range(3):
            for k in range(3):
                sums[faces[f, corner], k] += normals[f, k]
    for v in range(len(vertices)):
        x, y, z = sums[v]
        largest = max(abs(x), abs(y), abs(z))
        if largest > 0:  # the squares of areas would underflow
            x, y, z = x / largest, y / largest, z / largest
            norm = np.sqrt(x * x + y * y + z * z)
            sums[v, 0], sums[v, 1], sums[v, 2] = x / norm, y / norm, z / norm
    return sums


def area(faces: Indices, vertices: Floats) -> float:
    """Area of the surface."""
    return float(face_areas(faces, vertices).sum())


def volume(faces: Indices, vertices: Floats) -> float:
    """Signed enclosed volume, positive where the normals point outward."""
    return float(_boxes(faces, vertices - vertices.mean(axis=0)).sum() / 6)


def outward(faces: Indices, vertices: Floats) -> Floats:
    """Return the vertices, or their mirror image if the volume is negative."""
    return vertices if volume(faces, vertices) >= 0 else vertices * np.array([1.0, 1.0, -1.0])


@kernel
def _boxes(faces: Indices, vertices: Floats) -> Floats:
    """Signed volumes of the parallelepipeds over the triangles from the origin, (F,)."""
    normals = face_normals(faces, vertices)
    boxes = np.empty(len(faces))
    for f in range(len(faces)):
        x = vertices[faces[f, 0]]
        boxes[f] = x[0] * normals[f, 0] + x[1] * normals[f, 1] + x[2] * normals[f, 2]
    return boxes
