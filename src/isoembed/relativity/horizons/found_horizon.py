"""Found horizons: Newton's method from a guess; surface, residual, errors and stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.evidence import Evidence
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.normal_image import NormalImage
from isoembed.relativity.horizons.principal_eigenvalue import principal_eigenvalue
from isoembed.relativity.horizons.radial_image import RadialImage, is_symmetric
from isoembed.relativity.horizons.refinement import End, Image, Refined, refined
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.reprs import short_repr
from isoembed.surface.estimate import percent


@short_repr
@dataclass(frozen=True, eq=False)
class FoundHorizon:
    """Surface of constant expansion in a slice; a marginally outer trapped surface if the expansion is 0.

    Attributes
    ----------
    surface : StarSurface or MappedSurface
        Surface with its estimated error, which enters the errors of its data.
    geometry : ThreeGeometry
        Slice.
    expansion : float
        Prescribed expansion: 0 for a horizon.
    residual : float
        Largest deviation from the prescribed expansion, times the areal radius, at points other than the
        collocation nodes.
    stability : float
        Principal eigenvalue of the stability operator, times the squared areal radius: 1 for the horizon of
        Schwarzschild.
    area : float
    iterations : int
        Total number of Newton steps in all degrees.
    notes : tuple of str
        Remarks on the result.
    outermost : Evidence or None
        Evidence on enclosing horizons; None for a horizon found near a guess.

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
        """Degree of the harmonics of the surface."""
        return self.surface.harmonics.degree

    @property
    def outer(self) -> bool:
        """Whether the horizon is stable, as outermost horizons are, in contrast to inner horizons."""
        return self.stability >= -1e-9  # rounding of zero

    @property
    def irreducible_mass(self) -> float:
        """Irreducible mass, ``sqrt(area / 16 pi)``."""
        return float(np.sqrt(self.area / (16.0 * np.pi)))

    def data(self, axis: Sequence[float] | None = None, name: str = "") -> SurfaceData:
        """Data for quasi-local energies; see `Surface.data`."""
        data = self.surface.data(self.geometry, axis, self.expansion == 0.0, name)
        return replace(data, notes=(*data.notes, *self.notes))


def horizon_near(
    geometry: ThreeGeometry, guess: Surface, expansion: float = 0.0, *, symmetric: bool | None = None
) -> FoundHorizon:
    """Find a surface of constant expansion near a guess by Newton's method alone, with its errors.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: there is none, or its error is too large.

    Parameters
    ----------
    geometry : ThreeGeometry
    guess : StarSurface or another Surface
        Initial surface; a star-shaped one is displaced along the radius, others along their normals.
    expansion : float
    symmetric : bool, optional
        Whether slice and guess are symmetric about the z-axis; by default this is tested.
    """
    axial = is_symmetric(geometry, guess) if symmetric is None else symmetric
    kind = RadialImage if isinstance(guess, StarSurface) else NormalImage
    return refined_horizon(geometry, kind.of(guess, symmetric=axial), expansion)  # type: ignore[arg-type]


def refined_horizon(geometry: ThreeGeometry, start: Image, expansion: float = 0.0) -> FoundHorizon:
    """Find a horizon from an image of the sphere; see `horizon_near`."""
    found = refined(geometry, start, expansion)
    at, discretization = found.solution.iterate, found.solution.discretization
    surface = found.image.surface(_shifts(found, geometry, expansion))
    R = discretization.areal_radius(at)
    left = (
        f"in degree {found.image.degree} the expansion is still {found.residual:.2g} / R, R the areal radius"
    )
    off = surface.misfit / surface.mean_radius
    if off > 0.01:  # too inaccurate to identify the surface
        raise NoConvergence(f"{left}, and the slice may displace the surface by {percent(off)}")
    if found.residual > 0.01 and found.end is not End.RESOLVED:  # not the prescribed expansion
        raise NoConvergence(f"{left}, and no higher degree was tried")
    stability = principal_eigenvalue(discretization.equations(at), R) * R * R
    notes = [f"{left}: no higher degree was tried"] if found.end is End.EXHAUSTED else []
    if expansion == 0.0 and abs(stability) <= 1e-7:  # the stability eigenvalue is zero
        notes.append(
            f"degenerate: its stability eigenvalue is {stability:.1g} / R^2, zero to rounding, as that of an "
            "extreme black hole, or of two horizons where they merge"
        )
    return FoundHorizon(
        surface=surface,
        geometry=geometry,
        expansion=expansion,
        residual=found.residual,
        stability=stability,
        area=4.0 * np.pi * R * R,
        iterations=found.steps,
        notes=tuple(notes),
    )


def _shifts(found: Refined, geometry: ThreeGeometry, expansion: float) -> Floats:
    """Changes of f (2, size) from the error of the slice and from the residual of the expansion."""
    at, discretization = found.solution.iterate, found.solution.discretization
    equations = discretization.equations(at)
    by_slice = equations.projected(discretization.expansion_errors(at))
    other, there = found.image.apart(geometry)
    left = other.equations(there).projected(there.local.expansion - expansion)
    return np.stack([equations.solved(by_slice), equations.solved(left)]) * np.sqrt(2.0)
