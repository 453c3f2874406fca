"""Double-double arithmetic.

Sums and products of floats are pairs exactly (Dekker, A floating-point technique for extending the available
precision, Numer. Math. 18, 1971); those of pairs are off by a few U^2, relative to the sizes of their terms.
"""

from isoembed.arrays import Floats

Pair = tuple[Floats, Floats]

ADDED = 8  # the most U^2, relative to the sizes, that `plus` is off by, and `times`
MULTIPLIED = 16


def exact_sum(x: Floats, y: Floats) -> Pair:
    """Return x + y exactly, as a float and what its rounding lost."""
    total = x + y
    part = total - x
    return total, (x - (total - part)) + (y - part)


def exact_difference(x: Floats, y: Floats) -> Pair:
    """Return x - y exactly."""
    return exact_sum(x, -y)


def exact_product(x: Floats, y: Floats) -> Pair:
    """Return x y exactly, as a float and what its rounding lost (but for underflow)."""
    product = x * y
    (x0, x1), (y0, y1) = _halves(x), _halves(y)
    return product, x1 * y1 - (((product - x0 * y0) - x1 * y0) - x0 * y1)


def plus(x: Pair, y: Pair) -> Pair:
    """Return x + y: two roundings of numbers of size U (|x| + |y|), and one that is kept."""
    total, lost = exact_sum(x[0], y[0])
    return exact_sum(total, lost + (x[1] + y[1]))


def times(x: Pair, y: Pair) -> Pair:
    """Return x y: the product of what was lost is left out, and four terms of size U |x y| are rounded."""
    total, lost = exact_product(x[0], y[0])
    return exact_sum(total, lost + (x[0] * y[1] + x[1] * y[0]))


def _halves(x: Floats) -> Pair:
    """Return two floats of at most 26 bits each with the sum x."""
    scaled = (2.0**27 + 1) * x
    high = scaled - (scaled - x)
    return high, x - high
