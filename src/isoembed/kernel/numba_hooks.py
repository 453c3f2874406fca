"""What is to be told to numba, when it is imported."""

from collections.abc import Callable

_waiting: list[Callable[[], None]] | None = []


def with_numba(tell: Callable[[], None]) -> Callable[[], None]:
    """Decorator of a function that is called once the compiler is imported, now if it is."""
    if _waiting is None:
        tell()
    else:
        _waiting.append(tell)
    return tell


def tell_numba() -> None:
    """Call all of them."""
    global _waiting
    waiting, _waiting = _waiting, None
    for tell in waiting or ():
        tell()
