"""Scenes of a simulation: the horizons, embedded or lost, at one time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.plot.series.abscissa import Abscissa
from isoembed.plot.series.placing import PlacedHorizon, PlacedHorizons
from isoembed.relativity.series.table import Row


@dataclass(frozen=True, eq=False)
class Scene:
    """The horizons of a run at one time.

    Attributes
    ----------
    moment : str
        Text of the time.
    shown : tuple of PlacedHorizon
        Embedded horizons in the order of the series.
    missing : tuple of Row
        Rows at this time of horizons that are not embedded.
    """

    moment: str
    shown: tuple[PlacedHorizon, ...]
    missing: tuple[Row, ...]

    @property
    def shells(self) -> tuple[PlacedHorizon, ...]:
        """Horizons that enclose others, and are drawn translucent, from the innermost outward."""
        found = [one for one in self.shown if any(one.holds(other) for other in self.shown)]
        return tuple(sorted(found, key=lambda one: one.radius))


def scenes(placed: PlacedHorizons) -> tuple[Scene, ...]:
    """Scenes of a run, from its first to its last embedded horizon.

    There is one scene for each time in any series; series with fewer times are represented by their nearest
    row.
    """
    along = Abscissa.of(placed.table)
    tracks = [_Track.of(along.of_series(part), part.rows) for part in placed.table.series.values()]
    times = np.unique(np.concatenate([track.times for track in tracks])) if tracks else np.empty(0)
    found = list[Scene]()
    for at, moment in zip(times.tolist(), along.written(times), strict=True):
        rows = [row for track in tracks if (row := track.nearest(at)) is not None]
        shown = tuple(placed.horizons[row.label] for row in rows if row.label in placed.horizons)
        missing = tuple(row for row in rows if row.label not in placed.horizons)
        found.append(Scene(moment, shown, missing))
    there = [k for k, scene in enumerate(found) if scene.shown]
    return tuple(found[there[0] : there[-1] + 1]) if there else ()


def joined(horizons: Sequence[PlacedHorizon]) -> tuple[Floats, Indices]:
    """Vertices (V, 3) and faces (F, 3) of several horizons as one mesh."""
    first = np.cumsum([0] + [len(one.vertices) for one in horizons])
    faces = [one.faces + k for one, k in zip(horizons, first, strict=False)]
    return (
        np.concatenate([one.vertices for one in horizons] or [np.empty((0, 3))]),
        np.concatenate(faces or [np.empty((0, 3), dtype=np.int64)]),
    )


def evenly(shown: Sequence[Scene], count: int) -> tuple[Scene, ...]:
    """Select at most `count` evenly spaced scenes, including the first and the last."""
    chosen = np.rint(np.linspace(0, len(shown) - 1, min(count, len(shown)))).astype(int)
    return tuple(shown[k] for k in chosen.tolist())


@dataclass(frozen=True, eq=False)
class _Track:
    """Rows of a series with their times."""

    times: Floats
    rows: tuple[Row, ...]
    lasting: float

    @classmethod
    def of(cls, times: Floats, rows: Iterable[Row]) -> _Track:
        finite = np.isfinite(times)
        there = tuple(row for row, yes in zip(rows, finite, strict=True) if yes)
        steps = np.diff(times[finite])
        # A horizon is shown for half a spacing before and after its own time.
        lasting = 0.5 * float(np.median(steps)) if steps.size else 0.0
        return cls(times[finite], there, (1.0 + 1e-9) * lasting)  # allows for rounding of equal spacings

    def nearest(self, at: float) -> Row | None:
        """Nearest row in time, unless it is too far."""
        if not self.rows:
            return None
        k = int(np.argmin(np.abs(self.times - at)))
        return self.rows[k] if abs(self.times[k] - at) <= self.lasting else None
