"""JSON files with named tables of numbers."""

import json
import sys
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.text_scan import LONGEST, lines
from isoembed.strict_json import strict_json

ROWS = {"faces": "face", "edges": "edge", "diagonals": "diagonal", "vertices": "vertex"}
PLAIN = {"lengths": "length", "length_errors": "length error"}

Document = dict[str, Any]


def read(file: InputFile) -> Tables:
    """Read a JSON file; see `parse`."""
    return parse(file.data, str(file))


def read_standard_input() -> Tables:
    """Read JSON from standard input; see `parse`."""
    stream = getattr(sys.stdin, "buffer", None)
    if stream is None:
        raise FileError("there is no standard input to read from")
    return parse(stream.read(), "standard input")


def parse(data: bytes, name: str, chosen: Callable[[Document], Document] | None = None) -> Tables:
    """Read the tables of a metric from a JSON object; other entries are returned unchecked.

    Parameters
    ----------
    data : bytes
        UTF-8.
    name : str
        Name of the source, for messages.
    chosen : callable, optional
        Maps the JSON object to the object of the tables.

    Returns
    -------
    dict
        Arrays, except that ``faces`` and ``edges`` stay lists if their rows differ in length.

    Raises
    ------
    FileError
        The data are not a JSON object.
    InvalidMetric
        A table holds values other than numbers.
    """
    choose = chosen or dict
    try:
        usual = _usual_tables(choose(_document(data, name)))
    except (ValueError, OverflowError):  # an integer too large for Python or NumPy
        usual = None
    return _any_tables(choose(_document(data, name, _integer))) if usual is None else usual


def write(path: Path, tables: Tables) -> None:
    """Write named arrays, scalars and strings; nonfinite array entries become null."""
    with path.open("w", encoding="utf-8") as file:
        for k, (key, table) in enumerate(tables.items()):
            file.write(("{" if k == 0 else ", ") + json.dumps(key) + ": ")
            values = np.asarray(table)
            file.writelines(written(values) if values.ndim else [json.dumps(values.item())])
        file.write("}\n")


def written(table: NDArray) -> Iterator[str]:
    """Yield the JSON text of a one- or two-dimensional table in pieces; nonfinite entries become null."""
    if not np.isfinite(table).all():
        yield strict_json(table)
        return
    row = "%r" if table.ndim == 1 else f"[{', '.join(['%r'] * table.shape[1])}]"
    yield "["
    yield from lines(row, table[:1])
    yield from lines(", " + row, table[1:])
    yield "]"


def _document(data: bytes, name: str, integer: Callable[[str], int | float] = int) -> dict[str, Any]:
    try:
        document = json.loads(data.decode("utf-8-sig"), parse_int=integer)
    except UnicodeDecodeError as error:
        raise FileError(f"{name} is not JSON: byte {error.start} is not UTF-8") from None
    except json.JSONDecodeError as error:
        raise FileError(f"{name} is not JSON: {error}") from None
    except RecursionError:
        raise FileError(f"{name} is not a metric: its lists are nested too deeply") from None
    if not isinstance(document, dict):
        raise FileError(
            f"{name} holds a JSON {type(document).__name__}, not an object with faces and lengths"
        )
    return document


def _usual_tables(document: dict[str, Any]) -> Tables | None:
    """Arrays, if every table is a list of numbers or of rows of equal length; otherwise None."""
    tables = {key: value for key, value in document.items() if value is not None}
    for key in (key for key in (*ROWS, *PLAIN) if key in tables):
        rows = tables[key]
        if key == "length_errors" and type(rows) in (int, float):  # one value for all lengths
            continue
        if not isinstance(rows, list) or not rows:
            return None
        shape: tuple[int, ...] = (len(rows),)
        if key in ROWS:
            if set(map(type, rows)) != {list} or len(set(map(len, rows))) > 1:
                return None
            shape = (len(rows), len(rows[0]))
            rows = list(chain.from_iterable(rows))
        kinds = set(map(type, rows))
        if not kinds <= {int, float}:
            return None
        array = np.fromiter(rows, np.int64 if kinds == {int} else np.float64, len(rows)).reshape(shape)
        if kinds == {int} and np.abs(array).max(initial=0) >= 10**LONGEST:
            return None
        tables[key] = array.astype(np.float64) if key in (*PLAIN, "vertices") else array
    return tables


def _any_tables(document: dict[str, Any]) -> Tables:
    """Tables, with every entry checked."""
    tables: dict[str, Any] = {key: value for key, value in document.items() if value is not None}
    for key, row in ROWS.items():
        if key in tables:
            _check_rows(tables[key], key, row)
    for key, row in PLAIN.items():
        if key in tables and not (key == "length_errors" and type(tables[key]) in (int, float)):
            _check_list(tables[key], key)
            _check_numbers(tables[key], row + " {}")
            tables[key] = np.array(tables[key], dtype=np.float64)
    if "vertices" in tables:
        tables["vertices"] = _points(tables["vertices"])
    return tables


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= LONGEST else float(digits)


def _check_list(table: Any, key: str) -> None:
    if not isinstance(table, list):
        raise InvalidMetric(f"{key} is {_shown(table)}, not a list")


def _check_rows(table: Any, key: str, row: str) -> None:
    _check_list(table, key)
    for k, entries in enumerate(table):
        if not isinstance(entries, list):
            raise InvalidMetric(f"{row} {k} is {_shown(entries)}, not a list of numbers")
        _check_numbers(entries, f"entry {{}} of {row} {k}")


def _check_numbers(entries: list[Any], name: str) -> None:
    for k, entry in enumerate(entries):
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            raise InvalidMetric(f"{name.format(k)} is {_shown(entry)}, not a number")


def _points(rows: list[list[float]]) -> np.ndarray:
    if not rows:
        raise InvalidMetric("there are no vertices")
    for k, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise InvalidMetric(f"vertex {k} has {len(row)} coordinates, but vertex 0 has {len(rows[0])}")
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1)


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


FORMAT = Format(".json", read, write, holds_metrics=True)
