"""Detection of rounded coordinates and lengths by their digits."""

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
    most: int = threshold(9, "digits", "Coordinates with more digits are as good as doubles.")
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


@dataclass(frozen=True)
class Precision:
    """Precision of rounded coordinates.

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


SHARE = 0.4
"""Fraction of lengths in whole units above which they were rounded to these: of lengths rounded to tenths of
the unit, one in ten is whole; of lengths in halves, one in two."""


def rounding_error(lengths: Floats) -> float | None:
    """Standard deviation of lengths rounded to a decimal place, divided by their mean.

    A few lengths, or halves, may have one decimal more than the others.  None for lengths that are taken as
    exact: those with more than nine digits, few different values, or a unit too coarse for measurements.
    """
    if not 1e-200 < lengths.max() < 1e200:
        return None
    largest = math.floor(math.log10(lengths.max()))
    sample = lengths[:: len(lengths) // PRECISION.sample + 1]
    for digits in range(1, PRECISION.most + 1):
        unit = 10.0 ** (largest - digits + 1)
        if unit and _multiples(sample, unit) and _multiples(lengths, unit):
            break
    else:
        return None
    unit = common_unit(lengths, unit)
    error = unit / math.sqrt(12) / float(lengths.mean())
    return (
        error
        if error <= COARSE and _look_measured(np.unique(np.rint(lengths / unit)), len(lengths))
        else None
    )


def _look_measured(values: Floats, count: int) -> bool:
    """Whether the distinct values, ascending whole numbers, of `count` lengths look like measurements.

    They must be many, or come from many lengths and nearly fill their range, except for one at each end.
    """
    most = len(values) >= FEW and 2 * len(values) > values[-2] - values[1]
    return len(values) >= DESIGNED or (most and count >= 2 * DESIGNED)


def common_unit(lengths: Floats, unit: float) -> float:
    """Unit of the last digit of most lengths, given a power of ten of which all are multiples."""
    values = np.unique(lengths)  # equal struts count once
    whole = _are_multiples(values, 10.0 * unit)
    most = whole.mean() > SHARE and len(values) >= DESIGNED
    return 10.0 * unit if most or (whole.all() and len(lengths) >= DESIGNED) else unit


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
    """Power of ten to which lengths were rounded, from their standard deviations; None if there is none."""
    if not 1e-200 < errors.min() == errors.max():
        return None
    step = math.sqrt(12) * float(errors[0])
    unit = 10.0 ** round(math.log10(step))
    typed = 0.99 < step / unit < 1.01  # with two digits
    return unit if typed and _multiples(lengths, unit) else None


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
