"""Edge lengths, normals, area and volume; outward orientation: the mirror image with positive volume."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.distances import straight_lengths
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface.cone_volumes import cone_volumes
from isoembed.surface.tangent_frames import sides
from isoembed.surface.triangle_loops import boxes_of, curved_areas
from isoembed.surface.triangle_loops import face_areas as face_areas
from isoembed.surface.triangle_loops import face_normals as face_normals
from isoembed.surface.triangle_loops import vertex_normals as vertex_normals

COPLANAR = 1e-9  # in mean edge lengths: boundaries of caps in files


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
    return cone_sum(faces, vertices - vertices.mean(axis=0))


def above_boundary(triangulation: Triangulation, vertices: Floats, error: float = COPLANAR) -> Floats | None:
    """Vertices relative to a point in the horizontal plane of the boundary, (V, 3); None if there is none.

    Their `cone_sum` is the volume between surface and plane, as the plane does not contribute.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    error : float, optional
        Tolerance of the boundary heights, in mean edge lengths.
    """
    t = triangulation
    heights = vertices[t.boundary_vertices, 2]
    if not len(heights) or np.ptp(heights) > error * edge_lengths(t.edges, vertices).mean():
        return None
    return vertices - [*vertices[:, :2].mean(axis=0), heights.mean()]


def cone_sum(faces: Indices, vertices: Floats) -> float:
    """Signed volume of the cones from the origin over the triangles."""
    return float(boxes_of(faces, vertices).sum() / 6)


def outward(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Return the vertices, or their mirror image if the volume is negative.

    The volume has the same sign in projective coordinates, where it is computed.
    """
    straight = to_model(space, vertices, "projective") if not space.is_euclidean else vertices
    return vertices if volume(faces, straight) >= 0 else vertices * np.array([1.0, 1.0, -1.0])
