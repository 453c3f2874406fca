"""Matching of horizons with slices, by iteration if both have one, otherwise by time."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.relativity.series.file_names import natural_order
from isoembed.relativity.series.moment import ListedSlice, Moment
from isoembed.relativity.series.source import MissingSlice, SliceSource

SAME_TIME = 1e-9  # relative difference of equal times


def matched(shapes: Iterable[Moment], slices: Iterable[ListedSlice[SliceSource]]) -> list[Moment]:
    """Moments of horizons with their slices.

    Raises `InvalidParameter`: two horizons have the same series and moment, or two slices the same moment.

    Parameters
    ----------
    shapes : iterable of Moment
        Horizons without their slices.
    slices : iterable of ListedSlice

    Returns
    -------
    list of Moment
        Moments in the order of `ordered`.  A horizon without a slice has a `MissingSlice`.
    """
    shapes = list(shapes)
    times: dict[str, list[float]] = {}
    for shape in shapes:
        if shape.time is not None:
            times.setdefault(shape.series, []).append(shape.time)
    candidates = _Slices(list(slices), times.values())
    return ordered([replace(shape, slice=candidates.of(shape)) for shape in shapes])


def ordered(moments: Iterable[Moment]) -> list[Moment]:
    """Moments sorted by series, then by time if all have one, otherwise by iteration.

    Raises `InvalidParameter`: two moments have the same label.
    """
    by_series: dict[str, list[Moment]] = {}
    for moment in moments:
        by_series.setdefault(moment.series, []).append(moment)
    out: list[Moment] = []
    for series in sorted(by_series, key=natural_order):
        there = by_series[series]
        key = next(
            (
                name
                for name in ("time", "iteration", "position")
                if all(getattr(moment, name) is not None for moment in there)
            ),
            None,
        )
        out += sorted(there, key=lambda moment: getattr(moment, key)) if key else there
    labels: dict[str, Moment] = {}
    for moment in out:
        if (other := labels.setdefault(moment.label, moment)) is not moment:
            raise InvalidParameter(
                f"{other.shape.name} and {moment.shape.name} are both {_when(moment)}: keep one"
            )
    return out


class _Slices:
    """Slices by their iterations and times."""

    def __init__(
        self, slices: Sequence[ListedSlice[SliceSource]], of_series: Iterable[Sequence[float]]
    ) -> None:
        self.count = len(slices)
        self.by_iteration: dict[int, SliceSource] = {}
        self._dates: dict[int, float] = {}
        timed: list[tuple[float, SliceSource]] = []
        for listed in slices:
            if listed.iteration is not None:
                other = self.by_iteration.setdefault(listed.iteration, listed.source)
                if other is not listed.source:
                    _refuse(other, listed.source, f"iteration {listed.iteration}")
            if listed.time is not None and listed.iteration is not None:
                self._dates[listed.iteration] = listed.time
            if listed.time is not None:
                timed.append((listed.time, listed.source))
        timed.sort(key=lambda pair: pair[0])
        self.times = np.array([time for time, _ in timed])
        self.sources = [source for _, source in timed]
        self.room = _room([self.times, *map(np.array, of_series)])
        if not self.by_iteration:
            near = np.flatnonzero(np.diff(self.times) <= SAME_TIME * _largest(self.times))
            for k in near[:1].tolist():
                _refuse(self.sources[k], self.sources[k + 1], f"t = {self.times[k]:.9g}")

    def of(self, shape: Moment) -> SliceSource:
        """Slice of a horizon, or a `MissingSlice`."""
        if shape.iteration is not None and self.by_iteration:
            date = self._dates.get(shape.iteration)
            if date is not None and shape.time is not None and abs(date - shape.time) > self.room:
                return MissingSlice(
                    f"{_when(shape)} ({shape.shape.name}) is at t = {shape.time:.9g}, but the slice of this "
                    f"iteration, {self.by_iteration[shape.iteration].name}, is at t = {date:.9g}"
                )
            return self.by_iteration.get(shape.iteration) or self._missing(shape)
        if shape.time is not None and len(self.times):
            nearest = int(np.argmin(np.abs(self.times - shape.time)))
            if abs(self.times[nearest] - shape.time) <= self.room:
                return self.sources[nearest]
        return self._missing(shape)

    def _missing(self, shape: Moment) -> MissingSlice:
        by_time = shape.time is not None and len(self.times) and not self.by_iteration
        when = f"{shape.series} at t = {shape.time:.9g}" if by_time else _when(shape)
        here = f"no slice for {when} ({shape.shape.name})"
        if self.count == 0:
            return MissingSlice(f"there is {here}: there are no slices")
        there = [
            *([f"iterations {_range(sorted(self.by_iteration))}"] if self.by_iteration else []),
            *([f"t = {_range(self.times.tolist())}"] if len(self.times) else []),
        ]
        reason = (
            f"slices are at {' and '.join(there)}" if there else "the slices have neither iteration nor time"
        )
        return MissingSlice(f"there is {here}: {reason}")


def _refuse(one: SliceSource, other: SliceSource, when: str) -> None:
    raise InvalidParameter(f"{one.name} and {other.name} are both slices of {when}: keep one")


def _room(lists: Sequence[np.ndarray]) -> float:
    """Tolerance for equal times, from lists of times, one for each file."""
    scale = max(_largest(times) for times in lists)
    steps = np.concatenate([np.diff(np.unique(times)) for times in lists])
    steps = steps[steps > SAME_TIME * scale]
    # Printed times of one moment may differ by 2 % of the least step.
    return float(max(SAME_TIME * scale, 0.02 * steps.min(initial=np.inf) if len(steps) else 0.0))


def _largest(times: np.ndarray) -> float:
    return float(np.max(np.abs(times), initial=0.0))


def _range(values: Sequence[float]) -> str:
    """A few numbers in words."""
    if len(values) <= 4:
        return ", ".join(f"{value:.9g}" for value in values)
    return f"{values[0]:.9g}, {values[1]:.9g}, ..., {values[-1]:.9g} ({len(values)} of them)"


def _when(moment: Moment) -> str:
    if moment.iteration is not None:
        return f"{moment.series} at iteration {moment.iteration}"
    return moment.series if moment.time is None else f"{moment.series} at t = {moment.time:.9g}"
