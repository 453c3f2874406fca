"""Strut tables in CSV as polyhedral metrics: hubs of each strut, lengths by strut or by type."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Indices
from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.text_scan import LONGEST
from isoembed.metric.precision import COARSE, PRECISION, common_unit

LENGTHS = ("length", "chord factor")
"""Columns of lengths: the first of these that a table has."""
ONE_DIGIT = 0.03
"""Standard deviation, in mean lengths, above which decimals have one digit only, and are exact."""
DECIMALS = re.compile(r"[+-]?\d*(?:\.(\d*))?")


class _Row(NamedTuple):
    line: int
    cells: dict[str, str]


def read(file: InputFile) -> Tables:
    """Read struts, their lengths, and the triangles that they make.

    A table with the columns ``from``, ``to``, and ``length`` or ``type`` has a row for each strut; one with
    ``type`` and ``length``, or ``chord factor``, has the lengths of types.  A blank line is between tables;
    other columns and tables are left aside.  Hubs are numbers or names.  Every three hubs that are joined are
    a triangle, unless they cut the frame in two.

    The errors of the lengths are those of the last digit that most have, the same in all, unless there is one
    length only, or they have so few or so many digits that they are exact.

    Raises
    ------
    FileError
        It is not a strut table: naming the line.
    InvalidMetric
        The struts are not a frame of triangles: naming the first strut.
    """
    struts, legend = [], {}
    for row in _rows(file):
        if "from" in row.cells and "to" in row.cells:
            struts.append(row)
        elif "type" in row.cells and (written := _written(row)):
            legend[row.cells["type"]] = row.line, written
    if not struts:
        raise FileError(
            f"{file} is not a strut table: it has no rows below a line with 'from', 'to', and 'type' or "
            "'length'"
        )
    lengths = []
    for row in struts:
        line, written = row.line, _written(row)
        if not written:
            kind = row.cells.get("type", "")
            if not kind and not {"type", *LENGTHS} & row.cells.keys():
                columns = ", ".join(row.cells)
                raise FileError(f"{file}, line {line}: no 'length' or 'type' is among the columns {columns}")
            if kind not in legend:
                raise FileError(
                    f"{file}, line {line}: the strut has no length, and its type {kind!r} has none"
                )
            line, written = legend[kind]
        lengths.append(_number(written, f"{file}, line {line}"))
    texts = [_written(row) or legend[row.cells["type"]][1] for row in struts]
    edges = _edges(struts, file)
    tables = {"faces": _triangles(edges, struts), "edges": edges, "lengths": np.array(lengths)}
    error = _error(texts, tables["lengths"])
    return {**tables, "length_errors": np.array(error)} if error else tables


def _rows(file: InputFile) -> Iterator[_Row]:
    """The rows of all tables below their headers, by the names of the columns."""
    lines = file.text.removeprefix("\ufeff").splitlines()
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    delimiter = next((sign for sign in ";\t" if sign in first), ",")
    header: list[str] = []
    for number, line in enumerate(lines, 1):
        try:
            cells = [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]
        except csv.Error as error:
            raise FileError(f"{file}, line {number}: {error}") from None
        if not any(cells) or cells[0].startswith("#"):
            header = [] if not any(cells) else header
        elif not header:
            header = [cell.lower() for cell in cells]
        else:
            named = dict(zip(header, cells, strict=False))
            if delimiter == ";":  # of spreadsheets whose decimal point is a comma
                named |= {name: named[name].replace(",", ".") for name in LENGTHS if name in named}
            yield _Row(number, named)


def _written(row: _Row) -> str:
    """The length in a row, as it is written; empty where there is none."""
    return next((row.cells[name] for name in LENGTHS if row.cells.get(name)), "")


def _number(written: str, where: str) -> float:
    try:
        value = float(written)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise FileError(f"{where}: the length is {written[:40]!r}, not a positive finite number")
    return value


def _edges(struts: list[_Row], file: InputFile) -> Indices:
    """The ends of the struts by numbers: as they are if these are all from 0 or from 1 on, or in order."""
    names = [row.cells[end] for row in struts for end in ("from", "to")]
    different = list(dict.fromkeys(names))
    for k, row in enumerate(struts):
        if not names[2 * k] or not names[2 * k + 1] or names[2 * k] == names[2 * k + 1]:
            raise FileError(
                f"{file}, line {row.line}: a strut is from {names[2 * k]!r} to {names[2 * k + 1]!r}"
            )
    are_numbers = all(name.isdecimal() and len(name) <= LONGEST for name in different)
    numbers = sorted(map(int, different)) if are_numbers else []
    first = numbers[0] if numbers else -1
    if first in (0, 1) and numbers == list(range(first, first + len(numbers))):
        place = {name: int(name) - first for name in different}
    else:
        place = {name: k for k, name in enumerate(different)}
    edges = np.array([place[name] for name in names]).reshape(-1, 2)
    seen: dict[frozenset[int], int] = {}
    for row, ends in zip(struts, map(frozenset, edges.tolist()), strict=True):
        if (before := seen.setdefault(ends, row.line)) != row.line:
            raise FileError(
                f"{file}, line {row.line}: the hubs {row.cells['from']} and {row.cells['to']} are joined in "
                f"line {before}, too"
            )
    return edges


def _triangles(edges: Indices, struts: Sequence[_Row]) -> Indices:
    """The triangles of a frame, turned alike."""
    beside: dict[int, set[int]] = {}
    for a, b in edges.tolist():
        beside.setdefault(a, set()).add(b)
        beside.setdefault(b, set()).add(a)
    ends = np.sort(edges, axis=1).tolist()
    found = [(a, b, c) for a, b in ends for c in sorted(beside[a] & beside[b]) if c > b]
    at = _by_sides(found)
    if any(len(some) > 2 for some in at.values()):
        doubtful = {f for some in at.values() if len(some) > 2 for f in some}
        found = [three for f, three in enumerate(found) if f not in doubtful or not _cuts(three, beside)]
        at = _by_sides(found)
    for (a, b), row in zip(edges.tolist(), struts, strict=True):
        count = len(at.get((min(a, b), max(a, b)), ()))
        strut = f"the strut between the hubs {row.cells['from']} and {row.cells['to']}"
        if count == 0:
            raise InvalidMetric(f"{strut} is in no triangle: lengths do not tell the shape")
        if count > 2:
            raise InvalidMetric(f"{strut} is in {count} triangles: give the faces, in .json")
    return np.array(_turned_alike(found, at))


def _by_sides(triangles: Iterable[tuple[int, int, int]]) -> dict[tuple[int, int], list[int]]:
    at: dict[tuple[int, int], list[int]] = {}
    for f, three in enumerate(triangles):
        for side in combinations(three, 2):
            at.setdefault(side, []).append(f)
    return at


def _cuts(three: Collection[int], beside: dict[int, set[int]]) -> bool:
    """Whether a frame falls apart without three hubs: then they are around a part of it, and no face."""
    left = beside.keys() - set(three)
    reached = [next(iter(left))] if left else []
    seen = set(reached)
    while reached:
        onward = beside[reached.pop()] & left - seen
        seen |= onward
        reached += onward
    return len(seen) < len(left)


def _turned_alike(
    triangles: list[tuple[int, int, int]], at: dict[tuple[int, int], list[int]]
) -> list[tuple[int, int, int]]:
    """Triangles turned so that two run along their common side in opposite directions."""
    turned = dict.fromkeys([0], triangles[0]) if triangles else {}
    reached = list(turned)
    for f in reached:
        a, b, c = turned[f]
        for p, q in ((a, b), (b, c), (c, a)):
            for g in at[min(p, q), max(p, q)]:
                if g not in turned:
                    [r] = set(triangles[g]) - {p, q}
                    turned[g] = (q, p, r)
                    reached.append(g)
    return [turned.get(f, three) for f, three in enumerate(triangles)]


def _error(written: Collection[str], lengths: np.ndarray) -> float:
    """Standard deviation of lengths from their last digit; 0 where they are taken as exact."""
    if len(set(written)) == 1:  # of one length, a triangle is regular, whatever its digits
        return 0.0
    decimals = [DECIMALS.fullmatch(word) for word in written]
    if any(found is None for found in decimals):  # in powers of ten
        return 0.0
    unit = common_unit(lengths, 10.0 ** -max(len(found[1] or "") for found in decimals if found))
    error = unit / math.sqrt(12)
    exact = unit < 10.0 ** (math.floor(math.log10(lengths.max())) + 1 - PRECISION.most)
    coarse = COARSE if unit == 1.0 else ONE_DIGIT  # small whole numbers are a design
    return 0.0 if exact or error > coarse * lengths.mean() else error


FORMAT = Format(".csv", read, None)
