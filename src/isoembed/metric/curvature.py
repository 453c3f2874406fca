"""Intrinsic curvature of a polyhedral metric (the paper's appendix): angles, areas, deficits, K.

Corner c of a face lies at ``faces[f, c]``, between half-edges c and c - 1 and across from half-edge c + 1.
The formulas are Kahan's: every difference of lengths is formed before it can cancel, so that needles and
caps keep their relative accuracy ("Miscalculating area and angles of a needle-like triangle", 2014).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.metric.polyhedral import METRIC, PolyhedralMetric


@dataclass(frozen=True)
class Triangles:
    """Shapes of triangles, in a unit near the largest side so that no product over- or underflows.

    Attributes
    ----------
    unit : float
        The power of two below the largest side of all.
    opposite : ndarray, shape (F, 3)
        Length across from each corner.
    excess : ndarray, shape (F, 3)
        Sum of the two sides at each corner minus the side across.
    perimeter : ndarray, shape (F, 1)
    """

    unit: float
    opposite: Floats
    excess: Floats
    perimeter: Floats

    @classmethod
    def of(cls, face_lengths: Floats) -> Triangles:
        """Measure the triangles with these half-edge lengths, shape (F, 3)."""
        unit = 2.0 ** float(np.frexp(face_lengths.max())[1] - 1)  # a power of two: dividing by it is exact
        opposite = np.roll(face_lengths, -1, axis=1) / unit
        order = np.argsort(opposite, axis=1)
        c, b, a = np.take_along_axis(opposite, order, axis=1).T  # a >= b >= c
        sorted_excess = np.column_stack([a + (b - c), c + (a - b), c - (a - b)])
        excess = np.empty_like(opposite)
        np.put_along_axis(excess, order, sorted_excess, axis=1)
        return cls(unit, opposite, excess, (a + (b + c))[:, None])

    @property
    def areas(self) -> Floats:
        """(F,) in units squared."""
        return np.sqrt(self.perimeter[:, 0] * np.prod(self.excess, axis=1)) / 4

    @property
    def angles(self) -> Floats:
        """(F, 3) at each corner, radians."""
        t, s = self.excess, self.perimeter
        return 2 * np.arctan2(
            np.sqrt(np.roll(t, 1, axis=1) * np.roll(t, -1, axis=1)),
            np.sqrt(s * t),
        )

    @property
    def cotangents(self) -> Floats:
        """(F, 3) at each corner."""
        t, s = self.excess, self.perimeter
        return (s * t - np.roll(t, 1, axis=1) * np.roll(t, -1, axis=1)) / (8 * self.areas[:, None])


def corner_angles(metric: PolyhedralMetric) -> Floats:
    """Interior angles of the triangles.

    Returns
    -------
    ndarray, shape (F, 3)
        At each corner, radians.
    """
    return Triangles.of(metric.face_lengths).angles


def face_areas(metric: PolyhedralMetric) -> Floats:
    """Areas of the triangles.

    Returns
    -------
    ndarray, shape (F,)
        In the unit of the lengths, squared.
    """
    triangles = Triangles.of(metric.face_lengths)
    return triangles.areas * triangles.unit * triangles.unit


def area(metric: PolyhedralMetric) -> float:
    """Area of the surface, in the unit of the lengths, squared."""
    return float(face_areas(metric).sum())


def deficits(metric: PolyhedralMetric) -> Floats:
    """Angle deficits ``epsilon_a = 2 pi - (sum of the angles at a)``; they sum to 4 pi (Gauss-Bonnet).

    Returns
    -------
    ndarray, shape (V,)
        Radians.
    """
    angles = corner_angles(metric)
    return 2 * np.pi - cast(Floats, np.bincount(metric.faces.ravel(), angles.ravel()))


def negative_deficits(metric: PolyhedralMetric) -> Mask:
    """Vertices whose deficit is below -1e-9 radians, shape (V,): there the metric is not convex."""
    return deficits(metric) < -METRIC.angles


def dual_areas(metric: PolyhedralMetric) -> Floats:
    """Circumcentric (Voronoi) dual areas ``A*_a``; they sum to the area.

    Signed: beyond an obtuse angle a triangle's share may be negative, which is harmless as long as a
    vertex's sum is positive.

    Returns
    -------
    ndarray, shape (V,)
        In the unit of the lengths, squared.
    """
    triangles = Triangles.of(metric.face_lengths)
    # The kite at corner i: (l_ij^2 cot(k) + l_ik^2 cot(j)) / 8.
    part = triangles.opposite**2 * triangles.cotangents / 8
    kites = np.roll(part, 1, axis=1) + np.roll(part, -1, axis=1)
    return cast(Floats, np.bincount(metric.faces.ravel(), kites.ravel())) * triangles.unit * triangles.unit


def gaussian_curvature(metric: PolyhedralMetric) -> Floats:
    """Gaussian curvature ``k_a = epsilon_a / A*_a`` (paper, appendix).

    Returns
    -------
    ndarray, shape (V,)
        In the unit of the lengths to the power -2.  Meaningful where `dual_areas` is positive.
    """
    normalized = metric.normalized
    return deficits(normalized) / dual_areas(normalized) / metric.unit / metric.unit
