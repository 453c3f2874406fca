"""Length tolerance of glued sides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing.polygon import Polygon, is_number
from isoembed.metric.precision import PRECISION, Precision, last_digits

SAME_LENGTH = 1e-9  # relative difference of equal lengths, unless the digits of the coordinates imply another
ROUNDING = 1e-15  # error of a length on two outlines, however short, in perimeters


class UnequalLengths(InvalidMetric):
    """Glued lengths that differ by more than the tolerance; `difference` is the largest difference."""

    def __init__(self, message: str, difference: float) -> None:
        super().__init__(message)
        self.difference = difference


@dataclass(frozen=True, eq=False)
class Tolerance:
    """Largest difference of two glued lengths, derived from the digits of the corners or as given.

    Attributes
    ----------
    units : ndarray, shape (n,)
        Unit of the last digit of each polygon's corners; 0 if they are exact or have full double precision.
    digits : str
        Description of the digits, such as ``"6 digits"``; empty if none are recognized.
    prescribed : float or None
        A length that replaces the tolerance derived from the digits.
    """

    units: Floats
    digits: str = ""
    prescribed: float | None = None

    @classmethod
    def of(cls, sheets: Sequence[Polygon], length: float | None = None) -> Tolerance:
        """Tolerance for the given polygons.

        Raises
        ------
        InvalidParameter
            The given tolerance is not a nonnegative length, or the polygons are not planar.
        """
        if length is not None and (not is_number(length) or not 0 <= length < math.inf):
            raise InvalidParameter(f"the tolerance is {length!r}, not a non-negative length")
        if not sheets[0].space.is_euclidean:  # coordinates are not lengths
            if length is not None:
                raise InvalidParameter("a tolerance requires polygons in the plane, which can be corrected")
            return cls.exact(len(sheets))
        side = min(float(sheet.sides.mean()) for sheet in sheets)
        values = [np.abs(sheet.corners[sheet.corners != 0]) for sheet in sheets]
        # Corners with fewer than four digits are exact: their sides are equal, or glued at a given tolerance.
        fewest = 4 if length is None else 2
        found = _rounding(np.concatenate(values), fewest)
        if found is not None:  # all have the same number of digits or of decimals
            name, quanta = found
            ends = np.cumsum([some.size for some in values])[:-1]
            units = np.array([some.max(initial=0.0) for some in np.split(quanta, ends)])
        else:
            alone = [_rounding(some, fewest) for some in values]
            name = next((one[0] for one in alone if one is not None), "")
            units = np.array([0.0 if one is None else float(one[1].max()) for one in alone])
        # Sides must have as many digits, too: integers far from the origin are exact.
        if units.max() > 10.0 ** (1 - fewest) * side:
            return cls(np.zeros(len(sheets)), "", length)
        return cls(units, name, length)

    @classmethod
    def exact(cls, n: int) -> Tolerance:
        """Tolerance for n polygons whose glued sides are equal up to rounding."""
        return cls(np.zeros(n))

    def between(self, p: int, q: int, lengths: tuple[float, float], sides: int = 2) -> float:
        """Tolerance for two lengths on polygons p and q, consisting of a total number of sides."""
        minimum = SAME_LENGTH * max(lengths)
        if self.prescribed is not None:
            return max(minimum, self.prescribed)
        # Rounded or truncated, the coordinates of two endpoints have a relative error of at most a unit; over
        # many sides such errors grow with the square root of their number.
        return max(minimum, math.sqrt(sides) * float(self.units[p] + self.units[q]))

    def errors(self, difference: float) -> Floats:
        """Coordinate errors of each polygon, given the largest difference of glued lengths."""
        return self.units if self.prescribed is None else np.maximum(self.units, difference / 2**1.5)

    def precision(self, difference: float) -> Precision:
        """Precision of the corners, with the error of a length in their unit."""
        name = self.digits if self.prescribed is None else f"a tolerance of {self.prescribed:g}"
        # The error is uniformly distributed over a unit of the last digit, and a side has two endpoints.
        return Precision(name, float(self.errors(difference).max()) / math.sqrt(6))

    def limit_text(self, limit: float) -> str:
        """Description of the tolerance, for messages."""
        return f"tolerance {limit:.2g} ({self.source})"

    @property
    def source(self) -> str:
        """Origin of the tolerance, for messages."""
        if self.prescribed is not None:
            return "as given"
        if self.digits:
            return f"from the corners, with {self.digits}"
        return f"{SAME_LENGTH:g} of the length, by default"


def _rounding(values: Floats, fewest: int) -> tuple[str, Floats] | None:
    return last_digits(values, fewest, PRECISION.written) if values.size else None
