"""Rounding error bounds of floating-point sums and products."""

U = 2.0**-53  # unit roundoff: x + y, x - y, x y, x / y and sqrt(x) are off by a factor within 1 +- U
UNDERFLOW = 1e-290  # exceeds all that underflow takes from sums of a million products of numbers near 1
GUARD = 1.0 + 1e-10  # on a bound computed in floats: makes up for 900,000 roundings of positive terms


def gamma(k: int) -> float:
    """Relative error ``k u / (1 - k u)`` of k roundings in a row (Higham 2002, lemma 3.1)."""
    return k * U / (1 - k * U)
