"""Strut tables in CSV as polyhedral metrics: hubs, lengths by strut or by type, decimal signs."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import combinations, zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, warn_of_mesh
from isoembed.io.files import FileError, Tables, printable
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.text_scan import LONGEST
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.precision import COARSE, PRECISION, common_unit
from isoembed.metric.triangle_checks import first_broken, within_inequalities
from isoembed.metric.wrong_length import wrong_length_clause
from isoembed.space import EUCLIDEAN
from isoembed.typed_numbers import MILLIMETERS, split_unit, ungrouped

LENGTHS = ("length", "chord factor")
"""Columns of lengths: the first of these that a table has."""
ERRORS = ("length error", "error", "sigma", "standard deviation")
"""Columns of standard deviations of the lengths: the first of these that a table has."""
UNIT = re.compile(r"\s*[(\[]([^()\[\]]*)[)\]]$")
"""A unit behind the name of a column, as in ``length (mm)``."""
UNITS = MILLIMETERS | {
    **{
        f"{prefix}met{end}": size
        for prefix, size in (("milli", 1.0), ("centi", 10.0), ("", 1000.0))
        for end in ("er", "ers", "re", "res")  # British spelling, too
    },
    **dict.fromkeys(("inch", "inches"), 25.4),
    **dict.fromkeys(("ft", "foot", "feet"), 304.8),
}
"""Known units of columns, in millimeters; others may be comments or numbers of pieces."""
OWN_UNIT = "unit", "units"
"""Columns that may have units of the lengths: the first of these that a table has."""
FRACTION = re.compile(r"(?:(\d{1,9})[ -])?(\d{1,9})/([1-9]\d{0,8})(?![\d/])")  # 3 1/2
NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?")
COMMA = re.compile(r"[+-]?\d*,(\d+)")
"""A number with a decimal comma."""
BLANK = re.compile("[\u00a0\u202f]")
"""Blanks that do not break, between thousands."""
LONGEST_QUOTE = 40
"""Characters of a file's text in a message."""
DECIMALS = re.compile(r"[+-]?\d*(?:\.(\d*))?")


class _Row(NamedTuple):
    line: int
    cells: dict[str, str]
    headings: Mapping[str, str]

    @property
    def hubs(self) -> str:
        """The hubs that a strut joins, for messages."""
        return f"the hubs {self.cells['from'][:LONGEST_QUOTE]} and {self.cells['to'][:LONGEST_QUOTE]}"


def read(file: InputFile) -> Tables:
    """Read struts, their lengths, and the triangles that they make.

    A table with the columns ``from``, ``to``, and ``length`` or ``type`` has a row for each strut; one with
    ``type`` and ``length``, or ``chord factor``, has the lengths of types.  Either may have a column
    ``length error`` of standard deviations.  Other columns and tables are ignored.  Every three hubs that are
    joined are a triangle, unless they cut the frame in two.

    Hubs are numbers or names; they are vertices in this order, and a `MeshNote` says so unless hub 0 is
    vertex 0, hub 1 is vertex 1, ...

    Without that column, the errors of the lengths are those of the last digit that most have, the same in
    all, unless there is one length only, there are fewer than 30 struts, or the digits are so few or so many
    that the lengths are exact.

    Raises
    ------
    FileError
        It is not a strut table: naming the line.
    InvalidMetric
        The struts are not a frame of triangles: naming the first strut.  Lengths are checked by
        ``check_lengths``, an entry, with the errors that they have or are given.
    """
    struts, legend = [], {}
    for row in _rows(file):
        if "from" in row.cells:
            struts.append(row)
        elif row.cells["type"] and _written(row):
            legend[row.cells["type"]] = row
    if not struts:
        first = next((line for line in file.text.splitlines() if line.strip()), "")
        raise FileError(
            f"{file} is not a strut table: it has no rows below a line with 'from', 'to', and 'type' or "
            f"'length', a row for each edge; its first line is {_short(first)}"
        )
    measured = []
    for row in struts:
        if not _written(row):
            kind = row.cells.get("type", "")
            if not kind and not {"type", *LENGTHS} & row.cells.keys():
                columns = ", ".join(row.cells)[: 3 * LONGEST_QUOTE]
                raise FileError(
                    f"{file}, line {row.line}: no 'length' or 'type' is among the columns {columns}"
                )
            if kind not in legend:
                raise FileError(
                    f"{file}, line {row.line}: the strut has no length, and its type {_short(kind)} has none"
                )
            row = legend[kind]
        measured.append(row)
    texts = _with_points(_without_unit(measured, file))
    lengths = [
        _number(text, f"{file}, line {row.line}: the length is {_short(_written(row))}")
        for text, row in zip(texts, measured, strict=True)
    ]
    kept = _listed_once(struts, texts, lengths, file)
    struts, measured = [struts[k] for k in kept], [measured[k] for k in kept]
    texts, lengths = [texts[k] for k in kept], [lengths[k] for k in kept]
    edges = _edges(struts, file)
    tables = {"faces": _triangles(edges, struts), "edges": edges, "lengths": np.array(lengths)}
    hubs, error = _hubs(struts), _error(texts, tables["lengths"])
    if any(_written(row, ERRORS) for row in measured):
        tables["length_errors"] = np.array([_length_error(row, file) for row in measured])
    elif error:
        tables["length_errors"] = np.array(error)
    rows = [row.line for row in measured]

    def check(length_errors: ArrayLike | None) -> None:
        _check_triangles(tables["faces"], edges, tables["lengths"], length_errors, hubs, rows)
        _say_which_hub_is_which(hubs)
        _say_which_struts_may_be_missing(hubs, Triangulation(tables["faces"])._small_hole.tolist())

    return {**tables, "check_lengths": check}


