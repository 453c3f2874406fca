"""Rounding error bounds of floating-point sums and products."""

U = 2.0**-53  # unit roundoff: bound on the relative error of x + y, x - y, x y, x / y and sqrt(x)
UNDERFLOW = 1e-290  # exceeds the underflow errors of sums of a million products of numbers near 1
GUARD = 1.0 + 1e-10  # factor for bounds computed in floats: covers 900,000 roundings of positive terms


def gamma(k: int) -> float:
    """Relative error ``k u / (1 - k u)`` of k roundings in a row (Higham 2002, lemma 3.1)."""
    return k * U / (1 - k * U)
