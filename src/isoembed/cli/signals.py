"""Signal handling: SIGINT (Ctrl-C) and SIGTERM interrupt a command once."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from isoembed.cli.status import INTERRUPTED

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SAME = 2.0  # seconds: signals that come so soon after the first are the same wish, as timeout(1) sends two


class Interruption:
    """Signal handler that raises `KeyboardInterrupt`.

    Attributes
    ----------
    status : int
        The exit status that says which signal it was: 130 for Ctrl-C, 143 for SIGTERM.
    """

    def __init__(self) -> None:
        self.status = INTERRUPTED
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
    """Let this handle the signals while the block runs.

    Signals that are ignored stay so: a shell starts jobs in the background like that.  Threads other than the
    main one cannot ask for signals, and leave them alone.
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
