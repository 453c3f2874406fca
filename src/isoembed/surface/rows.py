"""Arithmetic on rows of numbers, for kernels: array expressions in Python, loops in compiled code.

Compiled, an array expression on a hundred numbers takes twice as long as the loop; in Python the loop takes a
hundred times as long.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.kernel import with_numba


def copy(source: Floats, target: Floats) -> None:
    """Copy a row to another."""
    target[:] = source


def add(row: Floats, target: Floats) -> None:
    """Add a row to another."""
    target += row


def multiply(a: Floats, b: Floats, target: Floats) -> None:
    """Fill in the products of two rows."""
    np.multiply(a, b, out=target)


def subtract_product(a: Floats, b: Floats, target: Floats) -> None:
    """Subtract the products of two rows from a third."""
    target -= a * b


def subtract_multiple(factor: float, row: Floats, target: Floats) -> None:
    """Subtract a multiple of a row from another."""
    target -= factor * row


def dot(a: Floats, b: Floats) -> float:
    """The sum of the products of two rows, in their order."""
    return float(np.cumsum(a * b)[-1]) if len(a) else 0.0


def invert_root(whole: Floats, least: float, target: Floats, sound: Mask) -> None:
    """Replace numbers by one over their square roots, if they are above a share of others; by zero if not."""
    good = target > least * whole
    sound &= good
    target[:] = good / np.sqrt(np.where(good, target, 1.0))


@with_numba
def _compile() -> None:
    from numba.extending import overload

    def loop(function: Callable, inline: Any = "always") -> Callable:  # a call takes as long as ten numbers
        def use(compiled: Callable) -> Callable:
            overload(function, strict=False, inline=inline)(lambda *_: compiled)
            return compiled

        return use

    @loop(copy)
    def _(source, target):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            target[i] = source[i]

    @loop(add)
    def _(row, target):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            target[i] += row[i]

    @loop(multiply)
    def _(a, b, target):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            target[i] = a[i] * b[i]

    @loop(subtract_product)
    def _(a, b, target):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            target[i] -= a[i] * b[i]

    @loop(subtract_multiple)
    def _(factor, row, target):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            target[i] -= factor * row[i]

    @loop(dot, inline="never")  # numba warns of what is returned after a loop
    def _(a, b):  # type: ignore[no-untyped-def]
        total = 0.0
        for i in range(len(a)):
            total += a[i] * b[i]
        return total

    @loop(invert_root)
    def _(whole, least, target, sound):  # type: ignore[no-untyped-def]
        for i in range(len(target)):
            good = target[i] > least * whole[i]
            sound[i] &= good
            target[i] = 1.0 / np.sqrt(target[i]) if good else 0.0
