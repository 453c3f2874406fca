"""Vector drawings of nets: polylines by layer, and side numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.precision import PRECISION, last_digits

CUT, FOLD, SEAM, GLUE, READ = "cut", "fold", "seam", "glue", "read"
"""Purposes of lines: to be cut, folded, sewn on, glued over, or only read."""

LAYERS = {
    **dict.fromkeys(("cut", "cuts", "outline", "outlines"), CUT),
    **dict.fromkeys(("mountain", "valley", "fold", "folds", "crease", "creases", "score", "bend"), FOLD),
    **dict.fromkeys(("seam", "stitch"), SEAM),
    **dict.fromkeys(("glue", "tab", "tabs"), GLUE),
    **dict.fromkeys(("engrave", "notes", "legend", "solid"), READ),
}
"""Purpose of the lines of a layer or group, by its name in lower case."""
NUMBERS = "numbers"
"""The layer or group of the numbers of sides, where there is one."""


@dataclass(frozen=True, eq=False)
class Line:
    """A line of a drawing, with its corners; curves are sampled.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        Millimeters, y upward; of a closed line the first is the last, too.
    purpose : str
        `CUT`, `FOLD`, `SEAM`, `GLUE`, `READ`, or empty where the file does not tell.
    color : str
        Empty where there is none.
    angle : float or None
        By how much to fold, degrees, positive where the solid is convex.
    is_circle : bool
    is_curve : bool
        Whether parts of it are curves.
    """

    points: Floats
    purpose: str = ""
    color: str = ""
    angle: float | None = None
    is_circle: bool = False
    is_curve: bool = False

    @property
    def is_closed(self) -> bool:
        """Whether it ends where it begins."""
        return len(self.points) > 3 and bool((self.points[0] == self.points[-1]).all())


@dataclass(frozen=True)
class Number:
    """Text written at a side.

    Attributes
    ----------
    text : str
    x, y : float
        Its middle, mm.
    height : float
        Of the letters, mm.
    angle : float
        Of its line, degrees counterclockwise.
    """

    text: str
    x: float
    y: float
    height: float
    angle: float = 0.0


@dataclass(frozen=True, eq=False)
class Lines:
    """All lines and numbers of a drawing.

    Attributes
    ----------
    lines : tuple of Line
    numbers : tuple of Number
    unit : float
        Of the last digit of the coordinates, mm; 0 where these are doubles.
    kerf : float
        By which the outlines were offset for a beam, its whole width, mm.
    error : float
        Of the points of the solid, where these were rounded, mm.
    any_surface : bool
        Whether sides without a number are a boundary, and there may be handles.
    """

    lines: tuple[Line, ...]
    numbers: tuple[Number, ...]
    unit: float = 0.0
    kerf: float = 0.0
    error: float = 0.0
    any_surface: bool = False


def last_unit(values: Floats) -> float:
    """The unit of the last digit of coordinates; 0 of doubles, and of fewer digits than 4."""
    found = last_digits(np.abs(values[values != 0]), 4, PRECISION.written)
    return 0.0 if found is None else float(found[1].max())
