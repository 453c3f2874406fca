"""Cutting of struts from bars of stock length: first-fit decreasing bin packing, and column generation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.reprs import counted

ROUNDING = 1e-9  # of a bar: tolerance for struts that fill it exactly
GAIN = 1e-6  # of a bar: least improvement by a new pattern; linear programs are solved to 1e-7
PARTS = 27720  # of a bar, to which sizes are rounded up; divisible by all numbers up to 12


@dataclass(frozen=True)
class Bar:
    """Bars with the same cutting pattern.

    Attributes
    ----------
    count : int
    struts : tuple of str
        Types of the struts cut from each bar, longest first.
    rest : float
        Remaining length of each bar.
    """

    count: int
    struts: tuple[str, ...]
    rest: float


@dataclass(frozen=True)
class CutList:
    """Bars from which all struts are cut.

    Attributes
    ----------
    stock : float
        Length of a bar.
    bars : tuple of Bar
    """

    stock: float
    bars: tuple[Bar, ...]

    @property
    def count(self) -> int:
        """Number of bars."""
        return sum(bar.count for bar in self.bars)

    @property
    def waste(self) -> float:
        """Remaining length of all bars, relative to their total length."""
        return sum(bar.count * bar.rest for bar in self.bars) / (self.count * self.stock)

    def __str__(self) -> str:
        lines = [f"{counted(self.count, 'bar')} of {self.stock:.6g}, {self.waste:.1%} left over"]
        width = len(str(max(bar.count for bar in self.bars)))
        for bar in self.bars:
            parts = ", ".join(f"{n} {name}" for name, n in Counter(bar.struts).items())
            lines.append(f"  {bar.count:{width}} x ({parts}), {bar.rest:.6g} left")
        return "\n".join(lines)

    @classmethod
    def of(cls, lengths: Sequence[tuple[str, float, int]], stock: float) -> CutList:
        """Minimize the number of bars heuristically.

        First-fit decreasing uses at most 11/9 of the minimum plus one bar (Dosa, 2007).  For up to 40 types,
        column generation on the linear relaxation (Gilmore and Gomory, 1961) may improve it.

        Parameters
        ----------
        lengths : sequence of (str, float, int)
            Name, length and number of the struts of each type.
        stock : float

        Raises
        ------
        InvalidParameter
            A strut is longer than a bar.
        """
        falling = sorted(lengths, key=lambda each: -each[1])
        sizes = np.array([length for _, length, _ in falling]) / stock  # in bars
        counts = np.array([count for _, _, count in falling])
        if len(falling) and sizes[0] > 1 + ROUNDING:
            name, length, _ = falling[0]
            raise InvalidParameter(
                f"a strut of type {name} is {length:.6g} long, more than a bar of {stock:.6g}"
            )
        packed = _first_fit(sizes, counts)
        # With more types, column generation would take more than some seconds.
        if len(falling) <= 40 and len(packed) > np.ceil(sizes @ counts - ROUNDING):
            packed = _generated(sizes, counts, packed)
        alike = Counter(tuple(pattern) for pattern in packed.tolist())
        bars = []
        for pattern, number in alike.items():
            names = tuple(falling[t][0] for t, n in enumerate(pattern) for _ in range(n))
            rest = float(1 - sizes @ pattern)
            bars.append(Bar(number, names, rest * stock if rest > ROUNDING else 0.0))
        return cls(stock, tuple(bars))


def _first_fit(sizes: Floats, counts: Indices) -> Indices:
    """Numbers of struts of each type in each bar, (bars, types), by first fit; sizes are descending."""
    rests: list[float] = []
    bars: list[list[int]] = []
    for t, (size, count) in enumerate(zip(sizes.tolist(), counts.tolist(), strict=True)):
        first = 0  # earlier bars have no room for this size
        for _ in range(count):
            while first < len(rests) and rests[first] < size - ROUNDING:
                first += 1
            if first == len(rests):
                rests.append(1.0)
                bars.append([0] * len(sizes))
            rests[first] -= size
            bars[first][t] += 1
    return np.array(bars, dtype=np.int64).reshape(-1, len(sizes))


def _generated(sizes: Floats, counts: Indices, packed: Indices) -> Indices:
    """Bars from the integer parts of the linear relaxation, repeated for the remaining struts."""
    left, patterns = counts.copy(), packed
    bars: list[Indices] = []
    while left.any():
        patterns, shares = _relaxed(sizes, left, patterns)
        whole = np.floor(shares + GAIN).astype(np.int64)
        if not whole.any():
            whole[np.argmax(shares)] = 1
        for pattern in np.repeat(patterns, whole, axis=0):
            bar = np.minimum(pattern, left)
            if bar.any():
                bars.append(bar)
            left -= bar
        packed = min(packed, np.vstack([*bars, _first_fit(sizes, left)]), key=len)
    return packed


def _relaxed(sizes: Floats, counts: Indices, patterns: Indices) -> tuple[Indices, Floats]:
    """Patterns and fractional numbers of bars that solve the linear relaxation."""
    from scipy.optimize import linprog  # slow to import

    patterns = np.unique(patterns, axis=0)
    while True:
        solved = linprog(np.ones(len(patterns)), -patterns.T, -counts)
        pattern = _dearest(sizes, counts, prices := -solved.ineqlin.marginals)
        if prices @ pattern <= 1 + GAIN:
            return patterns, solved.x
        patterns = np.vstack([patterns, pattern])


def _dearest(sizes: Floats, counts: Indices, prices: Floats) -> Indices:
    """Pattern of the highest price: a knapsack problem with sizes rounded up to parts of a bar."""
    units = np.ceil(sizes * PARTS - GAIN).astype(np.int64)
    value = np.zeros(PARTS + 1)
    taken: list[tuple[int, int, np.ndarray]] = []
    for t, unit in enumerate(units.tolist()):
        number, available = 1, int(min(counts[t], PARTS // max(unit, 1)))
        while available > 0 and prices[t] > 0:  # one, two, four, ...
            number = min(number, available)
            more = value[: PARTS + 1 - number * unit] + number * prices[t]
            better = np.zeros(PARTS + 1, dtype=np.bool_)
            better[number * unit :] = more > value[number * unit :]
            value[number * unit :][better[number * unit :]] = more[better[number * unit :]]
            taken.append((t, number, better))
            available, number = available - number, 2 * number
    pattern, room = np.zeros(len(sizes), dtype=np.int64), PARTS
    for t, number, better in reversed(taken):
        if better[room]:
            pattern[t] += number
            room -= number * int(units[t])
    return pattern
