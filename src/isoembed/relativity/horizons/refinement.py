"""Refinement in degree of a surface of constant expansion, up to rounding."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from enum import Enum
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.discretization import Discretization, Iterate
from isoembed.relativity.horizons.newton import FAILURES, Solution
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


class End(Enum):
    """Reason for the end of a refinement in degree."""

    RESOLVED = "the residual is rounding, or the error of the slice"
    STALLED = "higher degrees do not reduce the residual"
    EXHAUSTED = "the highest degree is reached"


class Image(ABC):
    """Image of the sphere in harmonics of a fixed degree, with a family of nearby surfaces.

    Attributes
    ----------
    rounding : float
        Residual attributed to rounding.
    resolved : float
        Residual below which a higher degree must reduce it.
    patience : int
        Number of successive degrees without a halved residual that end the refinement.
    """

    rounding: ClassVar[float]
    resolved: ClassVar[float]
    patience: ClassVar[int]

    @property
    @abstractmethod
    def degree(self) -> int:
        """Degree of the harmonics."""

    @property
    @abstractmethod
    def highest(self) -> int:
        """Largest degree."""

    @abstractmethod
    def finer(self) -> Image:
        """Image in the next degree, or the largest."""

    @abstractmethod
    def solved(self, geometry: ThreeGeometry, expansion: float) -> tuple[Image, Solution, int]:
        """Nearby surface of constant expansion in this degree, and the number of Newton steps.

        Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
        `isoembed.relativity.horizons.newton.solve`.
        """

    @abstractmethod
    def apart(self, geometry: ThreeGeometry) -> tuple[Discretization, Iterate]:
        """Surface at nodes other than those of the equations."""

    @abstractmethod
    def surface(self, shifts: Floats) -> StarSurface | MappedSurface:
        """Surface with its errors, given as changes of f (N, size)."""


@dataclass(frozen=True, eq=False)
class Refined:
    """Surface of constant expansion in the degree of least residual.

    Attributes
    ----------
    image : Image
    solution : Solution
    residual : float
        Largest deviation from the prescribed expansion, times the areal radius, at nodes other than those of
        the equations.
    steps : int
        Total number of Newton steps in all degrees.
    end : End
    """

    image: Image
    solution: Solution
    residual: float
    steps: int = 0
    end: End = End.RESOLVED


def refined(geometry: ThreeGeometry, start: Image, expansion: float) -> Refined:
    """Find a surface of constant expansion near a given one, with adaptive degree.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.
    """
    image, best = start, None
    steps = stalled = failures = 0
    while True:
        try:
            image, solution, more = image.solved(geometry, expansion)
            apart, there = image.apart(geometry)
        except FAILURES:
            if best is not None and best.residual <= image.resolved:
                return replace(best, steps=steps, end=End.STALLED)
            failures += 1
            if failures > 4 or image.degree >= image.highest:
                raise
            image = image.finer()
            continue
        steps += more
        R = apart.areal_radius(there)
        residual = R * float(np.abs(there.local.expansion - expansion).max())
        falls = best is None or residual <= 0.5 * best.residual
        stalled = 0 if falls or residual > image.resolved else stalled + 1
        if best is None or residual < best.residual:
            best = Refined(image, solution, residual)
        slice_error = R * float(np.abs(apart.expansion_errors(there)).max())
        if residual <= max(image.rounding, 0.1 * slice_error):  # well below the error of the slice
            return replace(best, steps=steps, end=End.RESOLVED)
        if stalled >= image.patience:
            return replace(best, steps=steps, end=End.STALLED)
        if image.degree >= image.highest:
            return replace(best, steps=steps, end=End.EXHAUSTED)
        image = image.finer()
