"""Types of parts: lengths within a tolerance, and sequences around hubs and faces."""

from collections.abc import Iterator

import numpy as np

from isoembed.arrays import Floats, Indices


def length_types(lengths: Floats, tolerance: float) -> Indices:
    """Type of each length, shape (E,), from 0 for the shortest, with the fewest types for the tolerance.

    Lengths of one type differ by no more than the tolerance.
    """
    types = np.empty(len(lengths), dtype=np.int64)
    shortest, found = -np.inf, -1
    for e in np.argsort(lengths, kind="stable").tolist():
        if lengths[e] - shortest > tolerance:
            shortest, found = lengths[e], found + 1
        types[e] = found
    return types


def letters(number: int) -> str:
    """Spreadsheet column names A, B, ..., Z, AA, AB, ... for 0, 1, ...."""
    name = ""
    while number >= 0:
        name = chr(ord("A") + number % 26) + name
        number = number // 26 - 1
    return name


def readings(n: int, closed: bool) -> Iterator[tuple[Indices, Indices]]:
    """All readings of n items around a circle, or along a line, in both directions.

    Each consists of the items in order, and the gaps after them; gap k is between items k and k + 1.
    """
    there, gaps = np.arange(n), np.arange(n if closed else n - 1)
    for k in range(n if closed else 1):
        yield np.roll(there, -k), np.roll(gaps, -k)
        yield np.roll(there, -k)[::-1], np.roll(gaps[::-1], k - 1 if closed else 0)


def first_reading(values: Indices, closed: bool = True) -> tuple[int, ...]:
    """Lexicographically first reading of a sequence, equal for all equivalent sequences."""
    return min((tuple(values[order].tolist()) for order, _ in readings(len(values), closed)), default=())
