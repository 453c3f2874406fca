"""Dihedral angles, mean curvature H = (k1 + k2) / 2 and bending energy of a triangulated surface.

In relativity, the mean curvature is k = k1 + k2 = 2 H, with twice the `integrated_mean_curvature`.
"""

from functools import reduce
from typing import cast

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.measures import amplitudes, edge_lengths, face_normals, triangle_areas
from isoembed.surface.tangent_frames import sides
from isoembed.surface.triangle_loops import folds
from isoembed.surface.vertex_areas import vertex_areas

TINY = float(np.finfo(np.float64).tiny)


SHUT = 1e-9  # radians: a fold closer to pi has no inside
FLAT_ANGLE = 1e-7  # radians: an edge is concave only below minus this
ROUNDING = 1e-14  # of vertices, relative to the largest coordinate: it rotates slivers


def dihedral_angles(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Exterior dihedral angles: 0 where the surface is flat, positive where it is convex.

    ``theta_e = atan2((n0 x n1) . d, n0 . n1)``, where d is the unit vector along the edge in its left face
    0; in hyperbolic and spherical space, with the directions at one end of the edge.

    Parameters
    ----------
    triangulation : Triangulation
        Oriented with outward normals; with inward normals, all signs change.
    vertices : ndarray, shape (V, 3)
    space : Space, optional

    Returns
    -------
    ndarray, shape (E,)
        Radians, in (-pi, pi].  A closed fold counts as convex, whatever the sign of its rounding error; 0
        beside a face without area, and on a boundary.
    """
    t = triangulation
    if space.is_euclidean:
        sine, cosine = folds(t.edges, t.edge_flanks, face_normals(t.faces, vertices), vertices)
    else:
        sine, cosine = _curved_folds(t, vertices, space)
    return np.arctan2(sine, cosine)


def bends(
    triangulation: Triangulation,
    vertices: Floats,
    space: Space = EUCLIDEAN,
    angles: Floats | None = None,
    error: float = 0.0,
) -> Floats:
    """Dihedral angles, shape (E,), set to 0 within the effect of rounding or an `error` of the vertices."""
    if angles is None:
        angles = dihedral_angles(triangulation, vertices, space)
    errors = bend_errors(triangulation, vertices, space, error)
    return np.where(np.abs(angles) > FLAT_ANGLE + errors, angles, 0.0)


def bend_errors(
    triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN, error: float = 0.0
) -> Floats:
    """Bounds on the errors of the dihedral angles, shape (E,), radians.

    They cover rounding of the vertices and, if given, an `error` of each vertex in any direction.
    """
    t = triangulation
    turned = turning_errors(t, vertices, space)
    errors = reduce(np.maximum, (turned[faces] for faces in t.edge_flanks.T // 3))
    if error == 0:
        return errors
    return np.maximum(errors, np.minimum(error * bend_rates(t, vertices, error / np.pi), np.pi))


def bend_rates(triangulation: Triangulation, vertices: Floats, lowest: float) -> Floats:
    """Largest changes of the dihedral angles, (E,), by unit displacements of the vertices, to first order.

    A dihedral angle depends on four vertices: on the third corner of each triangle with the factor 1/h,
    where h is its height over the edge, at least `lowest`, and on the ends of the edge with the factors s/h
    and (1 - s)/h, where the foot of the height divides the edge in the ratio s to 1 - s.
    """
    t, halfedges = triangulation, triangulation.edge_flanks
    across = vertices[t.faces.ravel()[halfedges - halfedges % 3 + (halfedges + 2) % 3]]
    start, along = vertices[t.edges[:, 0]], np.diff(vertices[t.edges], axis=1)[:, 0]
    squares = np.maximum(np.einsum("ij,ij->i", along, along), TINY)[:, None]
    share = np.einsum("ekj,ej->ek", across - start[:, None], along) / squares
    feet = start[:, None] + share[:, :, None] * along[:, None]
    heights = np.maximum(np.linalg.norm(across - feet, axis=2), lowest)
    factors = (1 + np.abs(share) + np.abs(1 - share)) / heights
    return cast(Floats, factors.sum(axis=1))


def turning_errors(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Bounds on the rotation of each triangle by rounding of the vertices, in radians, shape (F,)."""
    t = triangulation
    lengths = edge_lengths(t.edges, vertices, space)
    longest = space.sn(reduce(np.maximum, (lengths[edges] for edges in t.face_edges.T)))
    error = ROUNDING * float(np.abs(vertices).max()) * longest
    if not space.is_euclidean:  # far from the origin of the sphere, small changes of x are long distances
        error /= min(1.0, float(space.heights(vertices).min()))
    return error / np.maximum(amplitudes(t.faces, vertices, space), np.maximum(error / np.pi, TINY))


def _curved_folds(t: Triangulation, vertices: Floats, space: Space) -> tuple[Floats, Floats]:
    """Sines and cosines as of `folds`, from the directions of triangle sides at one end of each edge."""
    halfedges = t.edge_halfedges
    across = t.faces.ravel()[halfedges - halfedges % 3 + (halfedges + 2) % 3]  # third corners
    a, b, left, right = vertices[np.column_stack([t.edges, across]).T]
    along = sides(space, a, b)
    n, m = np.cross(along, sides(space, a, left)), np.cross(sides(space, a, right), along)
    units = along / np.maximum(np.linalg.norm(along, axis=1), TINY)[:, None]
    sine, cosine = np.einsum("ij,ij->i", np.cross(n, m), units), np.einsum("ij,ij->i", n, m)
    return np.where((cosine < 0) & (np.abs(sine) < SHUT), np.abs(sine), sine), cosine


def edge_mean_curvature(
    triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN, angles: Floats | None = None
) -> Floats:
    """Integral of H over each edge, ``l_e theta_e / 2``, shape (E,), in the unit of length.

    Here and below, `angles` are the `dihedral_angles`, (E,), if known.
    """
    if angles is None:
        angles = dihedral_angles(triangulation, vertices, space)
    return edge_lengths(triangulation.edges, vertices, space) * angles / 2


def integrated_mean_curvature(
    triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN, angles: Floats | None = None
) -> float:
    """Integral of H over the surface, ``1/2 sum l_e theta_e`` (unit sphere 4 pi, unit cube 3 pi)."""
    return float(edge_mean_curvature(triangulation, vertices, space, angles).sum())


def vertex_mean_curvature(
    triangulation: Triangulation,
    vertices: Floats,
    areas: Floats | None = None,
    space: Space = EUCLIDEAN,
    angles: Floats | None = None,
) -> Floats:
    """Mean curvature H at the vertices.

    Half of each edge's integral goes to each end.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    areas : ndarray, shape (V,), optional
        Vertex areas; by default circumcentric dual areas, clipped to between a tenth and ten times a third
        of the area of the triangles around.
    space : Space, optional
    angles : ndarray, shape (E,), optional
        The `dihedral_angles`.

    Returns
    -------
    ndarray, shape (V,)
        H, in the inverse unit of length; NaN where the triangles around have no area.
    """
    shares = vertex_areas(triangulation, vertices, space) if areas is None else areas
    return _vertex_integrals(triangulation, vertices, space, angles) / np.where(shares == 0, np.nan, shares)


def bending_energy(
    triangulation: Triangulation,
    vertices: Floats,
    areas: Floats | None = None,
    space: Space = EUCLIDEAN,
    angles: Floats | None = None,
) -> float:
    """Willmore energy, the integral of H^2 + k with the curvature k of space: 4 pi for spheres, else more.

    The sum of the squared `vertex_mean_curvature` times the vertex areas.  It is scale invariant, and
    second-order accurate in the edge length on good triangulations of smooth surfaces; for vertices placed at
    random it is a few percent too large.  Near an edge of a polyhedron it grows as the triangles shrink.
    """
    integrals = _vertex_integrals(triangulation, vertices, space, angles)
    shares = vertex_areas(triangulation, vertices, space) if areas is None else areas
    flat = shares == 0  # dihedral angles beside faces without area are 0
    energy = float(np.sum(integrals**2 / np.where(flat, 1.0, shares)))
    if space.is_euclidean:
        return energy
    return energy + space.curvature * float(triangle_areas(triangulation.faces, vertices, space).sum())


def _vertex_integrals(
    triangulation: Triangulation, vertices: Floats, space: Space, angles: Floats | None
) -> Floats:
    """The vertices' shares of the integral of H, shape (V,)."""
    half = np.repeat(edge_mean_curvature(triangulation, vertices, space, angles) / 2, 2)
    return cast(Floats, np.bincount(triangulation.edges.ravel(), half))


def face_mean_curvature(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Mean curvature H of the triangles: half of each edge's integral goes to each side.

    Returns
    -------
    ndarray, shape (F,)
        H, in the inverse unit of length.
    """
    half = edge_mean_curvature(triangulation, vertices, space) / 2
    return half[triangulation.face_edges].sum(axis=1) / triangle_areas(triangulation.faces, vertices, space)
