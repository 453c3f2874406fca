"""Horizon test: whether the expansion of outgoing light rays vanishes on a surface from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class HorizonThresholds:
    """Thresholds of the horizon test."""

    nodes: tuple[int, int] = threshold((48, 96), "count", "Heights and angles at which a surface is tested.")
    marginal: float = threshold(
        0.1, "over the mean radius", "Expansion below which it is a horizon; a sphere in flat space has 2."
    )


HORIZON = HorizonThresholds()


def expansion_test(surface: StarSurface, geometry: ThreeGeometry) -> dict[str, Any]:
    """Test whether a surface is a horizon of a slice.

    Returns
    -------
    dict
        The ``mean_coordinate_radius``; the ``largest_expansion`` of outgoing light rays in absolute value, 0
        on a horizon; and ``marginal``, whether that is so small that the surface is one: a horizon that was
        found on a coarse grid is, what expands like a sphere in flat space is not.
    """
    u, weights = gauss_rule(*HORIZON.nodes)
    mean = float(np.average(surface.radius(u), weights=weights))
    expansion = float(np.abs(surface.expansion(geometry, u)).max())
    return {
        "mean_coordinate_radius": mean,
        "largest_expansion": expansion,
        "marginal": expansion * mean < HORIZON.marginal,
    }


@dataclass(frozen=True)
class Horizon:
    """Surface from a file in its slice.

    Attributes
    ----------
    data : SurfaceData
    facts : dict
        What the file and the expansion say of it as a horizon, for JSON; empty of a metric on a grid.
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
            That the angular momentum is asked about; by default it is found.
        name : str

        Raises
        ------
        InvalidParameter
            The geometry is missing, or there is a metric already.
        """
        if isinstance(found, SurfaceData):
            if geometry is not None:
                raise InvalidParameter(f"{name} holds a metric of its own: it needs no geometry")
            return cls(replace(found, marginal=True, name=name), {}, CurvatureCheck.of(found))
        if geometry is None:
            raise InvalidParameter(f"{found.contents}: name its geometry")
        surface = StarSurface.from_points(
            found.points, found.center.tolist(), found.faces if found.is_hull else None
        )
        data, test = surface.data(geometry, axis, name=name), expansion_test(surface, geometry)
        facts = {
            **{"time": found.time, "iteration": found.iteration},
            **{"points": len(found.points), "center": list(found.center)},
            "mean_coordinate_radius": test["mean_coordinate_radius"],
            **{"misfit": surface.misfit, **test},
        }
        check = CurvatureCheck.of(data, found)
        return cls(replace(data, marginal=test["marginal"]), facts, check)
