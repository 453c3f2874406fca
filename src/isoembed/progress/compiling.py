"""Time spent compiling: numba compiles a function on its first call, once for all if it can keep the code."""

import time
from typing import Any

from isoembed.kernel import with_numba


class Compiling:
    """Listener to numba's compiler.

    Attributes
    ----------
    functions : int
        That were compiled so far, those that were found compiled not among them.
    """

    def __init__(self) -> None:
        self.functions = 0
        self._open = 0  # one within another: a function and those that it calls
        self._spent: tuple[float, float | None] = (0.0, None)  # until now, and since when it is compiling

    @property
    def now(self) -> bool:
        """Whether it is compiling."""
        return self._spent[1] is not None

    @property
    def seconds(self) -> float:
        """What it took so far."""
        before, since = self._spent  # of another thread's making
        return before + (0.0 if since is None else time.perf_counter() - since)

    def on_start(self, _: Any) -> None:
        """Begin to compile a function."""
        if not self._open:
            self._spent = self._spent[0], time.perf_counter()
        self._open += 1

    def on_end(self, _: Any) -> None:
        """End, be it with an error."""
        self._open -= 1
        self.functions += 1
        if not self._open:
            self._spent = self.seconds, None


COMPILING = Compiling()
"""That of this process."""


@with_numba
def _listen() -> None:
    from numba.core import event

    class Listener(event.Listener):
        on_start, on_end = staticmethod(COMPILING.on_start), staticmethod(COMPILING.on_end)

    event.register("numba:compile", Listener())


def working_clock() -> float:
    """The time in seconds; it stands still while a function is compiled."""
    return time.perf_counter() - COMPILING.seconds
