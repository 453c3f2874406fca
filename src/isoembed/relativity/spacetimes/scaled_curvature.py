"""Slice with scaled extrinsic curvature, for continuation from a time-symmetric slice."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class ScaledCurvature:
    """The metric of a slice with ``factor * K_ij``.

    Attributes
    ----------
    geometry : ThreeGeometry
    factor : float
    """

    geometry: ThreeGeometry
    factor: float

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.geometry.time_symmetric or self.factor == 0.0

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each, where the slice says that."""
        return tuple(getattr(self.geometry, "black_holes", ()))

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.metric(x)

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.gradient(x)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(self.factor * self.geometry.extrinsic_curvature(x))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.error(lambda slice_: quantity(ScaledCurvature(slice_, self.factor)))