def _rows(file: InputFile) -> Iterator[_Row]:
    """Rows of struts and of types, by the names of the columns.

    A table ends at the header of another one; below a blank line, at the first row without a number or a
    known type.
    """
    lines = file.text.removeprefix("\ufeff").splitlines()
    delimiter = _delimiter(lines)
    header: list[str] = []
    headings: dict[str, str] = {}
    types: set[str] = set()
    below_blank = False
    for number, line in enumerate(lines, 1):
        try:
            cells = [
                printable(BLANK.sub(" ", cell).strip())
                for row in csv.reader([line], delimiter=delimiter)
                for cell in row
            ]
        except csv.Error as error:
            raise FileError(f"{file}, line {number}: {error}") from None
        if not any(cells):
            below_blank = True
            continue
        if cells[0].startswith("#"):
            continue
        names = _names(cells)
        named = dict(zip_longest(header, cells[: len(header)], fillvalue=""))
        goes_on = any(map(NUMBER.fullmatch, cells)) or named.get("type", "") in types
        if not header or _is_header(names) or (below_blank and not goes_on):
            header, below_blank = names, False
            headings = dict(zip(names, cells, strict=True))
        elif _is_header(header):
            if any(cells[len(header) :]):
                comma = "; a decimal comma needs quotes, or semicolons between cells"
                raise FileError(
                    f"{file}, line {number}: there are {len(cells)} cells below {len(header)} columns"
                    f"{comma if delimiter == ',' else ''}"
                )
            types |= {named["type"]} if named.get("type") else set()
            below_blank = False
            yield _Row(number, named, headings)


def _delimiter(lines: Iterable[str]) -> str:
    """The sign between the cells of the first header."""
    for line in lines:
        for sign in ";\t,":
            if _is_header(_names(cell.strip(' "') for cell in line.split(sign))):
                return sign
    return ","


def _names(cells: Iterable[str]) -> list[str]:
    """Names of columns as they are compared."""
    return [UNIT.sub("", cell).lower().replace("_", " ") for cell in cells]


def _is_header(names: Collection[str]) -> bool:
    """Whether these are the columns of a table of struts or of types."""
    return {"from", "to"} <= set(names) or ("type" in names and not set(LENGTHS).isdisjoint(names))


def _written(row: _Row, columns: Iterable[str] = LENGTHS) -> str:
    """The length in a row, its standard deviation or its unit, as written; empty where there is none."""
    return next((row.cells[name] for name in columns if row.cells.get(name)), "")


def _short(text: str) -> str:
    return repr(text if len(text) <= LONGEST_QUOTE else text[:LONGEST_QUOTE] + "...")


def _split(row: _Row, columns: Sequence[str], file: InputFile) -> tuple[str, str, str]:
    """The number in a row, as it is written, the unit behind it, and this or that of its column, if any."""
    name = next((name for name in columns if row.cells.get(name)), "")
    value, unit = split_unit(row.cells.get(name, ""))
    found = UNIT.search(row.headings.get(name, ""))
    common = found[1].strip().lower() if found else ""
    if unit and UNITS.get(common, UNITS[unit]) != UNITS[unit]:
        raise FileError(
            f"{file}, line {row.line}: the {columns[0]} is {_short(row.cells[name])} in the column "
            f"{_short(row.headings[name])}"
        )
    beside = _written(row, OWN_UNIT).lower()
    own = next((name for name in (unit, common, beside) if name in UNITS), "")
    if beside in UNITS and UNITS[beside] != UNITS[own]:
        raise FileError(
            f"{file}, line {row.line}: the {columns[0]} is {_short(f'{value} {own}')}, and its unit "
            f"{_short(beside)}"
        )
    return value, unit, own


