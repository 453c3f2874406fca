"""Surfaces of constant expansion in higher and higher degree, until their expansion is right to rounding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.horizons.newton import NoConvergence, Solution, solve
from isoembed.relativity.horizons.surface_family import SurfaceFamily
from isoembed.relativity.horizons.surface_level import DEALIASING, Level, Shape
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import is_symmetric_about_z

HIGHEST_DEGREE = 128
HIGHEST_SYMMETRIC = (
    2048  # degree, with symmetry about the z-axis; 1 : 100 takes it near the end of the horizon
)
ROUNDING = 1e-12  # in the expansion, over the areal radius
RESOLVED = 1e-3  # expansion, over the areal radius, of a surface that is resolved


@dataclass(frozen=True, eq=False)
class Rung:
    """A surface of constant expansion in one degree.

    Attributes
    ----------
    surface : StarSurface
    level : Level
    solution : Solution
    residual : float
        The largest difference from the expansion that was asked for, times the areal radius, at nodes that
        were not used.
    """

    surface: StarSurface
    level: Level
    solution: Solution
    residual: float


def level_of(geometry: ThreeGeometry, surface: StarSurface) -> Level:
    """The star-shaped surfaces about the same center and in the same harmonics."""
    harmonics = surface.harmonics
    n = int(DEALIASING * harmonics.degree) + 2
    return _level(geometry, surface, n, 2 * n if harmonics.order else 1)


def shape_apart(geometry: ThreeGeometry, surface: StarSurface) -> tuple[Level, Shape]:
    """The surface at nodes that are not those of `level_of`."""
    n = surface.harmonics.degree + 5  # a rule that shares no nodes with that of `level_of`
    n += n == int(DEALIASING * surface.harmonics.degree) + 2
    level = _level(geometry, surface, n, 2 * n + 1 if surface.harmonics.order else 1)
    return level, level.shape(surface.coefficients)


def in_degree(surface: StarSurface, degree: int, symmetric: bool) -> StarSurface:
    """The surface with its radius cut off, or filled up with zeros."""
    harmonics = Harmonics(degree, 0 if symmetric else degree)
    c = resized(surface.coefficients[:, None], surface.harmonics, harmonics)
    return StarSurface(surface.center, harmonics, c[:, 0])


def is_symmetric(geometry: ThreeGeometry, surface: Surface) -> bool:
    """Whether surface and slice are symmetric about the z-axis, as far as the expansion tells."""
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
    # Not the surface itself, which may be a horizon: there is rounding only.
    others = [StarSurface.sphere(on_axis, 1.1 * R), StarSurface(on_axis, Harmonics(2, 0), spheroid)]
    return all(is_symmetric_about_z(partial(other.expansion, geometry)) for other in others)


def _is_upright(surface: Surface) -> bool:
    """Whether the angle phi of a point of a mapped surface is that of its direction."""
    u = fibonacci_directions(200)  # where a twist is looked for
    x = surface.points(u)
    twist = x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]
    return bool(np.abs(twist).max() <= 1e-12 * surface.mean_radius)  # rounding


def climbed(
    geometry: ThreeGeometry, start: StarSurface, expansion: float, *, symmetric: bool
) -> tuple[Rung, int, str]:
    """Surface of constant expansion near a given one, in the degree that it needs.

    Parameters
    ----------
    geometry : ThreeGeometry
    start : StarSurface
    expansion : float
    symmetric : bool
        About z: slice and surface.

    Returns
    -------
    Rung
        The one of the least residual.
    int
        Newton's steps in all degrees.
    str
        Why it ended: ``"enough"``, ``"stalled"`` or ``"exhausted"``.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    highest = HIGHEST_SYMMETRIC if symmetric else HIGHEST_DEGREE
    degree, steps, waited, failures = max(8, min(start.harmonics.degree, highest)), 0, 0, 0  # first degree
    best: Rung | None = None
    surface, moves = start, 0
    while True:
        surface = in_degree(surface, degree, symmetric)
        level = level_of(geometry, surface)
        try:
            enough = 0.0 if best is None else 1e-3 * ROUNDING
            solution = solve(level, surface.coefficients, expansion, enough)
        except NoConvergence:
            if best is not None and best.residual <= RESOLVED:
                return best, steps, "stalled"
            failures += 1
            if failures > 3 or degree >= highest:  # degrees without a solution before the search ends
                raise
            degree = min(highest, _next(degree))
            continue
        steps += solution.steps
        surface = StarSurface(surface.center, surface.harmonics, solution.shape.f)
        centered = recentered(surface, symmetric)
        if centered is not surface and moves < 3:  # the center is moved three times at most
            surface, moves = centered, moves + 1
            continue
        apart, shape = shape_apart(geometry, surface)
        residual = apart.areal_radius(shape) * float(np.abs(shape.local.expansion - expansion).max())
        # Least decrease of the residual from degree to degree.
        falls = best is None or residual <= 0.5 * best.residual
        waited = 0 if falls or residual > RESOLVED else waited + 1
        if best is None or residual < best.residual:
            best = Rung(surface, level, solution, residual)
        known = float(np.abs(apart.expansion_errors(shape)).max()) * apart.areal_radius(shape)
        if residual <= max(ROUNDING, 0.1 * known):  # no more digits than the slice has
            return best, steps, "enough"
        if waited >= 2:  # two degrees without a decrease
            return best, steps, "stalled"
        if degree >= highest:
            return best, steps, "exhausted"
        degree = min(highest, _next(degree))


def recentered(surface: StarSurface, symmetric: bool) -> StarSurface:
    """The same surface about its centroid, as right as its harmonics are, if the center is off it."""
    degree = surface.harmonics.degree
    n = 2 * degree + 4
    u, weights = gauss_rule(n, 2 * n if surface.harmonics.order else 1)
    r = surface.radius(u)
    volume = weights * r**3 / 3.0
    off = (volume * 0.75 * r) @ u / volume.sum()
    if symmetric or not surface.harmonics.order:
        off[:2] = 0.0
    if np.linalg.norm(off) <= 0.01 * surface.mean_radius:
        return surface
    return about(surface, (np.array(surface.center) + off).tolist())


def about(surface: StarSurface, center: Sequence[float]) -> StarSurface:
    """The same surface about another center, as right as its harmonics are."""
    off = np.subtract(center, surface.center)
    degree = surface.harmonics.degree
    # From the new center: the ray off + t u meets the surface.
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
        change = (size - r) / np.maximum(rate, 0.1)  # rays that graze the surface take short steps
        t = t - change
        if np.abs(change).max() <= 1e-14 * size.max():  # rounding
            break
    coefficients = transform.analysis(t[:, None])[:, 0]
    return StarSurface(center, surface.harmonics, coefficients)


def _level(geometry: ThreeGeometry, surface: StarSurface, n: int, around: int) -> Level:
    transform = _transform(surface.harmonics, n, around)
    return Level(geometry, transform, SurfaceFamily.star(surface.center, transform.u))


@lru_cache(maxsize=4)
def _transform(harmonics: Harmonics, n: int, around: int) -> SphereTransform:
    """A transform with its tables, which one surface after the other needs."""
    return SphereTransform(harmonics, n, around)


def _next(degree: int) -> int:
    """The next degree: 8, 12, 16, 24, 32, 48, ..."""
    power = 1 << (degree.bit_length() - 1)
    return 2 * power if degree >= 3 * power // 2 else 3 * power // 2
