"""Shapes of triangles in spaces of constant curvature: angles, areas and circumcenters from the sides.

Corner c of a face is at ``faces[f, c]``, between half-edges c and c - 1 and opposite to half-edge c + 1.
The formulas are Kahan's: differences of lengths are computed without cancellation, so that needles and caps
keep their relative accuracy ("Miscalculating area and angles of a needle-like triangle", 2014).  On the
sphere and in the hyperbolic plane they are the half-angle formulas: each sum and difference of sides is
replaced by its chord, ``2 sn(x / 2)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from isoembed.arrays import Floats
from isoembed.space import Space


@dataclass(frozen=True)
class Triangles:
    """Shapes of triangles, in a unit close to the largest side to avoid over- and underflow.

    Attributes
    ----------
    unit : float
        Power of two below the largest side of all.
    space : Space
        Space with the curvature of the triangles, in this unit.
    opposite : ndarray, shape (F, 3)
        Length of the side opposite to each corner.
    excess : ndarray, shape (F, 3)
        Sum of the two sides at each corner minus the opposite side, as a chord.
    perimeter : ndarray, shape (F, 1)
        Perimeter, as a chord.
    """

    unit: float
    space: Space
    opposite: Floats
    excess: Floats
    perimeter: Floats

    @classmethod
    def of(cls, face_lengths: Floats, curvature: float = 0.0) -> Triangles:
        """Measure triangles with these half-edge lengths, shape (F, 3), and this curvature."""
        unit = 2.0 ** float(np.frexp(face_lengths.max())[1] - 1)  # a power of two: dividing by it is exact
        space = Space(curvature * unit * unit)
        z, x, y = (face_lengths / unit).T.copy()  # opposite to the last corner, the first and the second
        low, high = np.minimum(x, y), np.maximum(x, y)
        a, b, c = np.maximum(high, z), np.maximum(low, np.minimum(high, z)), np.minimum(low, z)  # a >= b >= c
        at_c, at_b, at_a = a + (b - c), c + (a - b), c - (a - b)
        opposite, excess = np.empty((2, *face_lengths.shape))
        for corner, side in enumerate((x, y, z)):
            opposite[:, corner] = side
            excess[:, corner] = np.where(side == c, at_c, np.where(side == b, at_b, at_a))
        perimeter = (a + (b + c))[:, None]
        if not space.is_euclidean:
            excess, perimeter = space.chord(excess), space.chord(perimeter)
        return cls(unit, space, opposite, excess, perimeter)

    @property
    def sines(self) -> Floats:
        """Values `Space.sn` of the side opposite to each corner (its length in the plane), shape (F, 3)."""
        return self.space.sn(self.opposite)

    @property
    def amplitudes(self) -> Floats:
        """Sines of two sides times that of their angle (in the plane, twice the area), shape (F,)."""
        return np.sqrt(self.perimeter[:, 0] * reduce(np.multiply, self.excess.T)) / 2

    @property
    def areas(self) -> Floats:
        """Areas, in units squared, shape (F,)."""
        if self.space.is_euclidean:
            return self.amplitudes / 2
        # Formula for the solid angle of three unit vectors, and its analog on the hyperboloid.
        k, cosines = self.space.curvature, self.space.cs(self.opposite).sum(axis=1)
        return 2 * np.arctan2(k * self.amplitudes, 1 + cosines) / k

    @property
    def angles(self) -> Floats:
        """Angles at each corner in radians, shape (F, 3)."""
        t, s = self.excess, self.perimeter
        return 2 * np.arctan2(
            np.sqrt(np.roll(t, 1, axis=1) * np.roll(t, -1, axis=1)),
            np.sqrt(s * t),
        )

    @property
    def cotangents(self) -> Floats:
        """Cotangents of the angles at each corner, shape (F, 3)."""
        t, s = self.excess, self.perimeter
        return (s * t - np.roll(t, 1, axis=1) * np.roll(t, -1, axis=1)) / (4 * self.amplitudes[:, None])

    @property
    def tilts(self) -> Floats:
        """Tangents of the angles from the side opposite to each corner to the circumcenter, shape (F, 3).

        The angles are at the ends of the side, and negative if the circumcenter is beyond it: ``tan((B + C -
        A) / 2)`` at the corner A, which in the plane is the cotangent of A.
        """
        if self.space.is_euclidean:
            return self.cotangents
        versine = self.space.versine(self.opposite)
        product = np.roll(versine, 1, axis=1) * np.roll(versine, -1, axis=1)
        return self.cotangents + self.space.curvature * product / self.amplitudes[:, None]

    @property
    def kites(self) -> Floats:
        """Signed areas between each corner, midpoints of its two sides and circumcenter, shape (F, 3).

        They are in units squared and sum to the area.  A hyperbolic triangle without circumcenter is divided
        into thirds.
        """
        space, tilts = self.space, self.tilts
        if space.is_euclidean:
            part = self.opposite**2 * tilts / 8
            return np.roll(part, 1, axis=1) + np.roll(part, -1, axis=1)
        k, height = space.curvature, space.sn(self.opposite / 2) * tilts
        there = (1 + k * height * height > 0).all(axis=1, keepdims=True)
        half = height / (1 + np.sqrt(np.where(there, 1 + k * height * height, 1.0)))
        quarter = space.sn(self.opposite / 4) / space.cs(self.opposite / 4)
        part = 2 * np.arctan(k * quarter * half) / k
        kites = np.roll(part, 1, axis=1) + np.roll(part, -1, axis=1)
        return np.where(there, kites, self.areas[:, None] / 3)
