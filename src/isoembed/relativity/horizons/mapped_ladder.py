"""Surfaces of constant expansion of any shape: moved along normals, in coordinates that fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.newton import NoConvergence, Solution, solve
from isoembed.relativity.horizons.sheet import Sheet
from isoembed.relativity.horizons.surface_family import SurfaceFamily
from isoembed.relativity.horizons.surface_level import DEALIASING, Level, Shape
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform

HIGHEST_DEGREES = (96, 256)  # without and with symmetry about the z-axis
LONGEST_STEP = 0.02  # mean step of a sweep inwards, over the radius


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
    highest = HIGHEST_DEGREES[int(start.symmetric)]
    sheet, steps, failures = start.in_degree(max(start.degree, 24)), 0, 0  # first degree
    best: MappedRung | None = None
    while True:
        try:
            sheet, rung, more = _settled(geometry, sheet, expansion)
        except (NoConvergence, InvalidMetric, InvalidParameter):
            if best is not None:
                return best, steps, "stalled"
            failures += 1
            if failures > 4 or sheet.degree >= highest:  # degrees without a solution before the search ends
                raise
            sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))
            continue
        steps += more
        # Least decrease of the residual from degree to degree.
        stalled = best is not None and rung.residual > 0.5 * best.residual
        if best is None or rung.residual < best.residual:
            best = rung
        apart, shape = mapped_shape_apart(geometry, rung)
        known = float(np.abs(apart.expansion_errors(shape)).max()) * apart.areal_radius(shape)
        # Rounding in the expansion, over the areal radius, or no more digits than the slice has.
        if rung.residual <= max(1e-11, 0.1 * known):
            return best, steps, "enough"
        if stalled:
            return best, steps, "stalled"
        if sheet.degree >= highest:
            return best, steps, "exhausted"
        sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))


def mapped_shape_apart(geometry: ThreeGeometry, rung: MappedRung) -> tuple[Level, Shape]:
    """The surface at nodes that were not used."""
    # A rule that shares no nodes with that of the equations.
    level = _level(geometry, rung.sheet, rung.direction, rung.sheet.degree + 7)
    return level, level.shape(np.zeros(level.transform.harmonics.size))


def swept_mapped(geometry: ThreeGeometry, start: Sheet) -> Sheet:
    """Sweep from a horizon inwards, through trapped surfaces, to where these end.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        The surfaces just inside of it are not trapped, or they do not end.
    """
    highest = HIGHEST_DEGREES[int(start.symmetric)]
    sheet, step, trapped = start, LONGEST_STEP, False
    for _ in range(200):  # steps of the sweep
        try:
            inner, expansion = _inside(geometry, sheet, step * start.radius)
        except (NoConvergence, InvalidMetric, InvalidParameter):
            expansion = np.inf
        if expansion >= 0.0 and trapped and np.isfinite(expansion):
            return inner
        if expansion >= 0.0:
            step *= 0.5
            # The first step may be shorter than later ones.
            if step >= (2e-4 if trapped else 1e-5):
                continue
            if trapped:
                return sheet
            raise NoConvergence("the surfaces of constant expansion just inside of it are not trapped")
        sheet, trapped = inner.even(), True
        step = min(LONGEST_STEP, 1.5 * step)
        # Coefficients of high degree, over the radius, that ask for a higher one.
        if sheet.tail > 1e-6 and sheet.degree < highest:
            sheet = sheet.in_degree(min(highest, sheet.degree * 4 // 3))
    raise NoConvergence("the trapped surfaces inside of it do not end")


def _inside(geometry: ThreeGeometry, sheet: Sheet, distance: float) -> tuple[Sheet, float]:
    """The surface of constant expansion that is so far inside, in the mean, and its expansion."""
    direction = sheet.normals()
    level = _level(geometry, sheet, direction, int(DEALIASING * sheet.degree) + 2)
    f = np.zeros(level.transform.harmonics.size)
    f[0] = -distance * np.sqrt(4.0 * np.pi)
    solution = solve(level, f, None, 1e-5 * distance / sheet.radius)  # surfaces of a sweep need few digits
    return sheet.moved(direction, solution.shape.f, level.transform.harmonics), solution.expansion


def _settled(geometry: ThreeGeometry, sheet: Sheet, expansion: float) -> tuple[Sheet, MappedRung, int]:
    """The surface in one degree: moved along normals that are made anew until it stays."""
    steps = 0
    for count in range(4):  # most times that normals are recomputed
        if count < 2:  # times that coordinates are recomputed
            sheet = sheet.even()
        direction = sheet.normals()
        level = _level(geometry, sheet, direction, int(DEALIASING * sheet.degree) + 2)
        solution = solve(level, np.zeros(level.transform.harmonics.size), expansion)
        f = solution.shape.f
        sheet = sheet.moved(direction, f, level.transform.harmonics)
        steps += solution.steps
        # The surface moved too little to compute the normals anew.
        if np.linalg.norm(f) <= 1e-10 * sheet.radius:
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