def _without_unit(rows: Sequence[_Row], file: InputFile) -> list[tuple[str, str]]:
    """The numbers of lengths that have a common unit, or none, with their places in the file."""
    split = [_split(row, LENGTHS, file) for row in rows]
    first, unit, common = split[0]
    for row, (value, behind, own) in zip(rows, split, strict=True):
        if behind != unit or UNITS.get(own) != UNITS.get(common):
            raise FileError(
                f"{file}, line {row.line}: the length is {_short(f'{value} {own}'.strip())}, but "
                f"{_short(f'{first} {common}'.strip())} in line {rows[0].line}: all lengths need the same "
                "unit, or none"
            )
    return [(ungrouped(each[0]), f"{file}, line {row.line}") for row, each in zip(rows, split, strict=True)]


def _length_error(row: _Row, file: InputFile) -> float:
    """The standard deviation of the length in a row, in the same unit."""
    length, _, common = _split(row, LENGTHS, file)
    value, unit, own = _split(row, ERRORS, file)
    problem = f"{file}, line {row.line}: the length error is {_short(f'{value} {own}'.strip())}"
    if own and (unit or common) and UNITS.get(own) != UNITS.get(common):
        raise FileError(f"{problem}, and the length {_short(f'{length} {common}'.strip())}: units differ")
    return _number(ungrouped(value).replace(",", "."), problem)


def _with_points(written: Sequence[tuple[str, str]]) -> list[str]:
    """Lengths and their places in the file, with a point for a decimal comma.

    A comma before three digits could also separate thousands, where other lengths have none.
    """
    commas = [COMMA.fullmatch(text) for text, _ in written]
    doubtful = [k for k, comma in enumerate(commas) if comma and len(comma[1]) == 3]
    without = [k for k, comma in enumerate(commas) if not comma]
    if doubtful and without and len(without) < len(doubtful):
        text, where = written[without[0]]
        raise FileError(f"{where}: the length {_short(text)} has no decimal comma, as most lengths have")
    if doubtful and without:
        text, where = written[doubtful[0]]
        raise FileError(
            f"{where}: the length {_short(text)} may be {text.replace(',', '')} or "
            f"{text.replace(',', '.')}, as other lengths have no comma"
        )
    return [
        text.replace(",", ".") if comma else text for (text, _), comma in zip(written, commas, strict=True)
    ]


def _number(written: str, problem: str) -> float:
    try:
        value = float(written)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        begin = NUMBER.match(written)
        rest = written[begin.end() :].strip() if begin else ""
        unclear = f": what {_short(rest)} means is unclear" if rest else ""
        if fraction := FRACTION.match(written):
            whole, part, of = (int(digits or 0) for digits in fraction.groups())
            unclear = f": write fractions as decimals, {whole + part / of:.10g}"
        raise FileError(f"{problem}, not a positive finite number{unclear}")
    return value


def _hubs(struts: Collection[_Row]) -> list[str]:
    """The names of the hubs in their natural order, which is that of the vertices."""
    return sorted({row.cells[end] for row in struts for end in ("from", "to")}, key=_natural_order)


def _say_which_hub_is_which(hubs: Sequence[str]) -> None:
    """Warn where the names of the hubs are not the numbers of their vertices."""
    if hubs == [str(k) for k in range(len(hubs))]:
        return
    few = len(hubs) <= 12
    some = range(len(hubs)) if few else [0, 1, 2, len(hubs) - 1]
    named = [f"hub {hubs[k][:LONGEST_QUOTE]} is vertex {k}" for k in some]
    if not few:
        named.insert(3, "...")
    warn_of_mesh(f"hubs are numbered from 0 in the order of their names: {', '.join(named)}")


def _say_which_struts_may_be_missing(hubs: Sequence[str], hole: Sequence[int]) -> None:
    """Warn of a hole between a few hubs, given along its boundary."""
    if len(hole) < 4:  # struts between three hubs are a triangle
        return
    names = [hubs[v][:LONGEST_QUOTE] for v in hole]
    rows = (
        f"{len(hole) - 3} struts across it are"
        if len(hole) > 4
        else (f"the strut between {names[0]} and {names[2]}, or {names[1]} and {names[3]}, is")
    )
    warn_of_mesh(f"the hubs {', '.join(names)} are around a hole: perhaps {rows} missing in the table")


def _listed_once(
    struts: Sequence[_Row], texts: Sequence[str], lengths: Sequence[float], file: InputFile
) -> list[int]:
    """Rows of different struts: tables made face by face have each strut twice, with the same length.

    Of two rows, that with more digits.
    """
    kept: dict[frozenset[str], int] = {}
    for k, row in enumerate(struts):
        ends = frozenset((row.cells["from"], row.cells["to"]))
        j = kept.setdefault(ends, k)
        units = _last_digit(texts[j]), _last_digit(texts[k])
        if abs(lengths[k] - lengths[j]) > min((0.5 + PRECISION.error) * max(units), COARSE * lengths[k]):
            raise FileError(
                f"{file}, line {row.line}: {row.hubs} are {texts[k][:LONGEST_QUOTE]} apart, but "
                f"{texts[j][:LONGEST_QUOTE]} in line {struts[j].line}"
            )
        if 0 < units[1] < units[0]:
            kept[ends] = k
    return list(kept.values())


