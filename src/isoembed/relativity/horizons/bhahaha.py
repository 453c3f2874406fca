"""Reader for horizon shapes written by BHaHAHA of NRPy, h.t<iteration>.ah<number>.gp.

A file holds points of the horizon in slice coordinates, on a cell-centered grid in theta and phi [1]_, but
neither a metric nor the center of the angles.

References
----------
.. [1] Z. B. Etienne, T. Assumpcao, L. R. Werneck and S. D. Tootle, "BHaHAHA: A fast, robust apparent horizon
   finder library for numerical relativity", Classical and Quantum Gravity (2026), arXiv:2505.15912.
"""

import os
import re
from dataclasses import replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.io.input_file import InputFile, opened
from isoembed.io.text_table import read_text_table
from isoembed.meshing.sphere import directions_at
from isoembed.relativity.horizons.ahfinderdirect import horizon_and_iteration
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon_format import HorizonFormat

TIME = re.compile(r"\btime\b[^\d+-]*([+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)")


def read_bhahaha(path: str | os.PathLike[str]) -> CoordinateShape:
    """Read the shape of a horizon from a file of BHaHAHA.

    The file has one row ``x y z`` per point, separated by blanks or commas.  The rows form rings of constant
    theta, each closed by a copy of its first point (to within rounding) and followed by a blank line.  The
    angles about the center are theta = (i + 1/2) pi / n_theta and phi = -pi + (j + 1/2) 2 pi / n_phi.  The
    center is not in the file; it is determined from these angles by least squares.  Raises `FileError`: the
    file cannot be read, is truncated or malformed; the message names the line if possible.

    Parameters
    ----------
    path : path
        ``h.t*.ah*.gp``, optionally compressed (``.gz``).

    Returns
    -------
    CoordinateShape
        Its time comes from the comments of the file, its iteration from the file name.
    """
    with opened(path) as file:
        table = read_text_table(file)
        source = str(file)
        if table.numbers.shape[1] != 3:
            raise FileError(f"{file} has {table.numbers.shape[1]} columns, not the 3 of BHaHAHA: x, y and z")
        if not (finite := np.isfinite(table.numbers).all(axis=1)).all():
            raise FileError(f"{file}, line {table.lines[np.argmin(finite)]}: a coordinate is not finite")
        ends = [*np.flatnonzero(np.diff(table.lines) > 1), len(table.lines) - 1]
        n_phi = int(ends[0])  # the last point of a ring is its first
        rings, size = [], float(np.ptp(table.numbers, axis=0).max())
        for begin, end in zip([0, *(end + 1 for end in ends)], ends, strict=False):
            ring = table.numbers[begin : end + 1]
            apart = float(np.abs(ring[0] - ring[-1]).max())
            if n_phi < 3 or len(ring) != n_phi + 1 or apart > 1e-6 * size:  # rounding of printed digits
                off = f": it is off by {apart:.3g}" if len(ring) == n_phi + 1 else ""
                raise FileError(
                    f"{file}, line {table.lines[end]}: the ring that ends here does not have "
                    f"{max(n_phi, 3)} points followed by the first one again{off}"
                )
            rings.append(ring[:-1])
        times = [TIME.search(comment) for comment in table.comments]
        name, iteration = horizon_and_iteration(file.path)
    points = np.array(rings)
    shape = CoordinateShape.star_shaped(points.reshape(-1, 3), source, _center(points, source))
    time = next((float(match[1]) for match in times if match), None)
    return replace(shape, name=name, iteration=iteration, time=time)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # the check below rejects non-finite values
def _center(points: Floats, source: str) -> Floats:
    """Center (3,) about which points (n_theta, n_phi, 3) have the angles of the grid."""
    n_theta, n_phi, _ = points.shape
    theta = (np.arange(n_theta) + 0.5) * np.pi / n_theta
    phi = -np.pi + (np.arange(n_phi) + 0.5) * 2.0 * np.pi / n_phi
    u = directions_at(np.cos(theta)[:, None], phi)
    across = np.eye(3) - u[..., :, None] * u[..., None, :]
    # Least squares: distances of the center from the lines through the points along u.
    origin = points.mean(axis=(0, 1))
    moments = np.einsum("tpij,tpj->i", across, points - origin)
    center = origin + np.linalg.solve(across.sum(axis=(0, 1)), moments)
    arrows = points - center
    off = np.linalg.norm(np.einsum("tpij,tpj->tpi", across, arrows), axis=2)
    # A grid with one ring more or less differs by about pi / n_theta; rounding of printed digits is far below
    # 1 % of that.
    if not (off / np.linalg.norm(arrows, axis=2)).max() <= 0.01 * np.pi / n_theta:
        raise FileError(
            f"{source}: the {n_theta} rings of {n_phi} points are not at the angles of a cell-centered grid "
            "about any one center: the file is cut short, or in another order"
        )
    return center


def _recognizes(file: InputFile) -> bool:
    rows = (
        line.replace(",", " ").split() for line in file.head.splitlines() if not line.lstrip().startswith("#")
    )
    return file.ending == ".gp" and len(next(filter(None, rows), ())) == 3


BHAHAHA = HorizonFormat("BHaHAHA", _recognizes, read_bhahaha)
