"""Horizons, from files or found: their data in the slice, and what the file and the expansion say of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from isoembed.errors import InvalidParameter
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.coordinate_surface import coordinate_surface
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.expansion import expansion_test, judged
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.reprs import short_repr

GivenHorizon = CoordinateShape | SurfaceData | Surface | FoundHorizon
"""What a horizon is made of."""


@short_repr
@dataclass(frozen=True)
class Horizon:
    """Surface in its slice, from a file or found.

    Attributes
    ----------
    data : SurfaceData
    facts : dict
        What the file or the finder, and the expansion say of it as a horizon, for JSON; empty of a metric
        without k.
    curvature_check : CurvatureCheck or None
        How far the curvature in the file is from that of the metric in use, where the file has it.
    """

    data: SurfaceData
    facts: dict[str, Any]
    curvature_check: CurvatureCheck | None = None

    @classmethod
    def of(
        cls,
        found: GivenHorizon,
        geometry: ThreeGeometry | None = None,
        *,
        axis: Sequence[float] | None = None,
        marginal: bool | None = None,
        name: str = "",
    ) -> Horizon:
        """The surface that a file holds, or that was found.

        Parameters
        ----------
        found : CoordinateShape, SurfaceData, StarSurface, MappedSurface or FoundHorizon
            From `isoembed.relativity.read_horizon` or `isoembed.relativity.find_horizon`, for one.
        geometry : ThreeGeometry, optional
            The slice; a grid has its metric, what was found its slice, coordinates and surfaces need one.
        axis : sequence of 3 floats, optional
            That the angular momentum is asked about, in the coordinates of a slice, besides the one that is
            found.
        marginal : bool, optional
            Whether it is a horizon; by default `expansion_test` decides, and a metric without k is none.
        name : str

        Raises
        ------
        InvalidParameter
            The geometry is missing, or there is a metric already; there is an axis without coordinates; or
            the points are not star-shaped and there are no triangles.
        """
        if isinstance(found, SurfaceData | FoundHorizon):
            if geometry is not None:
                raise InvalidParameter(f"{name or 'this'} holds a metric of its own: it needs no geometry")
            of = _with_metric if isinstance(found, SurfaceData) else _found
            return of(found, axis, marginal, name)  # type: ignore[arg-type] # as it is asked
        if geometry is None:
            contents = getattr(found, "contents", f"{name or 'this'} is a surface in coordinates")
            raise InvalidParameter(f"{contents}: name its geometry")
        surface = found if isinstance(found, Surface) else coordinate_surface(found)
        data = surface.data(geometry, axis, name=name)
        test = expansion_test(data)
        data = judged(data, marginal, test)
        facts = {
            "center": list(surface.center),
            **{"mean_coordinate_radius": surface.mean_radius, "misfit": surface.misfit},
            **test.report,
            "marginal": data.marginal,
        }
        if isinstance(found, Surface):
            return cls(data, facts, CurvatureCheck.of(data))
        of_file = {"time": found.time, "iteration": found.iteration, "points": len(found.points)}
        directions = surface.directions if isinstance(surface, MappedSurface) else None
        return cls(data, of_file | facts, CurvatureCheck.of(data, found, directions))


def _with_metric(
    found: SurfaceData, axis: Sequence[float] | None, marginal: bool | None, name: str
) -> Horizon:
    if axis is not None:
        raise InvalidParameter(f"{name} holds no coordinates that an axis could be given in")
    test = None if found.mean_curvature is None else expansion_test(found)
    data = judged(replace(found, name=name), marginal, test)
    facts = {**test.report, "marginal": data.marginal} if test else {}
    return Horizon(data, facts, CurvatureCheck.of(data))


def _found(found: FoundHorizon, axis: Sequence[float] | None, marginal: bool | None, name: str) -> Horizon:
    data = found.data(axis, name)
    test = expansion_test(data)
    if marginal is not None:
        data = judged(data, marginal, test)
    facts = {
        **{"center": list(found.surface.center), "mean_coordinate_radius": found.surface.mean_radius},
        **{"degree": found.degree, "residual": found.residual},
        **{"stability": found.stability, "outer": found.outer},
        "outermost": None if found.outermost is None else found.outermost.report,
        **test.report,
        "marginal": data.marginal,
    }
    return Horizon(data, facts)
