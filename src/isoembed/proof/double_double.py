"""Double-double arithmetic.

Sums and products of floats are exactly representable as pairs (Dekker, A floating-point technique for
extending the available precision, Numer. Math. 18, 1971); sums and products of pairs have errors of a few U^2
relative to the magnitudes of their terms.
"""

from isoembed.arrays import Floats

Pair = tuple[Floats, Floats]

ADDED = 8  # error bounds of `plus` and `times`, in U^2 relative to the magnitudes of the terms
MULTIPLIED = 16


def exact_sum(x: Floats, y: Floats) -> Pair:
    """Return x + y exactly, as a float and its rounding error."""
    total = x + y
    part = total - x
    return total, (x - (total - part)) + (y - part)


def exact_difference(x: Floats, y: Floats) -> Pair:
    """Return x - y exactly."""
    return exact_sum(x, -y)


def exact_product(x: Floats, y: Floats) -> Pair:
    """Return x y exactly, as a float and its rounding error (barring underflow)."""
    product = x * y
    (x0, x1), (y0, y1) = _halves(x), _halves(y)
    return product, x1 * y1 - (((product - x0 * y0) - x1 * y0) - x0 * y1)


def plus(x: Pair, y: Pair) -> Pair:
    """Return x + y, with two rounding errors of numbers of size U (|x| + |y|); that of the sum is kept."""
    total, remainder = exact_sum(x[0], y[0])
    return exact_sum(total, remainder + (x[1] + y[1]))


def times(x: Pair, y: Pair) -> Pair:
    """Return x y, omitting the product of the low parts and rounding four terms of size U |x y|."""
    total, remainder = exact_product(x[0], y[0])
    return exact_sum(total, remainder + (x[0] * y[1] + x[1] * y[0]))


def _halves(x: Floats) -> Pair:
    """Return two floats of at most 26 bits each with the sum x."""
    scaled = (2.0**27 + 1) * x
    high = scaled - (scaled - x)
    return high, x - high
