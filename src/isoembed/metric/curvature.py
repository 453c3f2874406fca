"""Intrinsic curvature of a polyhedral metric (the paper's appendix): angles, areas, deficits, K."""

from __future__ import annotations

from typing import cast

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.metric.polyhedral import ANGLE_ROUNDING, PolyhedralMetric


def corner_angles(metric: PolyhedralMetric) -> Floats:
    """Interior angles of the triangles.

    Returns
    -------
    ndarray, shape (F, 3)
        Angle at each corner, in radians.
    """
    return metric.triangles.angles


def face_areas(metric: PolyhedralMetric) -> Floats:
    """Areas of the triangles.

    Returns
    -------
    ndarray, shape (F,)
        Areas, in the unit of the lengths squared; infinite beyond the floats.
    """
    triangles = metric.triangles
    with np.errstate(over="ignore"):
        return triangles.areas * triangles.unit * triangles.unit


def area(metric: PolyhedralMetric) -> float:
    """Area of the surface, in the unit of the lengths squared."""
    return metric.area


def deficits(metric: PolyhedralMetric) -> Floats:
    """Angle deficits ``epsilon_a = 2 pi - (sum of the angles at a)``.

    Returns
    -------
    ndarray, shape (V,)
        Deficits in radians; see `PolyhedralMetric.deficits`.
    """
    return metric.deficits.copy()


def negative_deficits(metric: PolyhedralMetric) -> Mask:
    """Vertices with a deficit below -1e-9 radians, shape (V,), where the metric is not convex."""
    return deficits(metric) < -ANGLE_ROUNDING


def dual_areas(metric: PolyhedralMetric) -> Floats:
    """Circumcentric (Voronoi) dual areas ``A*_a``; they sum to the area.

    They are signed: in obtuse triangles a contribution may be negative, which is harmless as long as the sum
    at the vertex is positive.

    Returns
    -------
    ndarray, shape (V,)
        Dual areas, in the unit of the lengths squared; infinite beyond the floats.
    """
    triangles = metric.triangles
    duals = cast(Floats, np.bincount(metric.faces.ravel(), triangles.kites.ravel()))
    with np.errstate(over="ignore"):
        return duals * triangles.unit * triangles.unit


def gaussian_curvature(metric: PolyhedralMetric) -> Floats:
    """Gaussian curvature ``k_a = epsilon_a / A*_a`` (paper, appendix), plus that of the triangles.

    Returns
    -------
    ndarray, shape (V,)
        Curvature, in the unit of the lengths to the power -2; infinite beyond the floats.  Meaningful where
        `dual_areas` is positive.
        NaN on a boundary, where the deficit is the exterior angle of the boundary.
    """
    normalized = metric.normalized
    turned = np.where(metric.triangulation.boundary_vertices, np.nan, deficits(normalized))
    with np.errstate(over="ignore"):
        return metric.curvature + turned / dual_areas(normalized) / metric.unit / metric.unit
