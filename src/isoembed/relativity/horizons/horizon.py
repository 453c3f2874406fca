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
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


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
        found: CoordinateShape | SurfaceData,
        geometry: ThreeGeometry | None = None,
        *,
        axis: Sequence[float] | None = None,
        marginal: bool | None = None,
        name: str = "",
    ) -> Horizon:
        """The surface that a file holds.

        Parameters
        ----------
        found : CoordinateShape or SurfaceData
            From `isoembed.relativity.read_horizon`.
        geometry : ThreeGeometry, optional
            The slice; a grid has its metric, coordinates need one.
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
        if isinstance(found, SurfaceData):
            if geometry is not None:
                raise InvalidParameter(f"{name} holds a metric of its own: it needs no geometry")
            if axis is not None:
                raise InvalidParameter(f"{name} holds no coordinates that an axis could be given in")
            test = None if found.mean_curvature is None else expansion_test(found)
            data = judged(replace(found, name=name), marginal, test)
            facts = {**test.report, "marginal": data.marginal} if test else {}
            return cls(data, facts, CurvatureCheck.of(data))
        if geometry is None:
            raise InvalidParameter(f"{found.contents}: name its geometry")
        surface = coordinate_surface(found)
        data = surface.data(geometry, axis, name=name)
        test = expansion_test(data)
        data = judged(data, marginal, test)
        facts = {
            **{"time": found.time, "iteration": found.iteration},
            **{"points": len(found.points), "center": list(surface.center)},
            **{"mean_coordinate_radius": surface.mean_radius, "misfit": surface.misfit},
            **test.report,
            "marginal": data.marginal,
        }
        directions = surface.directions if isinstance(surface, MappedSurface) else None
        return cls(data, facts, CurvatureCheck.of(data, found, directions))

    @classmethod
    def found(cls, found: FoundHorizon, *, axis: Sequence[float] | None = None, name: str = "") -> Horizon:
        """The surface that was found in a slice.

        Parameters
        ----------
        found : FoundHorizon
            From `isoembed.relativity.find_horizon`.
        axis : sequence of 3 floats, optional
            As of `of`.
        name : str
        """
        data = found.data(axis, name)
        facts = {
            **{"center": list(found.surface.center), "mean_coordinate_radius": found.surface.mean_radius},
            **{"degree": found.degree, "residual": found.residual},
            **{"stability": found.stability, "outer": found.outer},
            **expansion_test(data).report,
            "marginal": data.marginal,
        }
        return cls(data, facts)
