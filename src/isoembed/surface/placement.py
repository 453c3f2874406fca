"""Standard position of surfaces by their principal axes, and orientation by volume or by int H dA."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import edge_mean_curvature
from isoembed.surface.measures import face_areas, face_normals, outward
from isoembed.surface.principal_axes import SAME, points_backward, principal_axes


def standard_position(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Move a closed surface to a position determined by its shape and the numbering of its vertices.

    Its triangles become counterclockwise as seen from outside.  The centroid of its area, in curved space the
    center of its vertices, is moved to the origin, and its principal axes to the coordinate axes, longest
    first.  Rounding errors of the vertices are amplified at most by the order of 1 / `principal_axes.EQUAL`,
    even if moments are equal by symmetry.

    Parameters
    ----------
    faces : ndarray of int, shape (F, 3)
    vertices : ndarray, shape (V, 3)
        Ambient coordinates in hyperbolic and spherical space.
    space : Space
    """
    return _on_principal_axes(faces, outward(faces, vertices, space), space)


def standard_sheet(triangulation: Triangulation, vertices: Floats) -> Floats:
    """Move a surface in R^3, (V, 3), with or without boundary, to its standard position.

    Closed surfaces are moved by `standard_position`.  Triangles of surfaces with boundary are, on average,
    counterclockwise seen from above, and the mirror image with positive int H dA is chosen: it bulges upward.
    """
    t = triangulation
    if t.is_closed:
        return standard_position(t.faces, vertices)
    x = _on_principal_axes(t.faces, vertices)
    upward = face_normals(t.faces, x)[:, 2]
    if upward.sum() < -SAME * np.abs(upward).sum():
        x = x * [1.0, -1.0, -1.0]
    bends = edge_mean_curvature(t, x)
    is_balanced = abs(bends.sum()) <= SAME * np.abs(bends).sum()
    if points_backward(x[:, 2]) if is_balanced else bends.sum() < 0:
        x = x * [1.0, 1.0, -1.0]
    return x


def turned_about_vertical(vertices: Floats, boundary: Indices) -> Floats:
    """Move a surface, (V, 3), horizontally: mean of the boundary to the z axis, longest axis to x."""
    middle = vertices[boundary].mean(axis=0) * [1.0, 1.0, 0.0]
    across = (vertices - middle) * [1.0, 1.0, 0.0]
    a, b, _ = principal_axes(across, across.T @ across)[:, 0]
    return (vertices - middle) @ np.array([[a, -b, 0.0], [b, a, 0.0], [0.0, 0.0, 1.0]])


def _on_principal_axes(faces: Indices, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    if not space.is_euclidean:
        center = space.center(vertices)
        heights = space.heights(vertices) * space.heights(center) + space.curvature * (vertices @ center)
        # On the sphere, bodies wider than a quarter of a great circle may leave the hemisphere of the origin.
        points = space.translated(vertices, -center) if (heights > 0).all() else vertices
        return points @ principal_axes(points, points.T @ points)
    points = vertices - vertices.mean(axis=0)
    areas = face_areas(faces, points)
    areas /= areas.sum()
    sums = points[faces].sum(axis=1)
    centroid = areas @ sums / 3.0
    points -= centroid
    sums -= 3.0 * centroid
    # The integral of x x^T over a triangle is its area over 12 times sum_i x_i x_i^T + s s^T, s = sum_i x_i.
    shares = np.bincount(faces.ravel(), np.repeat(areas, 3), minlength=len(points))
    moments = (points.T * shares) @ points + (sums.T * areas) @ sums
    return points @ principal_axes(points, moments)
