"""Signal handling: SIGINT (Ctrl-C) and SIGTERM interrupt a command once."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SAME = 2.0  # seconds: signals within this time of the first count as one, as timeout(1) sends two


class Interruption:
    """Signal handler that raises `KeyboardInterrupt`.

    Attributes
    ----------
    status : int
        Exit status for the received signal: 130 for Ctrl-C, 143 for SIGTERM.
    """

    def __init__(self) -> None:
        self.status = 128 + signal.SIGINT
        self._came = -math.inf

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        now = time.monotonic()
        if now < self._came + SAME:
            return
        self._came, self.status = now, 128 + number
        raise KeyboardInterrupt


@contextmanager
def handled(by: Callable[[int, FrameType | None], Any] | signal.Handlers) -> Iterator[None]:
    """Install a signal handler for the duration of the block.

    Ignored signals stay ignored, as in background jobs of a shell.  In threads other than the main one,
    handlers cannot be installed, and nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in SIGNALS}
    heeded = [number for number in SIGNALS if before[number] not in (signal.SIG_IGN, None)]
    try:
        for number in heeded:
            signal.signal(number, by)
        yield
    finally:
        for number in heeded:
            signal.signal(number, before[number])
