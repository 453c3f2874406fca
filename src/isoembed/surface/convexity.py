"""Concave edges; inverted and partially inverted vertices (paper, section 2.2); depths of dents."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import bends, dihedral_angles
from isoembed.surface.measures import amplitudes, edge_lengths, vertex_normals


def concave_edges(
    triangulation: Triangulation,
    vertices: Floats,
    space: Space = EUCLIDEAN,
    angles: Floats | None = None,
    error: float = 0.0,
) -> Mask:
    """Edges with negative exterior dihedral angle, shape (E,); `angles` are these angles, if known.

    Angles within the effect of an `error` of the vertices do not count.
    """
    return bends(triangulation, vertices, space, angles, error) < 0


def dent_depths(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Depth of the concavity at each edge, shape (E,); 0 at convex edges.

    The concave angle times the lesser height of the two triangles over the edge (the sn of the height):
    rounding turns slivers by any angle, but does not move their corners out of the surface.
    """
    t = triangulation
    angles = np.minimum(dihedral_angles(t, vertices, space), 0.0)
    lengths = space.sn(edge_lengths(t.edges, vertices, space))
    return -angles * amplitudes(t.faces, vertices, space)[t.edge_flanks // 3].min(axis=1) / lengths


def inverted_vertices(triangulation: Triangulation, concave: Mask) -> Mask:
    """Vertices whose edges are all concave, (V,), given the `concave_edges`."""
    return _concave_degrees(triangulation, concave) == triangulation.degrees


def partially_inverted_vertices(triangulation: Triangulation, concave: Mask) -> Mask:
    """Vertices with more than seventy percent of their edges concave, but not all, shape (V,)."""
    count = _concave_degrees(triangulation, concave)
    return (count > 0.7 * triangulation.degrees) & (count < triangulation.degrees)


def umbrella_heights(triangulation: Triangulation, vertices: Floats) -> Floats:
    """Height of each vertex above the mean of its neighbors, along its normal, shape (V,).

    Positive where the surface bulges outward; inverting a vertex changes the sign.
    """
    normals = vertex_normals(triangulation.faces, vertices)
    mean = (triangulation.adjacency @ vertices) / triangulation.degrees[:, None]
    return np.einsum("ij,ij->i", vertices - mean, normals)


def _concave_degrees(triangulation: Triangulation, concave: Mask) -> Indices:
    return np.bincount(triangulation.edges[concave].ravel(), minlength=triangulation.n_vertices)
