"""Glued runs of polygon boundaries: parsing, checks, and subdivision at corners."""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing.polygon import Polygon, is_number
from isoembed.gluing.tolerance import ROUNDING, SAME_LENGTH, Tolerance, UnequalLengths


@dataclass(frozen=True)
class Run:
    """A part of the boundary of a polygon, counterclockwise.

    Attributes
    ----------
    polygon : int
    sheet : Polygon
        The polygon with this index.
    start, stop : float
        Positions, from 0 to below n; the entire boundary if they are equal.
    name : str
        Description in the user's terms, for messages.
    """

    polygon: int
    sheet: Polygon = field(compare=False, repr=False)
    start: float
    stop: float
    name: str = field(compare=False)

    @property
    def span(self) -> tuple[float, float]:
        """Arc lengths at start and stop; the stop continues past corner 0."""
        first, last = self.sheet.arc(self.start), self.sheet.arc(self.stop)
        return first, last if self.stop > self.start else last + self.sheet.perimeter

    @property
    def length(self) -> float:
        """Arc length of the run."""
        first, last = self.span
        return last - first

    def at(self, part: float) -> float:
        """Position at a fraction of the run's length."""
        return self.sheet.position(self.span[0] + part * self.length)

    def parts(self) -> tuple[list[float], list[float]]:
        """Positions of the ends and of the corners between them, and their fractions of the length."""
        n, (first, _) = self.sheet.n, self.span
        end = self.stop if self.stop > self.start else self.stop + n
        positions, along = [self.start], [0.0]
        for k in range(math.floor(self.start) + 1, math.ceil(end)):
            lap, corner = divmod(k, n)
            positions.append(float(corner))
            along.append((float(self.sheet.arcs[corner]) + lap * self.sheet.perimeter - first) / self.length)
        return [*positions, self.stop], [*along, 1.0]


def read_sides(
    sides: Sequence[Any], polygons: Sequence[Polygon], tolerance: Tolerance, any_surface: bool
) -> list[tuple[Run, Run]]:
    """Parse the identifications of `glue`, which must cover every boundary once (any surface: at most once).

    Parameters
    ----------
    sides : sequence of pairs
        Pairs of sides ``(p, k)`` or runs ``(p, a, b)``.
    polygons : sequence of Polygon
    tolerance : Tolerance
    any_surface : bool

    Returns
    -------
    list of pairs of Run
        Runs of equal length within the tolerance; the start of one is glued to the end of the other.  A run
        glued to itself is split into halves.

    Raises
    ------
    InvalidParameter
        An identification does not have this form, or refers to a nonexistent polygon or side.
    InvalidMetric
        Two runs differ in length, or part of a boundary is glued twice or not at all.
    """
    if not _is_list(sides):
        raise InvalidParameter(f"the sides are {_shown(sides)}, not a list of pairs")
    runs: list[tuple[Run, Run]] = []
    for i, pair in enumerate(sides):
        if not _is_list(pair) or len(pair) != 2:
            raise InvalidParameter(f"sides[{i}] is {_shown(pair)}, not a pair of sides or runs")
        runs.append((_read(pair[0], i, polygons), _read(pair[1], i, polygons)))
    runs = _joined(runs)
    _check_lengths(runs, tolerance)
    _check_cover(runs, polygons, any_surface)
    return [_folded(one, tolerance) if one == other else (one, other) for one, other in runs]


def cut(one: Run, other: Run, tolerance: Tolerance) -> tuple[list[float], list[float]]:
    """Positions on both runs of the corners of either, including the ends, in the order along the first."""
    same = slack(one, other, tolerance) / one.length
    here, along = one.parts()
    there, back = (part[::-1] for part in other.parts())
    ours, theirs = [here[0]], [there[0]]
    i, j = 1, 1
    while i < len(here) - 1 or j < len(there) - 1:
        ahead = along[i] - (1.0 - back[j])
        if i < len(here) - 1 and j < len(there) - 1 and abs(ahead) <= same:
            ours.append(here[i])
            theirs.append(there[j])
            i, j = i + 1, j + 1
        elif j == len(there) - 1 or (i < len(here) - 1 and ahead < 0):
            ours.append(here[i])
            theirs.append(other.at(1.0 - along[i]))
            i += 1
        else:
            ours.append(one.at(1.0 - back[j]))
            theirs.append(there[j])
            j += 1
    return [*ours, here[-1]], [*theirs, there[-1]]


def slack(one: Run, other: Run, tolerance: Tolerance) -> float:
    """Tolerance for the lengths of two runs."""
    sides = sum(len(run.parts()[0]) - 1 for run in (one, other))
    return tolerance.between(one.polygon, other.polygon, (one.length, other.length), sides)


