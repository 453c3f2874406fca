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
    """Call all of them; those that an interruption leaves are called the next time."""
    global _waiting
    while _waiting:
        _waiting[0]()
        del _waiting[0]
    _waiting = None
