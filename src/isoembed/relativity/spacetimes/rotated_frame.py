"""Slice in a rotated and translated Cartesian frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True, eq=False)
class RotatedFrame:
    """The slice in coordinates y, with ``x = origin + rotation y`` its own.

    Attributes
    ----------
    geometry : ThreeGeometry
        Its messages name points x.
    origin : ndarray, shape (3,)
    rotation : ndarray, shape (3, 3)
        The columns are the axes of the frame.
    """

    geometry: ThreeGeometry
    origin: Floats
    rotation: Floats

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.geometry.time_symmetric

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each, where the slice says that."""
        holes = getattr(self.geometry, "black_holes", ())
        return tuple((mass, (np.subtract(at, self.origin) @ self.rotation).tolist()) for mass, at in holes)

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._tensor(self.geometry.metric(self._there(x)))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        gradient = self._tensor(self.geometry.gradient(self._there(x)))
        return np.asarray(np.einsum("nkij,kl->nlij", gradient, self.rotation))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._tensor(self.geometry.extrinsic_curvature(self._there(x)))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.error(lambda slice_: quantity(RotatedFrame(slice_, self.origin, self.rotation)))

    def _there(self, x: Floats) -> Floats:
        return self.origin + x @ self.rotation.T

    def _tensor(self, values: Floats) -> Floats:
        return np.asarray(self.rotation.T @ values @ self.rotation)
