"""Surfaces of constant expansion of any shape: moved along normals, in coordinates that fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.newton import NoConvergence, Solution, solve
from isoembed.relativity.horizons.sheet import Sheet
from isoembed.relativity.horizons.surface_family import SurfaceFamily
from isoembed.relativity.horizons.surface_level import Level, Shape
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class MappedLadderThresholds:
    """Thresholds of mapped surfaces of constant expansion."""

    nodes: float = threshold(1.5, "relative", "Circles of latitude over the degree: aliasing is cut off.")
    apart: int = threshold(7, "count", "Circles more than the degree where the expansion is tested.")
    first: int = threshold(24, "count", "First degree.")
    highest: tuple[int, int] = threshold((96, 256), "count", "Highest degree, and with symmetry about z.")
    rounding: float = threshold(1e-11, "over the areal radius", "Expansion that is rounding.")
    noise: float = threshold(0.1, "relative", "Expansion over the slice's error that is as small as that.")
    stalled: float = threshold(0.5, "relative", "Decrease of the expansion from degree to degree, at least.")
    still: float = threshold(1e-10, "radius", "Displacement after which the normals are not made anew.")
    trials: int = threshold(4, "count", "Degrees without a solution that do not end the search.")
    rounds: int = threshold(4, "count", "Most times that normals are made in one degree.")
    fitted: int = threshold(2, "count", "Times that coordinates are made in one degree.")
    step: float = threshold(0.02, "radius", "Longest step of a sweep inwards, in the mean.")
    shortest: float = threshold(2e-4, "radius", "Shortest step of a sweep.")
    together: float = threshold(1e-5, "radius", "The same of the first step.")
    most: int = threshold(200, "count", "Most steps of a sweep.")
    tail: float = threshold(1e-6, "radius", "Coefficients of high degree that ask for a higher one.")
    rough: float = threshold(1e-5, "step", "Residual at which a surface of a sweep is good enough.")


MAPPED_LADDER = MappedLadderThresholds()


@dataclass(frozen=True, eq=False)
class MappedRung:
    """A surface of constant expansion in one degree.

    Attributes
    ----------
    sheet : Sheet
    direction : Sheet
        Along which it was moved last.
    level : Level
        The surfaces ``sheet + f direction``.
    solution : Solution
    residual : float
        See `isoembed.relativity.horizons.ladder.Rung`.
    """

    sheet: Sheet
    direction: Sheet
    level: Level
    solution: Solution
    residual: float


def climbed_mapped(geometry: ThreeGeometry, start: Sheet, expansion: float) -> tuple[MappedRung, int, str]:
    """Surface of constant expansion near a given one, in the degree that it needs.

    Returns
    -------
    MappedRung
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
    highest = MAPPED_LADDER.highest[int(start.symmetric)]
    sheet, steps, failures = start.in_degree(max(start.degree, MAPPED_LADDER.first)), 0, 0
    best: MappedRung | None = None
    while True:
        try:
            sheet, rung, more = _settled(geometry, sheet, expansion)
        except (NoConvergence, InvalidMetric, InvalidParameter):
            if best is not None:
                return best, steps, "stalled"
            failures += 1
            if failures > MAPPED_LADDER.trials or sheet.degree >= highest:
                raise
            sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))
            continue
        steps += more
        stalled = best is not None and rung.residual > MAPPED_LADDER.stalled * best.residual
        if best is None or rung.residual < best.residual:
            best = rung
        apart, shape = mapped_shape_apart(geometry, rung)
        known = float(np.abs(apart.expansion_errors(shape)).max()) * apart.areal_radius(shape)
        if rung.residual <= max(MAPPED_LADDER.rounding, MAPPED_LADDER.noise * known):
            return best, steps, "enough"
        if stalled:
            return best, steps, "stalled"
        if sheet.degree >= highest:
            return best, steps, "exhausted"
        sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))


def mapped_shape_apart(geometry: ThreeGeometry, rung: MappedRung) -> tuple[Level, Shape]:
    """The surface at nodes that were not used."""
    level = _level(geometry, rung.sheet, rung.direction, rung.sheet.degree + MAPPED_LADDER.apart)
    return level, level.shape(np.zeros(level.transform.harmonics.size))


def swept_mapped(geometry: ThreeGeometry, start: Sheet) -> Sheet:
    """Sweep from a horizon inwards, through trapped surfaces, to where these end.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        The surfaces just inside of it are not trapped, or they do not end.
    """
    highest = MAPPED_LADDER.highest[int(start.symmetric)]
    sheet, step, trapped = start, MAPPED_LADDER.step, False
    for _ in range(MAPPED_LADDER.most):
        try:
            inner, expansion = _inside(geometry, sheet, step * start.radius)
        except (NoConvergence, InvalidMetric, InvalidParameter):
            expansion = np.inf
        if expansion >= 0.0 and trapped and np.isfinite(expansion):
            return inner
        if expansion >= 0.0:
            step *= 0.5
            if step >= (MAPPED_LADDER.shortest if trapped else MAPPED_LADDER.together):
                continue
            if trapped:
                return sheet
            raise NoConvergence("the surfaces of constant expansion just inside of it are not trapped")
        sheet, trapped = inner.even(), True
        step = min(MAPPED_LADDER.step, 1.5 * step)
        if sheet.tail > MAPPED_LADDER.tail and sheet.degree < highest:
            sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))
    raise NoConvergence("the trapped surfaces inside of it do not end")


def _inside(geometry: ThreeGeometry, sheet: Sheet, distance: float) -> tuple[Sheet, float]:
    """The surface of constant expansion that is so far inside, in the mean, and its expansion."""
    direction = sheet.normals()
    level = _level(geometry, sheet, direction, int(MAPPED_LADDER.nodes * sheet.degree) + 2)
    f = np.zeros(level.transform.harmonics.size)
    f[0] = -distance * np.sqrt(4.0 * np.pi)
    solution = solve(level, f, None, MAPPED_LADDER.rough * distance / sheet.radius)
    return sheet.moved(direction, solution.shape.f, level.transform.harmonics), solution.expansion


def _settled(geometry: ThreeGeometry, sheet: Sheet, expansion: float) -> tuple[Sheet, MappedRung, int]:
    """The surface in one degree: moved along normals that are made anew until it stays."""
    steps = 0
    for count in range(MAPPED_LADDER.rounds):
        if count < MAPPED_LADDER.fitted:
            sheet = sheet.even()
        direction = sheet.normals()
        level = _level(geometry, sheet, direction, int(MAPPED_LADDER.nodes * sheet.degree) + 2)
        solution = solve(level, np.zeros(level.transform.harmonics.size), expansion)
        f = solution.shape.f
        sheet = sheet.moved(direction, f, level.transform.harmonics)
        steps += solution.steps
        if np.linalg.norm(f) <= MAPPED_LADDER.still * sheet.radius:
            break
    rung = MappedRung(sheet, direction, level, solution, 0.0)
    apart, shape = mapped_shape_apart(geometry, rung)
    residual = apart.areal_radius(shape) * float(np.abs(shape.local.expansion - expansion).max())
    return sheet, MappedRung(sheet, direction, level, solution, residual), steps


def _level(geometry: ThreeGeometry, sheet: Sheet, direction: Sheet, n: int) -> Level:
    symmetric = sheet.symmetric
    harmonics = Harmonics(sheet.degree, 0 if symmetric else sheet.degree)
    transform = SphereTransform(harmonics, n, 1 if symmetric else 2 * n)
    return Level(geometry, transform, SurfaceFamily(sheet.jet(n), direction.jet(n)))
