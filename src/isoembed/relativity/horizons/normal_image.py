"""Surfaces of arbitrary shape, parametrized by the displacement along the normals of a reference surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.discretization import DEALIASING, Discretization, Iterate
from isoembed.relativity.horizons.newton import FAILURES, NoConvergence, Solution, solve
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
LONGEST_STEP = 0.02  # largest mean step of an inward foliation, in radii


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


def foliated_inwards(geometry: ThreeGeometry, start: HarmonicMap) -> NormalImage:
    """End of a foliation by constant expansion from a horizon inward, through trapped surfaces.

    Returns the first leaf whose expansion is not negative, or the last trapped leaf if that is not reached.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: the surfaces just inside the horizon are
    not trapped, or the trapped surfaces do not end.
    """
    highest = HIGHEST_DEGREES[int(start.symmetric)]
    map, step, trapped = start, LONGEST_STEP, False
    for _ in range(200):  # leaves
        try:
            inner, expansion = _inside(geometry, map, step * start.radius)
        except FAILURES:
            expansion = np.inf
        if expansion >= 0.0 and trapped and np.isfinite(expansion):
            return NormalImage(inner)
        if expansion >= 0.0:
            step *= 0.5
            # The first step may be shorter than the others.
            if step >= (2e-4 if trapped else 1e-5):
                continue
            if trapped:
                return NormalImage(map)
            raise NoConvergence("the surfaces of constant expansion just inside of it are not trapped")
        map, trapped = inner.reparametrized(), True
        step = min(LONGEST_STEP, 1.5 * step)
        high = map.harmonics.labels[0] > 0.875 * map.degree
        tail = float(np.abs(map.coefficients[high]).max()) / map.radius
        # Large coefficients of high degree require a higher degree.
        if tail > 1e-6 and map.degree < highest:
            map = map.in_degree(min(highest, map.degree * 4 // 3))
    raise NoConvergence("the trapped surfaces inside of it do not end")


def _inside(geometry: ThreeGeometry, map: HarmonicMap, distance: float) -> tuple[HarmonicMap, float]:
    """Surface of constant expansion at a mean distance inside a given one, and its expansion."""
    image = NormalImage(map, map.normals())
    f = np.zeros(image.displacements.size)
    f[0] = -distance * np.sqrt(4.0 * np.pi)
    enough = 1e-5 * distance / map.radius  # intermediate leaves need few digits
    solution = solve(image.discretized(geometry), f, None, enough)
    return image.displaced(solution.iterate.f), solution.expansion
