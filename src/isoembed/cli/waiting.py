"""Elapsed time on the terminal while a command runs.

Nothing is shown during the first two seconds, in pipes, and while a command has its own display.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import Any, TextIO

from isoembed.cli.console import is_terminal

PATIENCE, PERIOD = 2.0, 0.5  # seconds before the first display, and between updates
ERASED = "\r\x1b[2K"


class Waiting:
    """Status line, updated by its own thread."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._began = stream, time.monotonic()
        self._over, self._lock = threading.Event(), threading.RLock()
        self._suspended = self._shown = False

    def run(self) -> None:
        """Update the line until `end`."""
        pause = PATIENCE
        while not self._over.wait(pause):
            pause = PERIOD
            with self._lock:
                if not self._suspended and not self._over.is_set():
                    self._write(f"{ERASED}{self._text()}")
                    self._shown = True

    def _text(self) -> str:
        return f"isoembed: working, {time.monotonic() - self._began:.0f} s (Ctrl-C stops)"

    def erase(self) -> None:
        """Erase the line before other output."""
        with self._lock:
            if self._shown:
                self._write(ERASED)
                self._shown = False

    def end(self) -> None:
        """Erase the line and stop updates."""
        self._over.set()
        self.erase()

    @contextmanager
    def suspended(self) -> Iterator[None]:
        """Suspend the line during a block with its own display."""
        with self._lock:
            self._suspended = True
            self.erase()
        try:
            yield
        finally:
            self._suspended = False

    def _write(self, text: str) -> None:
        with suppress(OSError, ValueError):  # the terminal may be closed
            self._stream.write(text)
            self._stream.flush()


class _Above:
    """A stream that erases the status line before each write."""

    def __init__(self, stream: TextIO, line: Waiting) -> None:
        self._stream, self._line = stream, line

    def write(self, text: str) -> int:
        self._line.erase()
        return self._stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def suspended(options: argparse.Namespace) -> AbstractContextManager[None]:
    """Suspend the status line during a block with its own display."""
    line: Waiting | None = options.waiting
    return nullcontext() if line is None else line.suspended()


@contextmanager
def waiting(*, quiet: bool) -> Iterator[Waiting | None]:
    """Show the status line during the block, if there is a terminal."""
    out, err = sys.stdout, sys.stderr
    if quiet or not is_terminal(err):
        yield None
        return
    line = Waiting(err)
    threading.Thread(target=line.run, daemon=True).start()
    sys.stderr = _Above(err, line)
    if is_terminal(out):
        sys.stdout = _Above(out, line)
    try:
        yield line
    finally:
        line.end()
        sys.stdout, sys.stderr = out, err
