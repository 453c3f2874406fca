"""JSON: one object of named tables, each a list of numbers or a list of lists of numbers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables

ROWS = {"faces": "face", "edges": "edge", "vertices": "vertex"}
PLAIN = {"lengths": "length"}
LONGEST_INTEGER = 18  # digits: every index has fewer, and longer ones do not fit into 64 bits


def read(path: Path) -> Tables:
    """Read a file; see `parse`."""
    return parse(path.read_bytes(), str(path))


def parse(data: bytes, name: str) -> Tables:
    """Read the tables of a JSON object that a metric may consist of; other entries are left aside.

    Parameters
    ----------
    data : bytes
        UTF-8.
    name : str
        What the data is called in a message.

    Returns
    -------
    dict
        ``faces`` and ``edges`` stay lists, whose rows may still have the wrong length; ``lengths`` and
        ``vertices`` are arrays.

    Raises
    ------
    FileError
        The data is no JSON object.
    InvalidMetric
        A table holds something else than numbers.
    """
    try:
        document = json.loads(data.decode("utf-8-sig"), parse_int=_integer)
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
    tables: dict[str, Any] = {key: value for key, value in document.items() if value is not None}
    for key, row in ROWS.items():
        if key in tables:
            _check_rows(tables[key], key, row)
    for key, row in PLAIN.items():
        if key in tables:
            _check_list(tables[key], key)
            _check_numbers(tables[key], row + " {}")
            tables[key] = np.array(tables[key], dtype=np.float64)
    if "vertices" in tables:
        tables["vertices"] = _points(tables["vertices"])
    return tables


def write(path: Path, tables: Tables) -> None:
    """Write named arrays."""
    lists = {key: np.asarray(value).tolist() for key, value in tables.items()}
    path.write_text(json.dumps(lists, allow_nan=False) + "\n", encoding="utf-8")


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= LONGEST_INTEGER else float(digits)


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
    for k, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise InvalidMetric(f"vertex {k} has {len(row)} coordinates, but vertex 0 has {len(rows[0])}")
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1)


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."
