"""Translated, rotated and rescaled slices."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import vector
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


class _Transformed(ThreeGeometry):
    """Transformation of another slice, ``geometry``, whose messages name points in its own coordinates."""

    geometry: ThreeGeometry

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.geometry.time_symmetric

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """See `ThreeGeometry`."""
        return tuple((mass, self._here(np.array(at)).tolist()) for mass, at in self.geometry.black_holes)

    @property
    def box(self) -> tuple[Floats, Floats] | None:
        """See `ThreeGeometry`."""
        if self.geometry.box is None:
            return None
        low, high = np.asarray(self.geometry.box, dtype=np.float64)
        return self._here(low), self._here(high)

    @property
    def hindrance(self) -> str:
        """See `ThreeGeometry`."""
        return self.geometry.hindrance

    @property
    def notes(self) -> tuple[str, ...]:
        """See `ThreeGeometry`."""
        return self.geometry.notes

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.metric(self._there(x))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.gradient(self._there(x))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.extrinsic_curvature(self._there(x))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.error(lambda slice_: quantity(self._of(slice_)))

    def deviating(self, x: Floats) -> Iterator[ThreeGeometry]:
        """See `ThreeGeometry`."""
        return map(self._of, self.geometry.deviating(self._there(x)))

    def least_diameter(self, x: Floats) -> float:
        """See `ThreeGeometry`."""
        return self.geometry.least_diameter(self._there(x))

    def _of(self, geometry: ThreeGeometry) -> Self:
        """Same transformation of another slice."""
        return replace(self, geometry=geometry)  # type: ignore[type-var] # subclasses are dataclasses

    @abstractmethod
    def _there(self, x: Floats) -> Floats:
        """Points (n, 3) in the coordinates of the other slice."""

    @abstractmethod
    def _here(self, x: Floats) -> Floats:
        """Point (3,) of the other slice in the coordinates of this one."""


@dataclass(frozen=True)
class Translated(_Transformed):
    """Translated slice, with the original origin at a center.

    Attributes
    ----------
    geometry : ThreeGeometry
        Slice to translate, such as `KerrSchild` with the hole at the origin.  Its messages name points
        relative to the center.
    center : three floats
    """

    geometry: ThreeGeometry
    center: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector("the center", self.center))

    def _there(self, x: Floats) -> Floats:
        return x - np.array(self.center)

    def _here(self, x: Floats) -> Floats:
        return np.add(x, self.center)


@dataclass(frozen=True, eq=False)
class RotatedFrame(_Transformed):
    """Slice in rotated and translated coordinates y, with original coordinates ``x = origin + rotation y``.

    Attributes
    ----------
    geometry : ThreeGeometry
    origin : ndarray, shape (3,)
    rotation : ndarray, shape (3, 3)
        The columns are the axes of the frame.
    """

    geometry: ThreeGeometry
    origin: Floats
    rotation: Floats

    @property
    def box(self) -> tuple[Floats, Floats] | None:
        """See `ThreeGeometry`: the cube inscribed in the largest sphere of the other box."""
        if self.geometry.box is None:
            return None
        low, high = np.asarray(self.geometry.box, dtype=np.float64)
        center, half = self._here(0.5 * (low + high)), 0.5 * (high - low).min() / np.sqrt(3.0)
        return center - half, center + half

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._tensor(super().metric(x))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(np.einsum("nkij,kl->nlij", self._tensor(super().gradient(x)), self.rotation))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._tensor(super().extrinsic_curvature(x))

    def _there(self, x: Floats) -> Floats:
        return self.origin + x @ self.rotation.T

    def _here(self, x: Floats) -> Floats:
        return (x - self.origin) @ self.rotation

    def _tensor(self, values: Floats) -> Floats:
        return np.asarray(self.rotation.T @ values @ self.rotation)


@dataclass(frozen=True)
class ScaledCurvature(_Transformed):
    """Metric of a slice with ``factor * K_ij``, for continuation from a time-symmetric slice."""

    geometry: ThreeGeometry
    factor: float

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.geometry.time_symmetric or self.factor == 0.0

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(self.factor * self.geometry.extrinsic_curvature(x))

    def _there(self, x: Floats) -> Floats:
        return x

    def _here(self, x: Floats) -> Floats:
        return x
