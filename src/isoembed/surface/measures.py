"""Lengths, normals, area and volume of a triangulated surface."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.kernel import kernel
from isoembed.metric.distances import straight_lengths
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.space.trigonometry import triangle_area
from isoembed.surface.cone_volumes import cone_volumes
from isoembed.surface.tangent_frames import sides


def edge_lengths(edges: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Distances between the ends of the edges, (E,)."""
    if space.is_euclidean:
        return straight_lengths(edges, vertices)
    a, b = edges.T
    return space.distances(vertices[a], vertices[b])


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


def triangle_areas(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Areas of the triangles, (F,), in any space."""
    if space.is_euclidean:
        return face_areas(faces, vertices)
    corners = [vertices[faces[:, c]] for c in range(3)]
    lengths = np.column_stack([space.distances(corners[c], corners[c - 1]) for c in range(3)])
    return _curved_areas(lengths, space.curvature)


@kernel
def _curved_areas(face_lengths: Floats, k: float) -> Floats:
    found = np.empty(len(face_lengths))
    for f in range(len(face_lengths)):
        found[f] = triangle_area(face_lengths[f, 0], face_lengths[f, 1], face_lengths[f, 2], k)
    return found


def amplitudes(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """``sn b sn c sin A`` of the triangles, (F,): in Euclidean space twice their areas."""
    if space.is_euclidean:
        return 2 * face_areas(faces, vertices)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.linalg.norm(np.cross(sides(space, a, b), sides(space, a, c)), axis=1)


def area(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> float:
    """Area of the surface."""
    return float(triangle_areas(faces, vertices, space).sum())


def volume(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> float:
    """Signed enclosed volume, positive where the normals point outward."""
    if not space.is_euclidean:
        return float(cone_volumes(faces, vertices, space).sum())
    return float(_boxes(faces, vertices - vertices.mean(axis=0)).sum() / 6)


def outward(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Return the vertices, or their mirror image if the volume is negative.

    It has the sign of the volume in projective coordinates.
    """
    straight = to_model(space, vertices, "projective") if not space.is_euclidean else vertices
    return vertices if volume(faces, straight) >= 0 else vertices * np.array([1.0, 1.0, -1.0])


@kernel
def _boxes(faces: Indices, vertices: Floats) -> Floats:
    """Signed volumes of the parallelepipeds over the triangles from the origin, (F,)."""
    normals = face_normals(faces, vertices)
    boxes = np.empty(len(faces))
    for f in range(len(faces)):
        x = vertices[faces[f, 0]]
        boxes[f] = x[0] * normals[f, 0] + x[1] * normals[f, 1] + x[2] * normals[f, 2]
    return boxes
