"""Vector drawings of nets: polylines by layer, and side numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.precision import PRECISION, last_digits

CUT, FOLD, SEAM, GLUE, READ = "cut", "fold", "seam", "glue", "read"
"""Purposes of lines: cutting, folding, sewing, gluing, or information only."""

LAYERS = {
    **dict.fromkeys(("cut", "cuts", "outline", "outlines"), CUT),
    **dict.fromkeys(("mountain", "valley", "fold", "folds", "crease", "creases", "score", "bend"), FOLD),
    **dict.fromkeys(("seam", "stitch"), SEAM),
    **dict.fromkeys(("glue", "tab", "tabs"), GLUE),
    **dict.fromkeys(("engrave", "notes", "legend", "solid"), READ),
}
"""Purpose of lines by the lower-case name of their layer or group."""
NUMBERS = "numbers"
"""Layer or group of the side numbers, if any."""


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline of a drawing; curves are sampled.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        Millimeters, y upward; the first and last points of a closed line are equal.
    purpose : str
        `CUT`, `FOLD`, `SEAM`, `GLUE`, `READ`, or empty if unknown.
    color : str
        Empty if undefined.
    angle : float or None
        Fold angle in degrees, positive where the solid is convex.
    is_circle : bool
    is_curve : bool
        Whether the line has curved parts.
    """

    points: Floats
    purpose: str = ""
    color: str = ""
    angle: float | None = None
    is_circle: bool = False
    is_curve: bool = False

    @property
    def is_closed(self) -> bool:
        """Whether the line is closed."""
        return len(self.points) > 3 and bool((self.points[0] == self.points[-1]).all())


@dataclass(frozen=True)
class Number:
    """Text written at a side.

    Attributes
    ----------
    text : str
    x, y : float
        Center of the text, mm.
    height : float
        Height of the letters, mm.
    angle : float
        Direction of the text, degrees counterclockwise.
    """

    text: str
    x: float
    y: float
    height: float
    angle: float = 0.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines and numbers of a drawing.

    Attributes
    ----------
    lines : tuple of Line
    numbers : tuple of Number
    unit : float
        Unit of the last digit of the coordinates, mm; 0 if they have full double precision.
    kerf : float
        Beam width, mm; the outlines were offset by half of it.
    error : float
        Rounding error of the points of the solid, mm.
    any_surface : bool
        Whether sides without a number are a boundary, and handles are permitted.
    """

    lines: tuple[Line, ...]
    numbers: tuple[Number, ...]
    unit: float = 0.0
    kerf: float = 0.0
    error: float = 0.0
    any_surface: bool = False


def last_unit(values: Floats) -> float:
    """Unit of the last digit of coordinates; 0 for full precision, and for fewer than 4 digits."""
    found = last_digits(np.abs(values[values != 0]), 4, PRECISION.written)
    return 0.0 if found is None else float(found[1].max())
