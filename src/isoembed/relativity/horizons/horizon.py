"""Horizon of a slice: smooth surface, data for its energies, origin and notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.expansion import ExpansionTest, classify_horizon, expansion_test
from isoembed.relativity.horizons.foliated_horizon import coarse_grid
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.reprs import short_repr
from isoembed.surface.estimate import percent

GivenHorizon = CoordinateShape | SurfaceData | Surface | FoundHorizon
"""Representations of a horizon accepted by `horizon_data`."""
OWN_METRIC = "has a metric of its own: leave out the geometry"


@short_repr
@dataclass(frozen=True)
class HorizonFacts:
    """Properties of a surface as a horizon, from its file, the finder and its expansion.

    Attributes
    ----------
    marginal : bool
        Whether the surface is treated as a horizon.
    test : ExpansionTest or None
        None for a metric without k.
    surface : Surface or None
        None for a metric on a grid.
    points : CoordinateShape or None
        Contents of the file.
    found : FoundHorizon or None
        Result of the finder.
    curvature_check : CurvatureCheck or None
        Difference between the curvature in the file, if any, and that of the metric in use.
    """

    marginal: bool
    test: ExpansionTest | None = None
    surface: Surface | None = None
    points: CoordinateShape | None = None
    found: FoundHorizon | None = None
    curvature_check: CurvatureCheck | None = None

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON; empty for a metric without k."""
        facts: dict[str, Any] = {}
        if (file := self.points) is not None:
            facts = {"time": file.time, "iteration": file.iteration, "points": len(file.points)}
        if self.surface is not None:
            radius = self.surface.mean_radius
            facts |= {"center": list(self.surface.center), "mean_coordinate_radius": radius}
        if (found := self.found) is not None:
            facts |= {"degree": found.degree, "residual": found.residual}
            facts |= {"stability": found.stability, "outer": found.outer}
            facts["outermost"] = found.outermost and found.outermost.report
        elif self.surface is not None:
            facts["misfit"] = self.surface.misfit
        return {**facts, **self.test.report, "marginal": self.marginal} if self.test else facts


def horizon_data(
    found: GivenHorizon,
    geometry: ThreeGeometry | None = None,
    *,
    axis: Sequence[float] | None = None,
    marginal: bool | None = None,
    name: str = "",
) -> tuple[SurfaceData, HorizonFacts]:
    """Data of a surface in its slice, from a file or from the finder.

    Parameters
    ----------
    found : CoordinateShape, SurfaceData, StarSurface, MappedSurface or FoundHorizon
        Surface, for example from `isoembed.relativity.read_horizon` or `isoembed.relativity.find_horizon`.
    geometry : ThreeGeometry, optional
        Slice.  Required for coordinates and surfaces, not allowed for a surface with its own metric.  A found
        horizon has its own; with another geometry only its surface is used.
    axis : sequence of 3 floats, optional
        Additional axis for the angular momentum, in slice coordinates.
    marginal : bool, optional
        Whether it is a horizon; by default `expansion_test` decides, and a metric without k is not one.
    name : str

    Raises
    ------
    InvalidParameter
        The geometry is missing, or given for a surface with its own metric; an axis is given without
        coordinates; or the points are not star-shaped and there are no triangles.
    """
    if isinstance(found, FoundHorizon):
        if geometry is None or geometry is found.geometry:
            data = found.data(axis, name)
            test = expansion_test(data)
            data = data if marginal is None else classify_horizon(data, marginal, test)
            return data, HorizonFacts(data.marginal, test, found.surface, found=found)
        found = found.surface
    if isinstance(found, SurfaceData):
        if geometry is not None:
            raise InvalidParameter(f"{name or 'the surface'} {OWN_METRIC}")
        if axis is not None:
            raise InvalidParameter(f"{name} has no coordinates, which an axis requires")
        measured = None if found.mean_curvature is None else expansion_test(found)
        data = classify_horizon(replace(found, name=name), marginal, measured)
        return data, HorizonFacts(data.marginal, measured, curvature_check=CurvatureCheck.of(data))
    if geometry is None:
        contents = getattr(found, "contents", f"{name or 'this'} is a surface in coordinates")
        raise InvalidParameter(f"{contents}: name its geometry")
    points = None if isinstance(found, Surface) else found
    surface = found if isinstance(found, Surface) else coordinate_surface(found)
    data = surface.data(geometry, axis, name=name)
    test = expansion_test(data)
    data = classify_horizon(data, marginal, test)
    if coarse := coarse_grid(geometry, surface):
        data = replace(data, notes=(*data.notes, coarse))
    directions = surface.directions if points and isinstance(surface, MappedSurface) else None
    check = CurvatureCheck.of(data, points, directions)
    return data, HorizonFacts(data.marginal, test, surface, points, curvature_check=check)


def coordinate_surface(found: CoordinateShape) -> StarSurface | MappedSurface:
    """Smooth surface through the points of a file, with its notes.

    Triangles of the file are used if they are not star-shaped about the center, or if a mapped surface fits
    their vertices much better.  Raises `InvalidParameter`: the points are not star-shaped about the center
    and there are no triangles, or the triangles are too few for a smooth surface.
    """
    surface = _fitted(found)
    return replace(surface, notes=(*found.notes, *surface.notes)) if found.notes else surface


def _fitted(found: CoordinateShape) -> StarSurface | MappedSurface:
    if found.is_hull:
        star = StarSurface.from_points(found.points, found.center.tolist(), found.faces)
        # A larger misfit means that the points are not star-shaped.
        if star.misfit > 0.1 * star.mean_radius:
            relative = star.misfit / star.mean_radius
            raise InvalidParameter(
                f"{found.source or 'the points'}: a surface r(u) about the center {written(found.center)} "
                f"misses the points by {star.misfit:.2g}, {percent(relative)} of its radius: they are not "
                "star-shaped about it, and other shapes take triangles (faces) between the points"
            )
        return star
    if not _is_seen(found):
        return MappedSurface.from_mesh(found.points, found.faces)
    star = StarSurface.from_points(found.points, found.center.tolist())
    # Accurate enough without comparison to a mapped surface.
    if star.misfit <= 1e-4 * star.mean_radius:
        return star
    try:
        mapped = MappedSurface.from_mesh(found.points, found.faces)
    except (InvalidMetric, InvalidParameter):  # degenerate triangles, or too few: the points are enough
        return star
    return mapped if mapped.misfit < 0.1 * star.misfit else star  # a mapped surface must fit ten times better


def _is_seen(found: CoordinateShape) -> bool:
    """Whether the triangles are star-shaped about the center."""
    arrows = found.points - found.center
    a, b, c = (arrows / np.abs(arrows).max())[found.faces].transpose(1, 0, 2)
    return bool((np.einsum("fi,fi->f", a, np.cross(b, c)) > 0.0).all())