def _last_digit(text: str) -> float:
    """Unit of the last digit of a number; 0 for powers of ten."""
    found = DECIMALS.fullmatch(text)
    return 10.0 ** -len(found[1] or "") if found else 0.0


def _edges(struts: list[_Row], file: InputFile) -> Indices:
    """The ends of the struts by the numbers of their vertices."""
    names = [row.cells[end] for row in struts for end in ("from", "to")]
    for k, row in enumerate(struts):
        if not names[2 * k] or not names[2 * k + 1] or names[2 * k] == names[2 * k + 1]:
            start, end = map(_short, names[2 * k : 2 * k + 2])
            raise FileError(f"{file}, line {row.line}: a strut is from {start} to {end}")
    place = {name: k for k, name in enumerate(_hubs(struts))}
    return np.array([place[name] for name in names]).reshape(-1, 2)


def _natural_order(name: str) -> tuple[tuple[bool, int, str], ...]:
    """Key by which ``P2`` is before ``P10``."""
    parts = re.split(r"([0-9]+)", name)
    return (
        *((False, int(p), "") if p.isdecimal() and len(p) <= LONGEST else (True, 0, p) for p in parts),
        (True, 0, name),
    )


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
        strut = f"the strut between {row.hubs}"
        if count == 0:
            raise InvalidMetric(f"{strut} is in no triangle: lengths do not tell the shape")
        if count > 2:
            raise InvalidMetric(f"{strut} is in {count} triangles: give the faces, in .json")
    return np.array(_turned_alike(found, at))


def _check_triangles(
    faces: Indices,
    edges: Indices,
    lengths: Floats,
    length_errors: ArrayLike | None,
    hubs: Sequence[str],
    rows: Sequence[int],
) -> None:
    """Refuse lengths that break a triangle inequality, and not by their errors, by the names of the hubs.

    Lengths that several struts take from a row of the legend may all be wrong: nothing more is said of these.
    """
    place = {frozenset(ends): e for e, ends in enumerate(edges.tolist())}
    pairs = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2).tolist()
    sides = np.array([place[frozenset(pair)] for pair in pairs]).reshape(-1, 3)
    f = first_broken(sides, lengths, 0.0)
    errors = np.zeros(1) if length_errors is None else np.asarray(length_errors, dtype=np.float64)
    if f >= 0 and errors.size in (1, len(lengths)) and (np.isfinite(errors) & (errors > 0)).all():
        errors = np.broadcast_to(errors, lengths.shape)
        f = first_broken(sides, within_inequalities(sides, lengths, errors), 0.0)
    if f < 0:
        return
    names = [hub[:LONGEST_QUOTE] for hub in hubs]
    ends = [" to ".join(names[v] for v in pair) for pair in np.sort(edges, axis=1).tolist()]
    longest_first = sides[f][np.argsort(-lengths[sides[f]], kind="stable")].tolist()
    doubt = ""
    if len(set(rows)) == len(rows):
        doubt = wrong_length_clause(faces, sides, lengths, EUCLIDEAN, lambda e: f"the strut {ends[e]}")
    raise InvalidMetric(
        f"the triangle of the hubs {', '.join(names[v] for v in sorted(faces[f].tolist()))} breaks the "
        f"triangle inequality: {', '.join(f'{ends[e]} is {lengths[e]:.9g}' for e in longest_first)}{doubt}"
    )


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
    visited = set(reached)
    while reached:
        onward = beside[reached.pop()] & left - visited
        visited |= onward
        reached += onward
    return len(visited) < len(left)


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
    if len(written) < 30:  # nothing is overdetermined that a smooth surface could average
        return 0.0
    if len(set(written)) == 1:  # of one length, a triangle is regular, whatever its digits
        return 0.0
    decimals = [DECIMALS.fullmatch(word) for word in written]
    if any(found is None for found in decimals):  # in powers of ten
        return 0.0
    unit = common_unit(lengths, 10.0 ** -max(len(found[1] or "") for found in decimals if found))
    error = unit / math.sqrt(12)
    exact = unit < 10.0 ** (math.floor(math.log10(lengths.max())) + 1 - PRECISION.most)
    # Decimals of one digit are exact, and small whole numbers are a design.
    coarse = COARSE if unit == 1.0 else 0.03
    return 0.0 if exact or error > coarse * lengths.mean() else error


FORMAT = Format(".csv", read, None)
