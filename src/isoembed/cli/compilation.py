"""The first run of a command compiles its functions, which takes a minute: whoever watches is told."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from isoembed.cli.screen import print_error
from isoembed.progress.compiling import COMPILING, KIND

PATIENCE = 2.0  # seconds


class Notice(event.Listener):
    """Says once that functions are being compiled, when that has taken some time."""

    def __init__(self) -> None:
        self._before, self._said = COMPILING.seconds, False

    def on_start(self, _: Any) -> None:
        """Begin to compile a function."""
        if not self._said and COMPILING.seconds > self._before + PATIENCE:
            self._said = True
            print_error("functions are being compiled, once, which takes a minute or two", "note")

    def on_end(self, _: Any) -> None:
        """End."""


@contextmanager
def compilation_said(quiet: bool) -> Iterator[None]:
    """Say so on a terminal, if the block compiles."""
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    notice = Notice()
    event.register(KIND, notice)
    try:
        yield
    finally:
        event.unregister(KIND, notice)
