"""Cutting of struts from bars of stock length: first-fit decreasing bin packing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from isoembed.errors import InvalidParameter

ROUNDING = 1e-9  # of a bar: struts that fill it exactly fit


@dataclass(frozen=True)
class Bar:
    """Bars that are cut alike.

    Attributes
    ----------
    count : int
    struts : tuple of str
        The types of the struts that are cut from each, longest first.
    rest : float
        Length that is left of each.
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
        """Length that is left of all bars, over their length."""
        return sum(bar.count * bar.rest for bar in self.bars) / (self.count * self.stock)

    def __str__(self) -> str:
        lines = [f"{self.count} bars of {self.stock:.6g}, {self.waste:.1%} left over"]
        width = len(str(max(bar.count for bar in self.bars)))
        for bar in self.bars:
            parts = ", ".join(f"{n} {name}" for name, n in Counter(bar.struts).items())
            lines.append(f"  {bar.count:{width}} x ({parts}), {bar.rest:.6g} left")
        return "\n".join(lines)

    @classmethod
    def of(cls, lengths: Sequence[tuple[str, float, int]], stock: float) -> CutList:
        """Pack the longest struts first, each into the first bar that has room.

        That takes at most 11/9 of the fewest bars, and one (Dosa, 2007).

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
        rests: list[float] = []
        struts: list[list[str]] = []
        for name, length, count in sorted(lengths, key=lambda each: -each[1]):
            if length > stock * (1 + ROUNDING):
                raise InvalidParameter(
                    f"a strut of type {name} is {length:.6g} long: none is cut from a bar of {stock:.6g}"
                )
            first = 0  # bars before it have no room for this length
            for _ in range(count):
                while first < len(rests) and rests[first] < length - stock * ROUNDING:
                    first += 1
                if first == len(rests):
                    rests.append(stock)
                    struts.append([])
                rests[first] -= length
                struts[first].append(name)
        alike: dict[tuple[str, ...], list[float]] = {}
        for names, rest in zip(struts, rests, strict=True):
            alike.setdefault(tuple(names), []).append(max(rest, 0.0))
        return cls(stock, tuple(Bar(len(some), names, some[0]) for names, some in alike.items()))
