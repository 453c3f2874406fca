"""When it pays to compile a function: who rents until the rent is the price pays at most twice the least."""

from dataclasses import dataclass
from types import CodeType
from typing import Any

import numpy as np


class NotWorth(Exception):  # noqa: N818 -- no error
    """To compile a function for arguments of these types does not pay yet."""


LOADING = 0.01  # seconds to load a function that was compiled before
IMPORTING = 0.25  # seconds to import numba, once for all functions of a process
INTERPRETING = 3e-7  # seconds a line and element that a call is expected to take before one was measured
LARGE_SIZE = 200_000  # elements: for a larger array a function is compiled, whatever it took for small ones


@dataclass
class Account:
    """What calls of a function took as Python.

    Attributes
    ----------
    earlier : float
        Seconds in earlier processes, that compiled code would have saved.
    seconds : float
        Those of this process, since the function was last compiled.
    compiled : bool
        Whether it was, in this process.
    """

    earlier: float = 0.0
    seconds: float = 0.0
    compiled: bool = False
    _largest: int = 0
    _rate: float = 0.0  # seconds an element of the largest

    def enter(self, seconds: float, size: int) -> None:
        """Add a call for so many elements."""
        self.seconds += seconds
        if size >= self._largest:
            self._largest, self._rate = size, seconds / size

    def close(self) -> None:
        """Begin anew: the function was compiled."""
        self.earlier, self.seconds, self.compiled = 0.0, 0.0, True

    def expected(self, size: int, lines: int) -> float:
        """Seconds that a call will take: for so many elements, of a function that has so many lines."""
        if size > LARGE_SIZE:
            return float("inf")
        return size * (self._rate if self._largest else INTERPRETING * lines)


def lasting(seconds: float, all_seconds: float, numba: bool) -> float:
    """What a process would have saved with compiled code of a function at hand.

    Parameters
    ----------
    seconds, all_seconds : float
        That the function, and that all functions took as Python.
    numba : bool
        Whether numba was imported; if not, it would have been, for all of them.
    """
    share = 1.0 if numba or all_seconds == 0 else max(0.0, 1.0 - IMPORTING / all_seconds)
    return max(0.0, seconds - LOADING) * share


def elements(args: tuple[Any, ...]) -> int:
    """Elements of the largest array among arguments and in tuples of them; one, if there is none."""
    largest = 1
    for arg in args:
        if isinstance(arg, np.ndarray):
            largest = max(largest, arg.size)
        elif isinstance(arg, tuple):
            largest = max(largest, elements(arg))
    return largest


def source_lines(code: CodeType) -> int:
    """Lines of a function on which something is done."""
    return len({line for _, _, line in code.co_lines()})
