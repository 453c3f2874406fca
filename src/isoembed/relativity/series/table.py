"""Table of a series in CSV and HDF5, one row for each horizon."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError, Writer, ending, write_atomically
from isoembed.io.hdf5 import HDF5_ENDINGS
from isoembed.io.registry import check_output
from isoembed.relativity.series.file_names import natural_order
from isoembed.runs.result import Result

TABLE_ENDINGS = (".csv", *HDF5_ENDINGS)
LENGTH, AREA, PURE = "length", "length^2", "1"
ESTIMATES = {
    "area": AREA,
    "irreducible_mass": LENGTH,
    "christodoulou_mass": LENGTH,
    "J": AREA,
    "dimensionless_spin": PURE,
    "integrated_mean_curvature": LENGTH,
    "hawking": LENGTH,
    "brown_york": LENGTH,
    "liu_yau": LENGTH,
    "wang_yau": LENGTH,
}
"""Columns with an error column after them, and their units."""
AXIS = ("axis_x", "axis_y", "axis_z")
HARMONICS = ("surface/", "coordinates/")
"""Prefixes of the names of arrays that restore a surface."""


def _units() -> dict[str, str]:
    units = {"time": "time", "iteration": PURE}
    for name, unit in ESTIMATES.items():
        units |= {name: unit, f"{name}_error": unit}
        if name == "J":
            units |= {**dict.fromkeys(AXIS, PURE), "axis_error": "radian"}
    return units | {
        "wang_yau_admissible": PURE,
        "space_curvature": "1 / length^2",
        "residual": PURE,
        "degree": PURE,
    }


UNITS = _units()
"""Columns of numbers in order, and their geometric units, G = c = 1."""
ERRORS = {name: f"{name}_error" for name in ESTIMATES} | dict.fromkeys(AXIS, "axis_error")
"""Columns that hold the errors of other columns."""
TEXTS = ("status", "reason", "label")
"""Columns of text, the last ones."""
WHOLE = ("iteration", "wang_yau_admissible", "degree")


@dataclass(frozen=True)
class Row:
    """Row of a table, for one horizon.

    Attributes
    ----------
    series : str
    label, status, reason : str
        Label and status of the result, and the reason for a missing embedding.
    numbers : dict of str to float
        Known numbers by column name.
    """

    series: str
    label: str
    status: str
    reason: str
    numbers: dict[str, float]

    @classmethod
    def of(cls, result: Result) -> Row:
        """Row of a result.  Raises `InvalidParameter`: the result is not that of a horizon."""
        report, numbers = result.report, dict[str, float | None]()
        moment = report.get("moment")
        if moment is None:
            raise InvalidParameter(f"the result {result.label} is of no horizon")
        numbers |= {"time": moment["time"], "iteration": moment["iteration"]}
        errors, spin = report.get("errors") or {}, report.get("spin")
        for name in ESTIMATES:
            numbers |= {name: report.get(name), f"{name}_error": errors.get(name)}
        numbers["wang_yau_admissible"] = report.get("wang_yau_admissible")
        if spin:
            numbers |= {"J": spin["J"], "J_error": spin["error"]}
            if spin["axis"]:
                numbers |= {**dict(zip(AXIS, spin["axis"], strict=True)), "axis_error": spin["axis_error"]}
        found = report.get("embedding") or {}
        numbers |= {name: found.get(name) for name in ("residual", "degree")}
        numbers["space_curvature"] = (report.get("space") or {}).get("curvature")
        values = {name: float(value) for name, value in numbers.items() if value is not None}
        return cls(moment["series"], result.label, result.status, result.message, values)

    @property
    def place(self) -> tuple[Any, ...]:
        """Sort key of the rows: the series, with ah2 before ah10, the time and the iteration."""
        when = [self.numbers.get(name, np.inf) for name in ("time", "iteration")]
        return natural_order(self.series), self.series, when, self.label


@dataclass(frozen=True, eq=False)
class SeriesTable:
    """Numbers of all horizons of a run, including those that do not embed or failed.

    Attributes
    ----------
    rows : tuple of Row
        Sorted by series and time.
    harmonics : mapping of str to mapping
        For embedded horizons, by label: the arrays of `isoembed.smooth.Start` that restore the surface.
    """

    rows: tuple[Row, ...]
    harmonics: Mapping[str, Mapping[str, NDArray[Any]]]

    @classmethod
    def of(cls, results: Iterable[Result]) -> SeriesTable:
        """Table of results.

        Parameters
        ----------
        results : iterable of Result
            In any order.
        """
        rows, harmonics = list[Row](), dict[str, dict[str, NDArray[Any]]]()
        for result in results:
            rows.append(Row.of(result))
            arrays = {name: array for name, array in result.arrays.items() if name.startswith(HARMONICS)}
            if arrays:
                harmonics[result.label] = arrays
        return cls(tuple(sorted(_dated(rows), key=lambda row: row.place)), harmonics)

    @property
    def series(self) -> dict[str, SeriesTable]:
        """Table of each series by name."""
        names = dict.fromkeys(row.series for row in self.rows)
        return {
            name: SeriesTable(tuple(row for row in self.rows if row.series == name), self.harmonics)
            for name in names
        }

    def __getitem__(self, name: str) -> Floats:
        """Column of numbers in `UNITS`; NaN for unknown numbers."""
        return np.array([row.numbers.get(name, np.nan) for row in self.rows])

    @property
    def statuses(self) -> tuple[str, ...]:
        """The status of each row."""
        return tuple(row.status for row in self.rows)


def _dated(rows: Sequence[Row]) -> list[Row]:
    """Rows with missing times taken from other rows at the same iteration."""
    times = {
        row.numbers["iteration"]: row.numbers["time"]
        for row in rows
        if row.numbers.keys() >= {"iteration", "time"}
    }
    found = [times.get(row.numbers.get("iteration", np.nan)) for row in rows]
    return [
        row if time is None else replace(row, numbers={"time": time} | row.numbers)
        for row, time in zip(rows, found, strict=True)
    ]


def write_table(path: str | os.PathLike[str], results: Iterable[Result]) -> None:
    """Write the table of a run as ``.csv`` or HDF5.

    Parameters
    ----------
    path : path
        File with the ending ``.csv``, ``.h5``, ``.hdf5`` or ``.he5``, which determines the format.
    results : iterable of Result
        In any order.  The same results make the same bytes.

    Raises
    ------
    FileError
        The ending is not known, the file cannot be written, or h5py is not installed.

    Notes
    -----
    A number in CSV has as many digits, at most 17, as it takes to read the same number again; a cell is empty
    where a number is not known.

    HDF5 has a group for each series, in which every column is a data set along time with its ``unit``; where
    there is one, the attribute ``error`` names the data set of errors.  Unknown values are NaN, or -1 for
    integers.  The group ``surfaces`` of a series has one for each embedded horizon, by its label, with the
    harmonics of the surface; `isoembed.smooth.Start.restored` makes them a surface again.
    """
    check_output(path, TABLE_ENDINGS)
    write_atomically({Path(path): table_writer(path, SeriesTable.of(results))})


def table_writer(path: str | os.PathLike[str], table: SeriesTable) -> Writer:
    """Writer of a table in the format of the file ending; see `write_atomically` and `write_table`."""
    if ending(path) == ".csv":
        return lambda temporary: _write_csv(temporary, table)
    try:
        import h5py  # noqa: F401
    except ImportError:
        raise FileError("HDF5 needs h5py: pip install h5py; a .csv does not") from None
    return lambda temporary: _write_hdf5(temporary, table)


def _write_csv(path: Path, table: SeriesTable) -> None:
    with path.open("w", encoding="utf-8", errors="backslashreplace", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["series", *UNITS, *TEXTS])
        for row in table.rows:
            numbers = [_written(name, row.numbers.get(name)) for name in UNITS]
            writer.writerow([row.series, *numbers, *(getattr(row, name) for name in TEXTS)])


def _written(name: str, value: float | None) -> str:
    if value is None or not np.isfinite(value):
        return ""
    return str(int(value)) if name in WHOLE else repr(value)


def _write_hdf5(path: Path, table: SeriesTable) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, part in table.series.items():
            group = file.create_group(name.replace("/", "|"))
            for column, unit in UNITS.items():
                values = part[column]
                if column in WHOLE:
                    values = np.where(np.isfinite(values), values, -1).astype(np.int64)
                data = group.create_dataset(column, data=values, track_times=False)
                data.attrs["unit"] = np.bytes_(unit)
                if column in ERRORS:
                    data.attrs["error"] = np.bytes_(ERRORS[column])
            for column in TEXTS:
                group.create_dataset(
                    column, data=_texts([getattr(row, column) for row in part.rows]), track_times=False
                )
            surfaces = group.create_group("surfaces")
            for row in part.rows:
                for array, values in table.harmonics.get(row.label, {}).items():
                    surfaces.create_dataset(f"{row.label}/{array}", data=values, track_times=False)


def _texts(words: list[str]) -> NDArray[Any]:
    """Texts of a fixed length in UTF-8."""
    import h5py

    encoded = [word.encode("utf-8", errors="backslashreplace") for word in words]
    longest = max(map(len, encoded), default=0) or 1
    return np.array(encoded, dtype=h5py.string_dtype("utf-8", longest))
