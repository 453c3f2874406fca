"""Refinement in degree of a surface of constant expansion, to rounding."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from enum import Enum
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.discretization import Discretization, Iterate
from isoembed.relativity.horizons.newton import Solution
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


class End(Enum):
    """Reason for the end of a refinement in degree."""

    RESOLVED = "the residual is rounding, or the error of the slice"
    STALLED = "higher degrees do not reduce the residual"
    EXHAUSTED = "the highest degree is reached"


class Image(ABC):
    """An image of the sphere in harmonics of one degree, with a family of surfaces around it.

    Attributes
    ----------
    rounding : float
        Residual that is rounding.
    resolved : float
        Residual from which on a higher degree must reduce it.
    patience : int
        Degrees in a row that may fail to halve the residual.
    retries : int
        Degrees without a solution before the search ends.
    failures : tuple of exceptions
        Those that a higher degree may cure.
    """

    rounding: ClassVar[float]
    resolved: ClassVar[float]
    patience: ClassVar[int]
    retries: ClassVar[int]
    failures: ClassVar[tuple[type[Exception], ...]]

    @property
    @abstractmethod
    def degree(self) -> int:
        """Degree of the harmonics."""

    @property
    @abstractmethod
    def highest(self) -> int:
        """The highest degree that is tried."""

    @abstractmethod
    def finer(self) -> Image:
        """The image in the next degree, or the highest."""

    @abstractmethod
    def solved(
        self, geometry: ThreeGeometry, expansion: float
    ) -> tuple[Image, Discretization, Solution, int]:
        """The surface of constant expansion nearby in this degree, and the number of Newton's steps.

        Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
        `isoembed.relativity.horizons.newton.solve`.
        """

    @abstractmethod
    def apart(self, geometry: ThreeGeometry) -> tuple[Discretization, Iterate]:
        """The surface at nodes that the equations do not have."""

    @abstractmethod
    def surface(self, shifts: Floats) -> StarSurface | MappedSurface:
        """The surface with its errors: changes of f (N, size), drawn at random."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A surface of constant expansion in the degree of the least residual.

    Attributes
    ----------
    image : Image
    discretization : Discretization
    solution : Solution
    residual : float
        The largest difference from the expansion that was asked for, times the areal radius, at nodes that
        were not used.
    steps : int
        Of Newton's method, in all degrees.
    end : End
    """

    image: Image
    discretization: Discretization
    solution: Solution
    residual: float
    steps: int = 0
    end: End = End.RESOLVED


def refined(geometry: ThreeGeometry, start: Image, expansion: float) -> Refined:
    """Surface of constant expansion near a given one, in the degree that it needs.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.
    """
    image, best = start, None
    steps = stalled = failures = 0
    while True:
        try:
            image, discretization, solution, more = image.solved(geometry, expansion)
            apart, there = image.apart(geometry)
        except image.failures:
            if best is not None and best.residual <= image.resolved:
                return replace(best, steps=steps, end=End.STALLED)
            failures += 1
            if failures > image.retries or image.degree >= image.highest:
                raise
            image = image.finer()
            continue
        steps += more
        R = apart.areal_radius(there)
        residual = R * float(np.abs(there.local.expansion - expansion).max())
        falls = best is None or residual <= 0.5 * best.residual
        stalled = 0 if falls or residual > image.resolved else stalled + 1
        if best is None or residual < best.residual:
            best = Refined(image, discretization, solution, residual)
        known = R * float(np.abs(apart.expansion_errors(there)).max())
        if residual <= max(image.rounding, 0.1 * known):  # no more digits than the slice has
            return replace(best, steps=steps, end=End.RESOLVED)
        if stalled >= image.patience:
            return replace(best, steps=steps, end=End.STALLED)
        if image.degree >= image.highest:
            return replace(best, steps=steps, end=End.EXHAUSTED)
        image = image.finer()
