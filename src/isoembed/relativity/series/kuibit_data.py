"""Horizons and grid data from kuibit objects.

Used are the public attributes of ``OneHorizon``, ``HierarchicalGridData`` and ``UniformGridData`` of kuibit
1.4 or later [1]_, which need not be installed to read this.

References
----------
.. [1] G. Bozzola, "kuibit: Analyzing Einstein Toolkit simulations with Python", Journal of Open Source
   Software 6 (2021), 3099.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.horizons.ahfinderdirect import shape_of_patches
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.series.grid_symmetry import IDENTITY, AxisMap
from isoembed.relativity.series.refined_grid import Component, covering_grid
from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid
from isoembed.relativity.spacetimes.slice_file import GAMMA, K


def kuibit_shape(horizon: Any, iteration: int, name: str = "") -> CoordinateShape:
    """Shape of a horizon of kuibit.

    Parameters
    ----------
    horizon : kuibit.cactus_horizons.OneHorizon
        Horizon, for example from ``sim.horizons.get_apparent_horizon(1)``.
    iteration : int
    name : str, optional
        Name of the horizon.

    Raises
    ------
    InvalidParameter
        The horizon has no shape at that iteration.
    FileError
        The shape is not a closed surface.
    """
    try:
        origin = np.array(horizon.ah_origin_at_iteration(iteration), dtype=np.float64)
        patches = zip(*horizon.shape_at_iteration(iteration), strict=True)
    except ValueError as error:
        raise InvalidParameter(f"the horizon of kuibit has no shape: {error}") from None
    source = f"{name or 'the horizon'} of kuibit at iteration {iteration}"
    arrows = {}
    for patch in patches:
        arrow = np.stack([np.ravel(x) for x in patch], axis=1) - origin
        middle = arrow.mean(axis=0)
        axis = int(np.argmax(np.abs(middle)))
        arrows["+-"[int(middle[axis] < 0)] + "xyz"[axis]] = arrow
    return replace(shape_of_patches(origin, arrows, source), name=name, iteration=iteration)


@dataclass(frozen=True)
class GridDataSlice:
    """Slice from grid data of kuibit in memory, a `SliceSource`.

    Parts that symmetric runs omit are missing: kuibit's ``reflection_symmetry_undo`` and
    ``rotation180_symmetry_undo`` complete grid data.  Data of CarpetX have their axes the wrong way around in
    kuibit 1.6.1: its files are read by `isoembed.relativity.series.carpetx`.

    Attributes
    ----------
    fields : mapping of str to kuibit.grid_data.HierarchicalGridData or UniformGridData
        ``gxx ... gzz`` and ``kxx ... kzz``; without the latter the slice is treated as time-symmetric.
    """

    fields: Mapping[str, Any]

    def __post_init__(self) -> None:
        for name in self.fields:
            if name not in (*GAMMA, *K):
                raise InvalidParameter(f"{name!r} is not one of the fields gxx ... gzz and kxx ... kzz")
            for part in _parts(self.fields[name]):
                if not hasattr(part, "ghost_zones_removed") or np.ndim(part.data) != 3:
                    raise InvalidParameter(
                        f"{name} is a {type(part).__name__}, not data of kuibit on a three-dimensional grid"
                    )

    @property
    def name(self) -> str:
        """Name of the data."""
        return "grid data of kuibit"

    def digest(self) -> str:
        """Hash of all points and values."""
        sha = hashlib.sha256()
        for name in sorted(self.fields):
            for part in _parts(self.fields[name]):
                data = np.ascontiguousarray(part.data, dtype=np.float64)
                place = [np.asarray(x).tolist() for x in (part.x0, part.dx, part.num_ghost)]
                sha.update(repr((name, part.ref_level, data.shape, place)).encode())
                sha.update(data.data)
        return sha.hexdigest()

    def read(self, low: Floats, high: Floats) -> CartesianGrid:
        """Finest refinement level that covers the box; see `covering_grid`.

        Raises `FileError`: fields are missing, or no level covers the box.
        """
        wanted = (*GAMMA, *K) if any(name in self.fields for name in K) else GAMMA
        return covering_grid(_GridData(self.name, self.fields), low, high, wanted)


class _GridData:
    """Grid data of kuibit as `RefinedData`."""

    def __init__(self, name: str, fields: Mapping[str, Any]) -> None:
        self.name, self.fields = name, list(fields)
        self.symmetry: tuple[AxisMap, ...] = (IDENTITY,)
        self._fields = fields
        self._parts: dict[tuple[str, int], list[Any]] = {}

    @cached_property
    def levels(self) -> list[int]:
        return sorted(
            set.intersection(
                *({int(part.ref_level) for part in _parts(field)} for field in self._fields.values())
            )
        )

    def components(self, level: int) -> list[Component]:
        return [
            Component.of(k, part.x0, part.dx, part.shape)
            for k, part in enumerate(self._level(GAMMA[0], level))
        ]

    def values(self, field: str, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        there = self._level(field, level)
        if len(there) <= component.key or tuple(there[component.key].shape) != component.shape:
            raise InvalidParameter(f"{field} and gxx are not on the same points of refinement level {level}")
        return np.asarray(there[component.key].data[part], dtype=np.float64)

    def _level(self, field: str, level: int) -> list[Any]:
        """Parts of a field without their ghost zones."""
        key = field, level
        if key not in self._parts:
            self._parts[key] = [
                part.ghost_zones_removed()
                for part in _parts(self._fields[field])
                if int(part.ref_level) == level
            ]
        return self._parts[key]


def _parts(data: Any) -> list[Any]:
    """Uniform grids of grid data of kuibit."""
    return list(getattr(data, "all_components", [data]))
