"""Reader for spherical harmonic coefficients of surfaces in SpECTRE's *_Ylm.dat tables.

Each row is a surface at one time: ``Time``, ``<Frame>ExpansionCenter_x``, ``_y``, ``_z``, ``Lmax`` and
``coef(l,m)``, the coefficients of the radius about that center in the basis of SPHEREPACK [1]_,

    r = sum_l a_l0 P_l0 / 2 + sum_l sum_m>0 P_lm (a_lm cos(m phi) - b_lm sin(m phi)),

with a_lm = ``coef(l,m)``, b_lm = ``coef(l,-m)``, and P_lm the associated Legendre functions of cos(theta)
without the Condon-Shortley phase (-1)^m, normalized to a unit integral of P_lm^2 over cos(theta).  Complex
coefficients F_lm of the harmonics Y_lm with that phase satisfy a_lm + i b_lm = (-1)^m sqrt(2 / pi) F_lm [2]_.

References
----------
.. [1] J. C. Adams and P. N. Swarztrauber, "SPHEREPACK 3.0: A model development facility", Monthly Weather
   Review 127 (1999), 1872-1878.
.. [2] N. Deppe et al., SpECTRE, doi:10.5281/zenodo.4290404; ``ylm::Strahlkorper::coefficients``.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError
from isoembed.io.hdf5 import text_of
from isoembed.io.input_file import InputFile
from isoembed.io.text_table import read_text_table
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.smooth.harmonics import Harmonics

MONOPOLE = "coef(0,0)"
COLUMN = re.compile(r"\[\d+\]\s+(\S+)")  # comment in a text file: "[3] InertialExpansionCenter_z"
CENTER = re.compile(r"(\w*)ExpansionCenter_[xyz]")
FRAMES = ("Inertial", "")  # older files do not name the frame


@dataclass(frozen=True)
class HarmonicTable:
    """Harmonic coefficients of a surface, one row for each time.

    Attributes
    ----------
    legend : sequence of str
        Names of the columns.
    rows : ndarray or h5py.Dataset, shape (n_times, n_columns)
    """

    legend: Sequence[str]
    rows: Any

    @classmethod
    def in_dataset(cls, item: Any) -> "HarmonicTable | None":
        """Table of an HDF5 dataset; None if the dataset has another format."""
        legend = [text_of(name) for name in np.atleast_1d(item.attrs.get("Legend", ()))]
        if MONOPOLE not in legend or item.ndim != 2 or item.shape[1] != len(legend):
            return None
        return cls(legend, item)

    @classmethod
    def in_text(cls, file: InputFile) -> "HarmonicTable":
        """Table of a text file.  Raises `FileError`: it is malformed; the message names the line."""
        table = read_text_table(file)
        legend = [match[1] for match in map(COLUMN.match, table.comments) if match]
        if len(legend) != table.numbers.shape[1]:
            raise FileError(f"{file} has {table.numbers.shape[1]} columns, but names {len(legend)}")
        return cls(legend, table.numbers)

    def observations(self) -> list[tuple[float, str]]:
        """Times in increasing order, and the numbers of their rows."""
        times = np.asarray(self.rows[:, self.legend.index("Time")] if "Time" in self.legend else ())
        return sorted(((float(time), str(k)) for k, time in enumerate(times)), key=lambda pair: pair[0])

    def time(self, row: str) -> float | None:
        """Time of a row; None if there is no such row."""
        is_row = row.isdecimal() and int(row) < len(self.rows) and "Time" in self.legend
        return float(self.rows[int(row)][self.legend.index("Time")]) if is_row else None

    def tables(self, row: str) -> dict[str, NDArray[Any]]:
        """Values of a row by column name."""
        values = np.asarray(self.rows[int(row)], dtype=np.float64)
        return dict(zip(self.legend, values, strict=True))


def is_harmonic_text(file: InputFile) -> bool:
    """Whether the comments of a text file name harmonic coefficients."""
    comments = (line.lstrip("# ") for line in file.head.splitlines() if line.startswith("#"))
    return any((match := COLUMN.match(comment)) and match[1] == MONOPOLE for comment in comments)


def harmonic_shape(row: dict[str, NDArray[Any]], source: str, time: float) -> CoordinateShape:
    """Surface of a row of coefficients, as points.

    The points are at Gauss-Legendre nodes in theta and equidistant angles phi, with twofold oversampling in
    each direction.  Raises `FileError`: columns are missing, the frame is not inertial, a number is not
    finite, a coefficient beyond Lmax is not 0, or the radius is not positive everywhere.

    Parameters
    ----------
    row : dict of str to array
        Values by column name.
    source : str
        Name of the source, for messages.
    time : float
    """
    centers = [name for name in row if CENTER.fullmatch(name)]
    if len(centers) != 3 or "Lmax" not in row:
        raise FileError(f"{source} has no columns Lmax and ExpansionCenter_x, _y and _z")
    if (frame := CENTER.fullmatch(centers[0])[1]) not in FRAMES:  # type: ignore[index] # they match
        raise FileError(
            f"{source} is in the {frame} frame: its coordinates are not those of a slice, which are inertial"
        )
    bad = next((name for name, value in row.items() if not np.isfinite(value)), None)
    if bad is not None:
        raise FileError(f"{source}: {bad} is {row[bad]}")
    degree = int(row["Lmax"])
    if degree != row["Lmax"] or degree < 0:
        raise FileError(f"{source}: Lmax is {row['Lmax']}, not a degree")
    harmonics = Harmonics(degree, degree)
    names = [f"coef({l},{m})" for l, m in zip(*harmonics.labels, strict=True)]
    missing = [name for name in names if name not in row]
    beyond = sorted(name for name in row.keys() - {*names} if name.startswith("coef(") and row[name] != 0.0)
    if missing or beyond:
        defect = f"no {missing[0]}" if missing else f"a {beyond[0]} that is not 0"
        raise FileError(f"{source} has Lmax = {degree}, but {defect}")
    # Orthonormal harmonics are P_l0 / sqrt(2 pi), and P_lm cos(m phi) or sin(m phi) over sqrt(pi).
    orders = harmonics.labels[1]
    scale = np.where(orders == 0, np.sqrt(np.pi / 2.0), np.sign(orders) * np.sqrt(np.pi))
    n = max(2 * (degree + 1), 16)  # circles: enough for a well-determined fit even of a sphere
    u, _ = gauss_rule(n, 2 * n)
    r = harmonics.values(u) @ (scale * [row[name] for name in names])
    if not (r > 0.0).all():
        raise FileError(f"{source}: the radius is not positive everywhere, but {r.min():.6g} for one")
    center = np.array([row[name] for name in sorted(centers)])
    return CoordinateShape.star_shaped(center + r[:, None] * u, source, center, time=time)
