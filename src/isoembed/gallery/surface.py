"""Closed-form surfaces: points, curvatures and integrals.

A surface is a map from the unit sphere: each unit vector, or *direction*, is mapped to a point. Computations
use a unit of length intrinsic to the surface, so that 1e-150 and 1e12 are ordinary sizes.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import field, fields
from functools import cached_property
from math import isfinite, pi, sqrt
from operator import index
from typing import Any, ClassVar, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats

Triple = tuple[float, float, float]

MAX_ASPECT = 1e4
"""Longest over shortest axis: far beyond reasonable triangulations, and within the limits of rounding."""


def number(name: str, value: SupportsFloat | str) -> float:
    """Convert to a finite float; a ValueError names parameter and value."""
    try:
        x = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, not {value!r}") from None
    if not isfinite(x):
        raise ValueError(f"{name} must be finite, not {x}")
    return x


def positive(name: str, value: SupportsFloat | str) -> float:
    """Convert to a positive finite float; a ValueError names parameter and value."""
    x = number(name, value)
    if x <= 0.0:
        raise ValueError(f"{name} must be positive, not {x}")
    return x


def integer(name: str, value: SupportsIndex) -> int:
    """Convert to an integer; a ValueError names parameter and value."""
    try:
        return index(value)
    except TypeError:
        raise ValueError(f"{name} must be an integer, not {value!r}") from None


def semiaxes(name: str, axes: object) -> Triple:
    """Convert to three positive numbers of moderate aspect; a ValueError names parameter and value."""
    values = tuple(axes) if isinstance(axes, tuple | list | np.ndarray) else (axes,)
    if len(values) != 3:
        raise ValueError(f"{name} must be three numbers, not {axes!r}")
    a, b, c = (positive(f"{name}[{i}]", value) for i, value in enumerate(values))
    if max(a, b, c) > MAX_ASPECT * min(a, b, c):
        raise ValueError(f"{name} must not differ by more than a factor {MAX_ASPECT:g}, not {(a, b, c)}")
    return a, b, c


def option(default: Any, meaning: str, check: Callable[[str, Any], Any] = number) -> Any:
    """Field of a surface with its default, its help text, and a function that checks values."""
    return field(default=default, metadata={"help": meaning, "check": check})


def unit_vectors(directions: ArrayLike) -> Floats:
    """Directions as an (n, 3) array of unit vectors.

    Raises
    ------
    ValueError
        If the shape is not (n, 3), or a row is zero or not finite.
    """
    u = np.asarray(directions, dtype=np.float64)
    if u.ndim != 2 or u.shape[1] != 3:
        raise ValueError(f"directions must have shape (n, 3), not {u.shape}")
    length = np.linalg.norm(u, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0.0)))
    if bad.size:
        raise ValueError(f"direction {bad[0]} must be a nonzero finite vector, not {u[bad[0]].tolist()}")
    return u / length[:, None]


class ClosedForm(ABC):
    """A surface known in closed form, the image of the unit sphere or of a zone of it.

    Subclasses are frozen dataclasses whose fields, created by `option`, are the surface's parameters. They
    implement the underscored methods, all in units of ``_unit`` and for checked unit vectors.
    """

    name: ClassVar[str]

    def __post_init__(self) -> None:
        for each in fields(self):  # type: ignore[arg-type]
            value = each.metadata["check"](f"{self.name}: {each.name}", getattr(self, each.name))
            object.__setattr__(self, each.name, value)
        self._check()

    def _check(self) -> None:  # noqa: B027 - most parameters are independent
        """Raise a ValueError if the parameters are inconsistent."""

    @property
    @abstractmethod
    def _unit(self) -> float:
        """Unit of length of the surface."""

    @abstractmethod
    def _points(self, u: Floats) -> Floats:
        """Points (n, 3)."""

    def point(self, directions: ArrayLike) -> Floats:
        """Points (n, 3) of the surface in given directions (n, 3)."""
        return self._unit * self._points(unit_vectors(directions))


class Surface(ClosedForm):
    """A closed surface of genus 0 known in closed form: the image of the unit sphere."""

    @abstractmethod
    def _normals(self, u: Floats) -> Floats:
        """Outward unit normals (n, 3)."""

    @abstractmethod
    def _curvatures(self, u: Floats) -> tuple[Floats, Floats]:
        """Gaussian curvature K and mean curvature H = (k1 + k2)/2, each (n,)."""

    @abstractmethod
    def _area_density(self, u: Floats) -> Floats:
        """Area element relative to that of the unit sphere of directions (n,)."""

    @abstractmethod
    def _moved(self, u: Floats, displacement: Floats) -> Floats:
        """Directions of points displaced by tangent vectors, to first order."""

    @cached_property
    @abstractmethod
    def _integrals(self) -> Floats:
        """Area, volume and int H dA."""

    def normal(self, directions: ArrayLike) -> Floats:
        """Outward unit normals (n, 3) in given directions (n, 3)."""
        return self._normals(unit_vectors(directions))

    def gaussian_curvature(self, directions: ArrayLike) -> Floats:
        """Gaussian curvature K (n,), in 1/length^2, in given directions (n, 3)."""
        return self._curvatures(unit_vectors(directions))[0] / self._unit / self._unit

    def mean_curvature(self, directions: ArrayLike) -> Floats:
        """Mean curvature H = (k1 + k2)/2 (n,), in 1/length, positive where convex."""
        return self._curvatures(unit_vectors(directions))[1] / self._unit

    def area_density(self, directions: ArrayLike) -> Floats:
        """Area element dA/d(omega) (n,), in length^2, relative to the unit sphere of directions."""
        return self._area_density(unit_vectors(directions)) * self._unit * self._unit

    @property
    def area(self) -> float:
        """Area of the smooth surface, in length^2."""
        return float(self._integrals[0]) * self._unit * self._unit

    @property
    def volume(self) -> float:
        """Volume enclosed by the smooth surface, in length^3."""
        return float(self._integrals[1]) * self._unit * self._unit * self._unit

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA with H = (k1 + k2)/2, in length: 4 pi for the unit sphere."""
        return float(self._integrals[2]) * self._unit

    @property
    def _radius(self) -> float:
        """Areal radius, in units of ``_unit``."""
        return sqrt(self._integrals[0] / (4.0 * pi))


class SurfaceWithAxes(Surface):
    """Surface with three semi-axes; the longest one is the unit of length."""

    axes: Triple

    @property
    def _unit(self) -> float:
        return max(self.axes)

    @cached_property
    def _semiaxes(self) -> Floats:
        return np.array(self.axes) / self._unit
