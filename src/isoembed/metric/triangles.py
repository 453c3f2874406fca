"""Shapes of triangles in spaces of constant curvature: angles, areas and circumcenters from the sides.

Corner c of a face lies at ``faces[f, c]``, between half-edges c and c - 1 and across from half-edge c + 1.
The formulas are Kahan's: every difference of lengths is formed before it can cancel, so that needles and
caps keep their relative accuracy ("Miscalculating area and angles of a needle-like triangle", 2014).  On the
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
    """Shapes of triangles, in a unit near the largest side so that no product over- or underflows.

    Attributes
    ----------
    unit : float
        The power of two below the largest side of all.
    space : Space
        Of the curvature of the triangles, in this unit.
    opposite : ndarray, shape (F, 3)
        Length across from each corner.
    excess : ndarray, shape (F, 3)
        Sum of the two sides at each corner minus the side across, as a chord.
    perimeter : ndarray, shape (F, 1)
        As a chord.
    """

    unit: float
    space: Space
    opposite: Floats
    excess: Floats
    perimeter: Floats

    @classmethod
    def of(cls, face_lengths: Floats, curvature: float = 0.0) -> Triangles:
        """Measure the triangles of this curvature with these half-edge lengths, shape (F, 3)."""
        unit = 2.0 ** float(np.frexp(face_lengths.max())[1] - 1)  # a power of two: dividing by it is exact
        space = Space(curvature * unit * unit)
        z, x, y = (face_lengths / unit).T.copy()  # across from the last corner, the first and the second
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
        """(F, 3): `Space.sn` of the side across from each corner; its length in the plane."""
        return self.space.sn(self.opposite)

    @property
    def amplitudes(self) -> Floats:
        """(F,): the sines of two sides times that of the angle between; twice the area in the plane."""
        return np.sqrt(self.perimeter[:, 0] * reduce(np.multiply, self.excess.T)) / 2

    @property
    def areas(self) -> Floats:
        """(F,) in units squared."""
        if self.space.is_euclidean:
            return self.amplitudes / 2
        # Of the solid angle at the center, of three unit vectors, and its like on the hyperboloid.
        k, cosines = self.space.curvature, self.space.cs(self.opposite).sum(axis=1)
        return 2 * np.arctan2(k * self.amplitudes, 1 + cosines) / k

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
        return (s * t - np.roll(t, 1, axis=1) * np.roll(t, -1, axis=1)) / (4 * self.amplitudes[:, None])

    @property
    def tilts(self) -> Floats:
        """(F, 3): tangents of the angles from the side across from each corner to the circumcenter.

        At its two ends, and negative if the circumcenter is beyond it: ``tan((B + C - A) / 2)`` at the corner
        A, which in the plane is the cotangent of A.
        """
        if self.space.is_euclidean:
            return self.cotangents
        versine = self.space.versine(self.opposite)
        product = np.roll(versine, 1, axis=1) * np.roll(versine, -1, axis=1)
        return self.cotangents + self.space.curvature * product / self.amplitudes[:, None]

    @property
    def kites(self) -> Floats:
        """(F, 3): signed areas between each corner, the middles of its two sides and the circumcenter.

        In units squared; they sum to the area.  A triangle of the hyperbolic plane that has no circumcenter
        is shared in thirds.
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
