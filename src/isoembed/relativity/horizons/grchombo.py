"""Reader for apparent horizons written by GRChombo, coords_AH<number>_<file number>.dat.

A file holds the radius of the horizon on a grid in theta and phi about an origin, but no metric.  Origin and
time are in another file, stats_AH<number>.dat.  Layout: ``Source/ApparentHorizonFinder`` of GRChombo [1]_.

References
----------
.. [1] T. Andrade et al., "GRChombo: An adaptable numerical relativity code for fundamental physics", Journal
   of Open Source Software 6 (2021), 3703.
"""

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.io.input_file import opened
from isoembed.io.text_table import TextTable, read_text_table
from isoembed.meshing.sphere import directions_at
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon_format import HorizonFormat

HEADER = re.compile(r"#\s*(theta|z/r|u)\s+(phi|v)\s+(r|F)\b")  # u, v, F: GRChombo's names of theta, phi, r
NAME = re.compile(r"coords_(\w+)_(\d+)\.dat(?:\.gz)?")


class FinderOutput(NamedTuple):
    """Time of a coordinate file, and origin of its angles and radii, in the table stats_AH<number>.dat."""

    time: float
    origin: tuple[float, float, float]


def read_grchombo(path: str | os.PathLike[str]) -> CoordinateShape:
    """Read the shape of a horizon from a coordinate file of GRChombo.

    The columns are theta (cos(theta) if the header has ``z/r``), phi and the radius; further columns are
    ignored.  Origin and time are read from the table ``stats_AH<number>.dat`` in the same or the parent
    directory.  Without such a table, the origin is assumed to be (0, 0, 0), and a note says so.  The file has
    each pole once for every phi; their radii are averaged.  Raises `FileError`: the file cannot be read, is
    truncated or malformed, or the table has no row for it.

    Parameters
    ----------
    path : path
        ``coords_AH<number>_<file number>.dat``, optionally compressed (``.gz``).

    Returns
    -------
    CoordinateShape
        Its iteration is None, because the number in the file name counts outputs of the finder.
    """
    with opened(path) as file:
        header, name = HEADER.match(file.head), NAME.fullmatch(file.path.name)
        if header is None:
            raise FileError(f"{file} has no header '# theta phi r': it is not a coordinate file of GRChombo")
        u, r = _grid(read_text_table(file), header[1] == "z/r", str(file))
        output = finder_output(file.path)
        source = str(file)
    center = np.array(output.origin if output else (0.0, 0.0, 0.0))
    shape = CoordinateShape.star_shaped(center + r[:, None] * u, source, center)
    shape = replace(shape, name=name[1] if name else "")
    if output:
        return replace(shape, time=output.time)
    table = f"stats_{name[1]}.dat" if name else "stats_AH<number>.dat"
    note = f"the radii in {source} are assumed to be about (0, 0, 0): there is no {table} with their origin"
    return replace(shape, notes=(note,))


def finder_output(path: str | os.PathLike[str]) -> FinderOutput | None:
    """Time and origin of a coordinate file; None if there is no table.

    Raises `FileError`: the table is malformed, or has no row for this file.
    """
    if (table := stats_path(path)) is None:
        return None
    number = int(NAME.fullmatch(Path(path).name)[2])  # type: ignore[index] # there is a table for it
    if (output := finder_outputs(table).get(number)) is None:
        raise FileError(f"{table} has no row of the file {number}, {path}: its origin is not known")
    return output


def stats_path(path: str | os.PathLike[str]) -> Path | None:
    """Path of the table for a coordinate file, in its directory or the parent; None if there is none."""
    if (name := NAME.fullmatch(Path(path).name)) is None:
        return None
    folder = Path(path).absolute().parent
    tables = (above / f"stats_{name[1]}.dat" for above in (folder, folder.parent))
    return next(filter(Path.is_file, tables), None)


def finder_outputs(path: Path) -> dict[int, FinderOutput]:
    """Rows of a table stats_AH<number>.dat by the numbers of their coordinate files; the last of duplicates.

    Raises `FileError`: the table cannot be read or is malformed.
    """
    with opened(path) as file:
        table = read_text_table(file)
    names = next((words for words in map(str.split, table.comments) if "origin_z" in words), [])
    # Some column names consist of two words, but none from the origin on.
    first = table.numbers.shape[1] - len(names[names.index("origin_z") :]) - 2 if names else 0
    if names[:2] != ["time", "file"] or first < 2:
        raise FileError(f"{path} has no columns 'time file ... origin_z': it is not a table of GRChombo")
    return {
        int(number): FinderOutput(time, (x, y, z))
        for time, number, x, y, z in table.numbers[:, [0, 1, first, first + 1, first + 2]].tolist()
        if np.isfinite(number)
    }


def _grid(table: TextTable, of_cosine: bool, source: str) -> tuple[Floats, Floats]:
    """Directions (n, 3) and radii (n,) of a table."""
    numbers, lines = table.numbers[:, :3], table.lines
    if numbers.shape[1] < 3:
        raise FileError(f"{source}, line {lines[0]}: there are {numbers.shape[1]} columns, fewer than 3")
    good = np.isfinite(numbers).all(axis=1) & (numbers[:, -1] > 0.0)
    if not good.all():
        bad = lines[np.argmin(good)]
        raise FileError(f"{source}, line {bad}: an angle is not finite, or the radius is not positive")
    u, phi, r = numbers.T.copy()
    heights, i = np.unique(u, return_inverse=True)
    angles, j = np.unique(phi, return_inverse=True)
    low, high = (-1.0, 1.0) if of_cosine else (0.0, np.pi)
    margins = heights[0] - low, high - heights[-1]
    # Rounding of printed digits is far below 1 % of a step.
    step = 1.01 * (heights[-1] - heights[0]) / max(len(heights) - 1, 1)
    turn = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    if (
        len(np.unique(len(angles) * i + j)) != len(heights) * len(angles)
        or turn.max() > 1.01 * 2.0 * np.pi / len(angles)
        or not -1e-6 < min(margins) <= max(margins) <= step
    ):
        raise FileError(
            f"{source}: its {len(r)} points are not a whole grid of {len(heights)} x {len(angles)} angles "
            "theta and phi: the file is cut short, or of a part of the sphere"
        )
    z = np.clip(u, -1.0, 1.0) if of_cosine else np.cos(u)
    for pole in (z > 1.0 - 1e-12, z < -1.0 + 1e-12):  # within 1e-6 radians, for angles with seven decimals
        if pole.any():
            r[pole] = r[pole].mean()
    return directions_at(z, phi), r


GRCHOMBO = HorizonFormat(
    "GRChombo", lambda file: file.ending == ".dat" and bool(HEADER.match(file.head)), read_grchombo
)
