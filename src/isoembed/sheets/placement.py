"""Standard position of surfaces with boundary or handles."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.curvature import edge_mean_curvature
from isoembed.surface.measures import face_normals
from isoembed.surface.principal_axes import SAME, points_backward, principal_axes, standard_position


def standard_sheet(triangulation: Triangulation, vertices: Floats) -> Floats:
    """Move a surface, (V, 3), to a place that its shape and the numbers of its vertices determine.

    Area and principal axes are as in `standard_position`.  Triangles of surfaces with boundary are
    counterclockwise seen from above, on the average, and of mirror images it is the one with positive int H
    dA: they bulge upward.
    """
    t = triangulation
    x = standard_position(t.faces, vertices)
    if t.is_closed:
        return x
    upward = face_normals(t.faces, x)[:, 2]
    if upward.sum() < -SAME * np.abs(upward).sum():
        x = x * [1.0, -1.0, -1.0]
    bends = edge_mean_curvature(t, x)
    is_balanced = abs(bends.sum()) <= SAME * np.abs(bends).sum()
    if points_backward(x[:, 2]) if is_balanced else bends.sum() < 0:
        x = x * [1.0, 1.0, -1.0]
    return x


def turned_about_vertical(vertices: Floats, boundary: Indices) -> Floats:
    """Move a surface, (V, 3), horizontally: the boundary's mean to the z axis, the longest axis to x."""
    middle = vertices[boundary].mean(axis=0) * [1.0, 1.0, 0.0]
    across = (vertices - middle) * [1.0, 1.0, 0.0]
    a, b, _ = principal_axes(across, across.T @ across)[:, 0]
    return (vertices - middle) @ np.array([[a, -b, 0.0], [b, a, 0.0], [0.0, 0.0, 1.0]])
