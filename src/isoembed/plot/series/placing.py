"""Placement of embedded horizons at their centers in the slice, with rotations continuous in time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.io.npz import with_prefix
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity.series.table import AXIS, Row, SeriesTable
from isoembed.runs.result import Result
from isoembed.smooth.start import SURFACE, Start
from isoembed.surface.alignment import best_rotation

FIELD, IN_SLICE = "field/", "slice_coordinates"


@dataclass(frozen=True, eq=False)
class PlacedHorizon:
    """An embedded horizon placed in space.

    Attributes
    ----------
    row : Row
        Row of the table.
    vertices : ndarray, shape (V, 3)
        Vertices around the ``center``.
    faces : ndarray of int, shape (F, 3)
    fields : mapping of str to ndarray
        Vertex data, (V,) or (V, k).
    center : ndarray, shape (3,)
        Center, in the unit of the lengths.
    axis : ndarray, shape (3,), or None
        Spin axis, if known.
    """

    row: Row
    vertices: Floats
    faces: Indices
    fields: Mapping[str, NDArray[Any]]
    center: Floats
    axis: Floats | None

    @property
    def radius(self) -> float:
        """Largest distance of a vertex from the center."""
        return float(np.linalg.norm(self.vertices - self.center, axis=1).max())

    def holds(self, other: PlacedHorizon) -> bool:
        """Whether the center of a smaller horizon lies inside."""
        toward, own = other.center - self.center, self.vertices - self.center
        sizes = np.linalg.norm(own, axis=1)
        size = sizes[np.argmax(own @ toward / sizes)]
        return other.radius < self.radius and float(np.linalg.norm(toward)) < size


@dataclass(frozen=True, eq=False)
class PlacedHorizons:
    """Embedded horizons of a run, placed in space.

    Attributes
    ----------
    table : SeriesTable
        Table of all horizons, including those not embedded.
    horizons : mapping of str to PlacedHorizon
        Placed horizons by label.
    stretch : float
        Factor of the distances between centers relative to slice coordinates: the ratio of areal to mean
        coordinate radius for the largest horizon, which approximately preserves enclosure.
    """

    table: SeriesTable
    horizons: Mapping[str, PlacedHorizon]
    stretch: float

    @property
    def note(self) -> str:
        """Note about the scaling of distances, if they differ from coordinate distances."""
        if abs(self.stretch - 1.0) <= 0.05:  # invisible in a picture
            return ""
        return f"distances of centers: coordinates \N{MULTIPLICATION SIGN} {self.stretch:.2f}"

    @classmethod
    def of(cls, results: Iterable[Result], fields: Collection[str] | None = None) -> PlacedHorizons:
        """Place the embedded horizons of a run.

        A horizon whose points in its slice are known is oriented as there; others are aligned with their
        predecessor in the series.  Horizons without a center are placed side by side.

        Parameters
        ----------
        results : iterable of Result
            Results in any order.
        fields : collection of str, optional
            Vertex data to keep; by default all.
        """
        reduced = [_without(result, fields) for result in results]
        table = SeriesTable.of(reduced)
        there = {result.label: result for result in reduced if result.answered}
        ratios = [pair for result in there.values() if (pair := _ratio(result.report)) is not None]
        _, stretch = max(ratios, default=(0.0, 1.0))
        radii = [np.linalg.norm(result.arrays["vertices"], axis=1).max() for result in there.values()]
        # Distance, in radii, between horizons with unknown centers.
        apart, parts = 2.5 * float(max(radii, default=0.0)), table.series
        horizons = dict[str, PlacedHorizon]()
        for k, part in enumerate(parts.values()):
            aside = np.array([(k - 0.5 * (len(parts) - 1)) * apart, 0.0, 0.0])
            before: Floats | None = None
            for row in part.rows:
                if (result := there.get(row.label)) is not None:
                    turn, before = _turn(result.arrays, before)
                    center = _horizon(result.report).get("center")
                    place = aside if center is None else stretch * np.array(center)
                    horizons[row.label] = _placed(row, result.arrays, turn, place)
        return cls(table, horizons, stretch)


def _without(result: Result, fields: Collection[str] | None) -> Result:
    """Result with only the given vertex data."""
    if fields is None:
        return result
    names = {FIELD + name for name in fields}
    arrays = {
        name: array
        for name, array in result.arrays.items()
        if not name.startswith(FIELD) or name in names or name == FIELD + IN_SLICE
    }
    return Result(result.label, result.status, result.report, arrays)


def _horizon(report: Mapping[str, Any]) -> Mapping[str, Any]:
    return report.get("horizon") or {}


def _ratio(report: Mapping[str, Any]) -> tuple[float, float] | None:
    """Areal radius of a horizon, and its ratio to the mean coordinate radius."""
    area, mean = report.get("area"), _horizon(report).get("mean_coordinate_radius")
    if not area or not mean:
        return None
    radius = float(np.sqrt(area / (4.0 * np.pi)))
    return radius, radius / mean


def _turn(arrays: Mapping[str, NDArray[Any]], before: Floats | None) -> tuple[Floats, Floats | None]:
    """Rotation that aligns a surface with its predecessor, and the rotated reference points."""
    if f"{SURFACE}/degrees" not in arrays or FIELD + IN_SLICE in arrays:
        return np.eye(3), before
    # Directions of the reference points.
    start, u = Start.restored(arrays), fibonacci_directions(500)
    own = u if start.coordinates is None else start.coordinates.inverse(u)
    points = start.harmonics.derivatives(own, start.coefficients)[0]
    turn = np.eye(3) if before is None else best_rotation(points, before)
    return turn, points @ turn


def _placed(row: Row, arrays: Mapping[str, NDArray[Any]], turn: Floats, center: Floats) -> PlacedHorizon:
    fields = with_prefix(arrays, FIELD)
    has_axis = AXIS[0] in row.numbers
    axis = np.array([row.numbers[name] for name in AXIS]) @ turn if has_axis else None
    return PlacedHorizon(row, arrays["vertices"] @ turn + center, arrays["faces"], fields, center, axis)
