"""Edge lengths, normals, area and volume; outward orientation: the mirror image of positive volume."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.metric.distances import straight_lengths
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface.cone_volumes import cone_volumes
from isoembed.surface.tangent_frames import sides
from isoembed.surface.triangle_loops import boxes_of, curved_areas
from isoembed.surface.triangle_loops import face_areas as face_areas
from isoembed.surface.triangle_loops import face_normals as face_normals
from isoembed.surface.triangle_loops import vertex_normals as vertex_normals


def edge_lengths(edges: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Distances between the ends of the edges, (E,)."""
    if space.is_euclidean:
        return straight_lengths(edges, vertices)
    a, b = edges.T
    return space.distances(vertices[a], vertices[b])


def triangle_areas(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Areas of the triangles, (F,), in any space."""
    if space.is_euclidean:
        return face_areas(faces, vertices)
    corners = [vertices[faces[:, c]] for c in range(3)]
    lengths = np.column_stack([space.distances(corners[c], corners[c - 1]) for c in range(3)])
    return curved_areas(lengths, space.curvature)


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
    return float(boxes_of(faces, vertices - vertices.mean(axis=0)).sum() / 6)


def outward(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Return the vertices, or their mirror image if the volume is negative.

    It has the sign of the volume in projective coordinates.
    """
    straight = to_model(space, vertices, "projective") if not space.is_euclidean else vertices
    return vertices if volume(faces, straight) >= 0 else vertices * np.array([1.0, 1.0, -1.0])