def _read(entry: Any, i: int, polygons: Sequence[Polygon]) -> Run:
    if not _is_list(entry) or len(entry) not in (2, 3):
        raise InvalidParameter(
            f"sides[{i}] glues {_shown(entry)}, which is neither a side (polygon, side) "
            "nor a run (polygon, start, end)"
        )
    for value in entry:
        if not is_number(value) or not abs(value) <= sys.float_info.max:
            raise InvalidParameter(
                f"sides[{i}] glues {_shown(entry)}, where {value!r} is not a finite number"
            )
    p = entry[0]
    if p != int(p) or not 0 <= p < len(polygons):
        raise InvalidParameter(
            f"sides[{i}] glues {_shown(entry)}, but the polygons are numbered from 0 to {len(polygons) - 1}"
        )
    polygon = polygons[int(p)]
    if len(entry) == 2:
        k = entry[1]
        if k != int(k) or not 0 <= k < polygon.n:
            raise InvalidParameter(
                f"sides[{i}] glues {_shown(entry)}, but the sides of polygon {int(p)} are numbered "
                f"from 0 to {polygon.n - 1}"
            )
        a, b = float(k), float(k) + 1
        name = f"side {int(k)} of polygon {int(p)}"
    else:
        a, b = (_snapped(float(x), polygon, SAME_LENGTH * polygon.perimeter) for x in entry[1:])
        n = polygon.n
        if not (0 <= a <= n and 0 <= b <= 2 * n and b - a <= n):
            raise InvalidParameter(
                f"sides[{i}] glues {_shown(entry)}, but a run around polygon {int(p)} starts between "
                f"0 and {n} and is at most {n} long"
            )
        if abs(b - a) <= SAME_LENGTH and entry[1] != entry[2]:
            raise InvalidParameter(f"sides[{i}] glues {_shown(entry)}, which has no length")
        name = f"polygon {int(p)} from {entry[1]:.12g} to {entry[2]:.12g}"
    if polygon.turned:
        a, b = -b, -a
    return Run(int(p), polygon, a % polygon.n, b % polygon.n, name)


def _joined(runs: list[tuple[Run, Run]]) -> list[tuple[Run, Run]]:
    """Merge endpoints whose positions are equal up to rounding."""
    ends: dict[int, list[float]] = {}
    for run in (run for pair in runs for run in pair):
        ends.setdefault(run.polygon, []).extend((run.start, run.stop))
    same: dict[tuple[int, float], float] = {}
    for p, positions in ends.items():
        last = -1.0
        for position in sorted(positions):
            if position - last > SAME_LENGTH:
                last = position
            same[p, position] = last

    def joined(run: Run) -> Run:
        return replace(run, start=same[run.polygon, run.start], stop=same[run.polygon, run.stop])

    return [(joined(one), joined(other)) for one, other in runs]


def _check_lengths(runs: list[tuple[Run, Run]], tolerance: Tolerance) -> None:
    def allowed(one: Run, other: Run) -> float:
        return slack(one, other, tolerance) + ROUNDING * (one.sheet.perimeter + other.sheet.perimeter)

    differences = [abs(one.length - other.length) for one, other in runs]
    wrong = [i for i, pair in enumerate(runs) if differences[i] > allowed(*pair)]
    if wrong:
        one, other = runs[wrong[0]]
        raise UnequalLengths(
            f"sides[{wrong[0]}] glues {one.name}, of length {one.length!r}, to {other.name}, of length "
            f"{other.length!r}: more than the {tolerance.limit_text(allowed(one, other))}",
            max(differences),
        )


def _check_cover(runs: list[tuple[Run, Run]], polygons: Sequence[Polygon], any_surface: bool) -> None:
    """Raise an error if a part is glued twice or, unless a boundary is permitted, not at all."""
    for p, polygon in enumerate(polygons):
        own = [(i, run) for i, pair in enumerate(runs) for run in dict.fromkeys(pair) if run.polygon == p]
        stops = sorted({x for _, run in own for x in (run.start, run.stop)})
        if not own and not any_surface:
            raise InvalidMetric(f"polygon {p} is glued to nothing: any_surface permits a boundary")
        place = {x: k for k, x in enumerate(stops)}
        glued = [-1] * len(stops)  # identification that glues the part from each stop to the next
        for i, run in own:
            k, last = place[run.start], place[run.stop]
            while True:
                if glued[k] >= 0:
                    by = f"sides[{i}]" if glued[k] == i else f"sides[{glued[k]}] and by sides[{i}]"
                    raise InvalidMetric(f"{_stretch(p, polygon, stops, k)} is glued twice, by {by}")
                glued[k] = i
                k = (k + 1) % len(stops)
                if k == last:
                    break
        if -1 in glued and not any_surface:
            part = _stretch(p, polygon, stops, glued.index(-1))
            raise InvalidMetric(f"{part} is glued to nothing: any_surface permits a boundary")


def _stretch(p: int, polygon: Polygon, stops: list[float], k: int) -> str:
    """Description for messages of the boundary between consecutive stops."""
    a, b = stops[k], stops[(k + 1) % len(stops)]
    if polygon.turned:
        a, b = -b % polygon.n, -a % polygon.n
    if a == int(a) and b == (a + 1) % polygon.n:
        return f"side {int(a)} of polygon {p}"
    return f"the boundary of polygon {p} from {a:.12g} to {b:.12g}"


def _folded(run: Run, tolerance: Tolerance) -> tuple[Run, Run]:
    """Halves of a run."""
    off = max(slack(run, run, tolerance) / 2, SAME_LENGTH * run.sheet.perimeter)
    middle = _snapped(run.at(0.5), run.sheet, off) % run.sheet.n
    return replace(run, stop=middle), replace(run, start=middle)


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple | np.ndarray)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _snapped(position: float, polygon: Polygon, tolerance: float) -> float:
    """Nearest corner, if the position is close enough; otherwise the position."""
    side = math.floor(position) % polygon.n
    off = abs(position - round(position)) * (polygon.arcs[side + 1] - polygon.arcs[side])
    return float(round(position)) if off <= tolerance else position
