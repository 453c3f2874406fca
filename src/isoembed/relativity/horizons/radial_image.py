"""Star-shaped surfaces, displaced along the radius; change of degree and center."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.horizons.discretization import DEALIASING, Discretization, Iterate
from isoembed.relativity.horizons.newton import Solution, solve
from isoembed.relativity.horizons.refinement import Image
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import is_symmetric_about_z

HIGHEST_DEGREES = (128, 2048)
"""Largest degrees without and with symmetry about the z-axis; a mass ratio of 1 : 100 needs the latter."""


@dataclass(frozen=True, eq=False)
class RadialImage(Image):
    """A star-shaped surface, f being its radius.

    Attributes
    ----------
    star : StarSurface
        Surface, without harmonics of nonzero order if slice and surface are symmetric about the z-axis.
    moves : int
        Remaining number of changes of the center.
    """

    rounding: ClassVar[float] = 1e-12
    resolved: ClassVar[float] = 1e-3
    patience: ClassVar[int] = 2

    star: StarSurface
    moves: int = 3

    @classmethod
    def of(cls, star: StarSurface, *, symmetric: bool) -> RadialImage:
        """Image of an initial guess."""
        degree = max(8, min(star.harmonics.degree, HIGHEST_DEGREES[int(symmetric)]))  # at least 8
        return cls(in_degree(star, degree, symmetric))

    @property
    def degree(self) -> int:
        """See `Image`."""
        return self.star.harmonics.degree

    @property
    def highest(self) -> int:
        """See `Image`."""
        return HIGHEST_DEGREES[int(self.star.harmonics.order == 0)]

    def finer(self) -> RadialImage:
        """See `Image`: degrees 8, 12, 16, 24, 32, 48, ..."""
        power = 1 << (self.degree.bit_length() - 1)
        following = 2 * power if self.degree >= 3 * power // 2 else 3 * power // 2
        return replace(self, star=in_degree(self.star, min(self.highest, following)))

    def solved(self, geometry: ThreeGeometry, expansion: float) -> tuple[RadialImage, Solution, int]:
        """See `Image`; about the centroid."""
        image, steps = self, 0
        while True:
            star = image.star
            solution = solve(discretized(geometry, star), star.coefficients, expansion)
            steps += solution.steps
            star = StarSurface(star.center, star.harmonics, solution.iterate.f)
            centered = recentered(star)
            if centered is star or image.moves == 0:
                return replace(image, star=star), solution, steps
            image = replace(image, star=centered, moves=image.moves - 1)

    def apart(self, geometry: ThreeGeometry) -> tuple[Discretization, Iterate]:
        """See `Image`."""
        n = self.degree + 5  # a rule without common nodes with that of `discretized`
        n += n == int(DEALIASING * self.degree) + 2
        other = _discretized(geometry, self.star, n, 2 * n + 1 if self.star.harmonics.order else 1)
        return other, other.iterate(self.star.coefficients)

    def surface(self, shifts: Floats) -> StarSurface:
        """See `Image`."""
        harmonics = self.star.harmonics
        return replace(
            self.star,
            misfit=root_mean_square(shifts),
            deviations=resized(shifts.T, harmonics, deviating(harmonics)).T,
        )


def root_mean_square(f: Floats) -> float:
    """Root mean square over the sphere of functions with coefficients (N, size)."""
    return float(np.sqrt(np.mean(np.sum(f**2, axis=1)) / (4.0 * np.pi)))


def discretized(geometry: ThreeGeometry, surface: StarSurface) -> Discretization:
    """Discretization of the star-shaped surfaces with the same center and harmonics."""
    harmonics = surface.harmonics
    n = int(DEALIASING * harmonics.degree) + 2
    return _discretized(geometry, surface, n, 2 * n if harmonics.order else 1)


def in_degree(surface: StarSurface, degree: int, symmetric: bool | None = None) -> StarSurface:
    """Surface with its radius truncated or zero-padded to another degree.

    Harmonics of nonzero order are left out if it is symmetric about the z-axis, by default if it has none.
    """
    symmetric = surface.harmonics.order == 0 if symmetric is None else symmetric
    harmonics = Harmonics(degree, 0 if symmetric else degree)
    c = resized(surface.coefficients[:, None], surface.harmonics, harmonics)
    return StarSurface(surface.center, harmonics, c[:, 0])


def is_symmetric(geometry: ThreeGeometry, surface: Surface) -> bool:
    """Whether surface and slice are symmetric about the z-axis, judged by the expansion."""
    center, R = surface.center, surface.mean_radius
    if isinstance(surface, StarSurface):
        upright = surface.harmonics.order == 0 and not any(center[:2])
    else:
        upright = surface.harmonics.order <= 1 and _is_upright(surface)
    if not upright:
        return False
    spheroid = np.zeros(Harmonics(2, 0).size)
    spheroid[[0, 2]] = R * np.sqrt(4.0 * np.pi) * np.array([1.0, 0.1])
    on_axis = (0.0, 0.0, center[2])
    # Not the surface itself: on a horizon the expansion is only rounding.
    others = [StarSurface.sphere(on_axis, 1.1 * R), StarSurface(on_axis, Harmonics(2, 0), spheroid)]
    return all(is_symmetric_about_z(partial(other.expansion, geometry)) for other in others)


def _is_upright(surface: Surface) -> bool:
    """Whether the points of a mapped surface have the same angles phi as their directions."""
    u = fibonacci_directions(200)  # sample points
    x = surface.points(u)
    twist = x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]
    return bool(np.abs(twist).max() <= 1e-12 * surface.mean_radius)  # rounding


def recentered(surface: StarSurface) -> StarSurface:
    """Surface about its centroid, to the accuracy of its harmonics, unless the center is already close."""
    degree = surface.harmonics.degree
    n = 2 * degree + 4
    u, weights = gauss_rule(n, 2 * n if surface.harmonics.order else 1)
    r = surface.radius(u)
    volume = weights * r**3 / 3.0
    off = (volume * 0.75 * r) @ u / volume.sum()
    if not surface.harmonics.order:
        off[:2] = 0.0
    if np.linalg.norm(off) <= 0.01 * surface.mean_radius:
        return surface
    return about(surface, (np.array(surface.center) + off).tolist())


def about(surface: StarSurface, center: Sequence[float]) -> StarSurface:
    """Surface about another center, to the accuracy of its harmonics."""
    off = np.subtract(center, surface.center)
    degree = surface.harmonics.degree
    # Intersection of the ray off + t u from the new center with the surface.
    transform = _transform(surface.harmonics, degree + 1, 2 * degree + 2 if surface.harmonics.order else 1)
    u = transform.u
    t = surface.radius(u)
    for _ in range(50):  # Newton's method
        w = off + t[:, None] * u
        size = np.linalg.norm(w, axis=1)
        v = w / size[:, None]
        r, slope, _ = surface.harmonics.derivatives(v, surface.coefficients)
        along = np.einsum("ni,ni->n", v, u)
        rate = along - np.einsum("ni,ni->n", slope, u) / size
        change = (size - r) / np.maximum(rate, 0.1)  # limited for rays that graze the surface
        t = t - change
        if np.abs(change).max() <= 1e-14 * size.max():  # rounding
            break
    coefficients = transform.analysis(t[:, None])[:, 0]
    return StarSurface(center, surface.harmonics, coefficients)


def _discretized(geometry: ThreeGeometry, surface: StarSurface, n: int, around: int) -> Discretization:
    transform = _transform(surface.harmonics, n, around)
    return Discretization(geometry, transform, SurfaceFamily.star(surface.center, transform.u))


@lru_cache(maxsize=4)
def _transform(harmonics: Harmonics, n: int, around: int) -> SphereTransform:
    """Cached transform with its tables, shared by successive surfaces."""
    return SphereTransform(harmonics, n, around)
