"""Surfaces of arbitrary shape, parametrized by the displacement along the normals of a reference surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.discretization import DEALIASING, Discretization, Iterate
from isoembed.relativity.horizons.newton import Solution, solve
from isoembed.relativity.horizons.radial_image import root_mean_square
from isoembed.relativity.horizons.refinement import Image
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized

HIGHEST_DEGREES = (96, 256)  # without and with symmetry about the z-axis


@dataclass(frozen=True, eq=False)
class NormalImage(Image):
    """Surface of arbitrary shape with a direction field, f being the displacement along it.

    Attributes
    ----------
    map : HarmonicMap
    direction : HarmonicMap, optional
        Normals of the last displacement; None initially.
    """

    rounding: ClassVar[float] = 1e-11
    resolved: ClassVar[float] = np.inf
    patience: ClassVar[int] = 1

    map: HarmonicMap
    direction: HarmonicMap | None = None

    @classmethod
    def of(cls, guess: Surface, *, symmetric: bool) -> NormalImage:
        """Image of an initial guess."""
        degree = guess.harmonics.degree
        map = HarmonicMap.projected(guess, degree, symmetric=symmetric)
        return cls(map.in_degree(max(degree, 24), symmetric=symmetric))  # initial degree

    @property
    def degree(self) -> int:
        """See `Image`."""
        return self.map.degree

    @property
    def highest(self) -> int:
        """See `Image`."""
        return HIGHEST_DEGREES[int(self.map.symmetric)]

    def finer(self) -> NormalImage:
        """See `Image`."""
        return NormalImage(self.map.in_degree(min(self.highest, self.degree * 4 // 3)))

    def solved(self, geometry: ThreeGeometry, expansion: float) -> tuple[NormalImage, Solution, int]:
        """See `Image`; the normals are recomputed until the surface is stationary."""
        map, steps = self.map, 0
        for count in range(4):  # largest number of updates of the normals
            if count < 2:  # largest number of reparametrizations
                map = map.reparametrized()
            image = NormalImage(map, map.normals())
            solution = solve(image.discretized(geometry), np.zeros(image.displacements.size), expansion)
            f = solution.iterate.f
            map = image.displaced(f)
            steps += solution.steps
            # The displacement is too small to require new normals.
            if np.linalg.norm(f) <= 1e-10 * map.radius:
                break
        return replace(image, map=map), solution, steps

    def apart(self, geometry: ThreeGeometry) -> tuple[Discretization, Iterate]:
        """See `Image`."""
        other = self.discretized(geometry, self.degree + 7)  # nodes different from those of the equations
        return other, other.iterate(np.zeros(self.displacements.size))

    def surface(self, shifts: Floats) -> MappedSurface:
        """See `Image`."""
        own, harmonics = self.map.coefficients, self.map.harmonics
        deviations = [
            resized(self.displaced(f).coefficients - own, harmonics, deviating(harmonics)) for f in shifts
        ]
        return MappedSurface(harmonics, own, misfit=root_mean_square(shifts), deviations=np.stack(deviations))

    @property
    def displacements(self) -> Harmonics:
        """Harmonics of f."""
        return Harmonics(self.degree, 0 if self.map.symmetric else self.degree)

    def discretized(self, geometry: ThreeGeometry, n: int | None = None) -> Discretization:
        """Family of nearby surfaces at nodes on n circles, by default as many as the equations require."""
        n = int(DEALIASING * self.degree) + 2 if n is None else n
        assert self.direction is not None
        transform = SphereTransform(self.displacements, n, 1 if self.map.symmetric else 2 * n)
        family = SurfaceFamily(self.map.jet_at_nodes(n), self.direction.jet_at_nodes(n))
        return Discretization(geometry, transform, family)

    def displaced(self, f: Floats) -> HarmonicMap:
        """Map ``X + f D``."""
        assert self.direction is not None
        return self.map.displaced(self.direction, f, self.displacements)
