"""Base class of polyhedral metrics: triangles with side lengths in a space of constant curvature."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.metric.triangles import Triangles
from isoembed.space import Space


class TriangleMetric(ABC):
    """Triangles glued along sides of equal length: `isoembed.PolyhedralMetric` and `isoembed.GluedMetric`."""

    space: Space
    if TYPE_CHECKING:  # attributes of one, properties of the other

        @property
        def faces(self) -> Indices:
            """Vertices of the triangles, (F, 3)."""

        @property
        def face_lengths(self) -> Floats:
            """Lengths of the half-edges, (F, 3)."""

    @property
    @abstractmethod
    def mean_length(self) -> float:
        """Mean edge length: the unit of every residual."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """Return the metric in another unit, with every length multiplied by this factor."""

    @property
    def curvature(self) -> float:
        """Curvature of the triangles and of `space`, in 1/length^2."""
        return self.space.curvature

    @property
    def triangles(self) -> Triangles:
        """Shapes of the faces, not cached as they take more memory than the metric."""
        return Triangles.of(self.face_lengths, self.curvature)

    @property
    def area(self) -> float:
        """Area of the surface, in the unit of the lengths squared; infinite beyond the floats."""
        triangles = self.triangles
        return float(triangles.areas.sum()) * triangles.unit * triangles.unit

    @property
    def unit(self) -> float:
        """Power of two below the mean edge length, so that dividing by it is exact."""
        return float(np.ldexp(1.0, int(np.frexp(self.mean_length)[1]) - 1))

    @property
    def normalized(self) -> Self:
        """The metric in its own `unit`, in which its mean edge length is between 1 and 2."""
        return self if self.unit == 1 else self._normalized

    @cached_property
    def _normalized(self) -> Self:
        factor = 1 / self.unit
        return self.scaled(factor) if math.isfinite(factor) else self.scaled(2.0**1000).normalized
