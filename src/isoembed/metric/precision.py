"""Detection of rounded coordinates and lengths by their digits, and the errors of rounding."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class PrecisionThresholds:
    """Thresholds for the detection of rounded coordinates."""

    fewest: int = threshold(5, "digits", "Coordinates with fewer digits are more likely exact than rounded.")
    bits: int = threshold(12, "bits", "Coordinates with fewer bits, such as small integers, are exact.")
    most: int = threshold(9, "digits", "Coordinates with more digits are as accurate as doubles.")
    written: int = threshold(
        11, "digits", "Largest number of digits of single precision with eight decimals."
    )
    sample: int = threshold(
        64, "coordinates", "Initial sample of coordinates, sufficient to recognize doubles."
    )
    error: float = threshold(
        1e-3, "units of the last digit", "Rounding error allowed when digits of doubles are counted."
    )


PRECISION = PrecisionThresholds()
SINGLE = "single precision"
OF_LENGTHS = "lengths with errors"


@dataclass(frozen=True)
class Precision:
    """Precision of rounded coordinates, or of those computed from lengths with errors.

    Attributes
    ----------
    name : str
        Description, such as ``"single precision"`` or ``"7 digits"``.
    length_error : float
        Root mean square error of the edge lengths, in mean edge lengths.
    """

    name: str
    length_error: float

    @property
    def vertex_error(self) -> float:
        """Bound on the error of a vertex in any direction, in mean edge lengths.

        The error of a coordinate is at most half a unit of the last digit, and the root mean square error of
        a length is that unit divided by the square root of 6.
        """
        return math.sqrt(4.5) * self.length_error

    @classmethod
    def of_lengths(cls, vertex_error: float) -> Precision:
        """Precision of vertices computed from lengths with errors, which determine their `vertex_error`."""
        return cls(OF_LENGTHS, vertex_error / math.sqrt(4.5))

    @property
    def is_of_lengths(self) -> bool:
        """Whether the coordinates were computed from lengths with errors, and this bounds their effect."""
        return self.name == OF_LENGTHS

    @property
    def origin(self) -> str:
        """Clause on the coordinates, such as ``"rounded to 7 digits"``."""
        return f"{'computed from' if self.is_of_lengths else 'rounded to'} {self.name}"

    def in_means(self, factor: float) -> Precision:
        """Precision relative to a mean edge length smaller by this factor."""
        return replace(self, length_error=self.length_error * factor)

    @classmethod
    def of(cls, points: Floats, mean_length: float, fewest: int = PRECISION.fewest) -> Precision | None:
        """Detect the precision of coordinates, shape (V, n); None if they are doubles or exact.

        Parameters
        ----------
        points : ndarray, shape (V, n)
        mean_length : float
            Mean length of the edges between them.
        fewest : int, optional
            Coordinates with fewer decimal digits are taken as exact.
        """
        values = np.abs(points[points != 0])
        sample = values[:: len(values) // PRECISION.sample + 1]
        found = None if last_digits(sample, fewest) is None else last_digits(values, fewest)
        if found is None:
            return None
        name, quanta = found
        # Errors are uniformly distributed over a unit of the last digit; an edge has two ends.
        scale = float(quanta.max())
        spread = scale * math.sqrt(float(((quanta / scale) ** 2).sum()) / points.size / 6)
        return cls(name, spread / mean_length)


DESIGNED = 30
"""Number of different lengths below which they may come from a design rather than a measurement."""

FEW = 12
"""Number of different lengths below which they come from a design, even if they nearly fill their range."""

COARSE = 0.01
"""Standard deviation, in mean lengths, above which the last digit is not attributed to rounding."""


SHARE = 0.3
"""Fraction of lengths in whole units above which they were rounded to these, beyond the fraction expected by
chance: of lengths rounded to tenths of the unit, one in ten is whole; of lengths in halves, one in two."""

FRACTIONS = 2.0 ** -np.arange(1.0, 7.0)
"""Binary fractions to which lengths are rounded, such as sixteenths of an inch."""


def rounding_error(lengths: Floats) -> float | None:
    """Standard deviation of rounded lengths, divided by their mean.

    A few lengths may have one decimal more than the others.  None for lengths that are taken as exact: those
    with more than nine digits, few different values, or a unit too coarse for measurements.
    """
    unit = _detected_unit(lengths)
    if unit is None:
        return None
    error = unit / math.sqrt(12) / float(lengths.mean())
    return (
        error
        if error <= COARSE and _look_measured(np.unique(np.rint(lengths / unit)), len(lengths))
        else None
    )


def _detected_unit(lengths: Floats) -> float | None:
    """Unit to which lengths were rounded; None for more than nine digits."""
    if not 1e-200 < lengths.max() < 1e200:
        return None
    largest = math.floor(math.log10(lengths.max()))
    sample = lengths[:: len(lengths) // PRECISION.sample + 1]
    for digits in range(1, PRECISION.most + 1):
        unit = 10.0 ** (largest - digits + 1)
        if unit and _multiples(sample, unit) and _multiples(lengths, unit):
            return common_unit(lengths, unit)
    return None


def _look_measured(values: Floats, count: int) -> bool:
    """Whether the distinct values, ascending whole numbers, of `count` lengths look like measurements.

    They must be many, or come from many lengths and nearly fill their range, except for one at each end.
    """
    is_dense = len(values) >= FEW and 2 * len(values) > values[-2] - values[1]
    return len(values) >= DESIGNED or (is_dense and count >= 2 * DESIGNED)


def common_unit(lengths: Floats, unit: float) -> float:
    """Unit to which most lengths were rounded, given the unit of their last decimal place.

    It is larger if all are multiples of two, five or more units, or of a binary fraction, to the last decimal
    place, or if many are multiples of a power of ten.
    """
    values = np.unique(lengths)  # equal struts count once
    steps = unit * np.array([2.0, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0])
    step = unit
    for each in np.sort(np.append(steps, FRACTIONS[1.99 * unit < FRACTIONS])).tolist():
        measured = _look_measured(np.unique(np.rint(values / each)), len(lengths))
        is_typed_zero = each == steps[2]
        if (measured or is_typed_zero) and _are_near(values, each, unit).all():
            step = each
    whole_unit = 10.0 ** (math.floor(math.log10(1.001 * step)) + 1)
    many = _are_near(values, whole_unit, unit).mean() > SHARE + step / whole_unit
    return whole_unit if many and len(values) >= DESIGNED else step


def _are_near(values: Floats, step: float, unit: float) -> NDArray[np.bool_]:
    """Whether each is a multiple of a step to the last decimal place."""
    off = np.abs(values - step * np.rint(values / step))
    return np.asarray(off <= (0.5 + PRECISION.error) * unit)


def shared_errors(lengths: Floats, errors: Floats) -> Indices:
    """Labels of the lengths, equal for lengths with a common error, shape (E,).

    Equal lengths of a design were equal before rounding, and so are their errors.  Lengths of a measured body
    are equal by chance: then labels are distinct.  They are also distinct if the errors are not those of a
    rounded decimal, a unit divided by the square root of 12.

    Parameters
    ----------
    lengths, errors : ndarray, shape (E,)
        Lengths and their standard deviations.
    """
    each = np.arange(len(lengths))
    unit = rounded_unit(lengths, errors)
    if unit is None:
        return each
    values, labels = np.unique(np.rint(lengths / unit), return_inverse=True)
    places = float(values[-1] - values[0]) + 1
    by_chance = places * -math.expm1(-len(lengths) / places)  # expected number of different values
    return labels if len(values) == 1 or len(values) < by_chance / 2 else each


def rounded_unit(lengths: Floats, errors: Floats) -> float | None:
    """Unit to which lengths were rounded, from their standard deviations; None if there is none."""
    if not 1e-200 < errors.min() == errors.max():
        return None
    step = math.sqrt(12) * float(errors[0])
    decimal = 10.0 ** round(math.log10(step))
    units = (decimal if _multiples(lengths, decimal) else None, _detected_unit(lengths))
    return next((unit for unit in units if unit and 0.99 < step / unit < 1.01), None)  # with two digits


def last_digits(
    values: Floats, fewest: int = PRECISION.fewest, most: int = PRECISION.most
) -> tuple[str, Floats] | None:
    """Precision of numbers, and the unit of the last digit of each; None if they are exact or doubles.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Positive numbers.
    fewest, most : int
        Decimal digits, at most `PRECISION.written`: numbers with fewer are exact, those with more doubles.
    """
    if values.size == 0 or _multiples(values, 2.0 ** (np.frexp(values.max())[1] - PRECISION.bits)):
        return None
    with np.errstate(all="ignore"):  # overflow beyond single precision
        single = values.astype(np.float32)
        off = np.abs(values - single)
        spacing = np.spacing(single).astype(np.float64)
    if (off == 0).all():
        return SINGLE, spacing
    exponents = np.floor(np.log10(values))
    for digits in range(1, PRECISION.written + 1):
        quanta = _units(exponents, digits)
        if _multiples(values, quanta):
            break
    else:
        return None
    if digits < fewest:
        return None
    last = _units(np.full(values.shape, exponents.max()), digits)
    if _multiples(values, last):  # equally many decimals in all of them
        quanta = last
    if (off <= quanta * (0.5 + PRECISION.error)).all() and (quanta < spacing).mean() > 0.5:
        return SINGLE, spacing
    return (f"{digits} digits", quanta) if digits <= most else None


def _units(exponents: Floats, digits: int) -> Floats:
    with np.errstate(all="ignore"):  # underflow close to zero
        return 10.0 ** (exponents - digits + 1)


def _multiples(values: Floats, units: Floats | float) -> bool:
    return bool(_are_multiples(values, units).all())


def _are_multiples(values: Floats, units: Floats | float) -> NDArray[np.bool_]:
    with np.errstate(all="ignore"):
        counts = values / units
        return np.asarray(np.abs(counts - np.rint(counts)) <= PRECISION.error)
