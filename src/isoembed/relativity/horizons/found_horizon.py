"""Surfaces of constant expansion that were found: what they are, how right, and how stable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.evidence import Evidence
from isoembed.relativity.horizons.ladder import climbed, shape_apart
from isoembed.relativity.horizons.mapped_ladder import climbed_mapped, mapped_shape_apart
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.sheet import Sheet
from isoembed.relativity.horizons.stability import principal_eigenvalue
from isoembed.relativity.horizons.surface_level import Level, Shape
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.reprs import short_repr
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.transforms import resized


@short_repr
@dataclass(frozen=True, eq=False)
class FoundHorizon:
    """A surface of constant expansion in a slice; a marginally outer trapped surface where that is 0.

    Attributes
    ----------
    surface : StarSurface or MappedSurface
        With what it may be off, for the errors of its data.
    geometry : ThreeGeometry
        The slice.
    expansion : float
        What was asked for: 0 for a horizon.
    residual : float
        The largest difference of the expansion from that, times the areal radius, at points that were not
        used to find it.
    stability : float
        The least eigenvalue of the stability operator, times the squared areal radius: 1 for a horizon of
        Schwarzschild.
    area : float
    iterations : int
        Newton's steps, in all degrees.
    notes : tuple of str
        What one should know.
    outermost : Evidence or None
        What was searched for other horizons that enclose it, and where; nothing of one near a guess.

    References
    ----------
    Andersson, Mars and Simon, Phys. Rev. Lett. 95 (2005) 111102, on the stability operator.
    """

    surface: StarSurface | MappedSurface
    geometry: ThreeGeometry
    expansion: float
    residual: float
    stability: float
    area: float
    iterations: int
    notes: tuple[str, ...] = ()
    outermost: Evidence | None = None

    @property
    def degree(self) -> int:
        """The degree of the surface's harmonics."""
        return self.surface.harmonics.degree

    @property
    def outer(self) -> bool:
        """Whether it is stable, as outermost horizons are; an inner horizon is not."""
        return self.stability >= -1e-9  # a stability of zero is not negative

    @property
    def irreducible_mass(self) -> float:
        """The root of the area over 16 pi."""
        return float(np.sqrt(self.area / (16.0 * np.pi)))

    def data(self, axis: Sequence[float] | None = None, name: str = "") -> SurfaceData:
        """Data of which quasi-local energies are computed: see `Surface.data`."""
        data = self.surface.data(self.geometry, axis, self.expansion == 0.0, name)
        return replace(data, notes=(*data.notes, *self.notes))


def star_horizon(
    geometry: ThreeGeometry, start: StarSurface, expansion: float, *, symmetric: bool
) -> FoundHorizon:
    """The star-shaped surface near a guess, with what it may be off.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        There is none, or it is known too badly.
    """
    rung, steps, ended = climbed(geometry, start, expansion, symmetric=symmetric)
    surface, shape = rung.surface, rung.solution.shape
    shifts = _shifts(rung.level, shape, shape_apart(geometry, surface), expansion)
    harmonics = surface.harmonics
    known = replace(
        surface,
        misfit=_size(shifts),
        deviations=resized(shifts.T, harmonics, deviating(harmonics)).T,
    )
    return _described(known, rung.level, shape, expansion, rung.residual, (steps, ended))


def mapped_horizon(geometry: ThreeGeometry, start: Sheet, expansion: float) -> FoundHorizon:
    """The surface near a guess, of any shape, with what it may be off.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        There is none, or it is known too badly.
    """
    rung, steps, ended = climbed_mapped(geometry, start, expansion)
    sheet, shape, level = rung.sheet, rung.solution.shape, rung.level
    shifts = _shifts(level, shape, mapped_shape_apart(geometry, rung), expansion)
    there = [sheet.moved(rung.direction, f, level.transform.harmonics) for f in shifts]
    deviations = [
        resized(each.coefficients - sheet.coefficients, sheet.harmonics, deviating(sheet.harmonics))
        for each in there
    ]
    surface = MappedSurface(
        sheet.harmonics, sheet.coefficients, misfit=_size(shifts), deviations=np.stack(deviations)
    )
    return _described(surface, level, shape, expansion, rung.residual, (steps, ended))


def _shifts(level: Level, shape: Shape, apart: tuple[Level, Shape], expansion: float) -> Floats:
    """Changes of f (2, size) that the slice's error, and what is left of the expansion, make."""
    equations = level.equations(shape)
    by_slice = equations.projected(level.expansion_errors(shape)[:, None])[:, 0]
    other, there = apart
    left = other.equations(there).projected((there.local.expansion - expansion)[:, None])[:, 0]
    return np.stack([equations.solved(by_slice), equations.solved(left)]) * np.sqrt(2.0)


def _size(shifts: Floats) -> float:
    return float(np.sqrt(np.mean(np.sum(shifts**2, axis=1)) / (4.0 * np.pi)))


def _described(
    surface: StarSurface | MappedSurface,
    level: Level,
    shape: Shape,
    expansion: float,
    residual: float,
    how: tuple[int, str],
) -> FoundHorizon:
    steps, ended = how
    degree, R = surface.harmonics.degree, level.areal_radius(shape)
    left = f"in degree {degree} the expansion is still {residual:.2g} / R, R the areal radius"
    off = surface.misfit / surface.mean_radius
    if off > 0.01:  # farther away it is another surface
        raise NoConvergence(f"{left}, and the slice may displace the surface by {100.0 * off:.2g} %")
    if residual > 0.01 and ended != "enough":  # not the expansion that was asked for
        raise NoConvergence(f"{left}, and no higher degree was tried")
    stability = principal_eigenvalue(level.equations(shape), R) * R * R
    notes = [f"{left}: no higher degree was tried"] if ended == "exhausted" else []
    if expansion == 0.0 and abs(stability) <= 1e-7:  # the stability eigenvalue is zero
        notes.append(
            f"degenerate: its stability eigenvalue is {stability:.1g} / R^2, zero to rounding, as that of an "
            "extreme black hole, or of two horizons where they merge"
        )
    return FoundHorizon(
        surface=surface,
        geometry=level.geometry,
        expansion=expansion,
        residual=residual,
        stability=stability,
        area=4.0 * np.pi * R * R,
        iterations=steps,
        notes=tuple(notes),
    )
