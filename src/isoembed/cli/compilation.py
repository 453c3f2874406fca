"""The first run of a command compiles its functions, which takes a minute: whoever watches is told."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from isoembed.cli.screen import print_error
from isoembed.progress.compiling import COMPILING

PATIENCE = 2.0  # seconds


class _Notice:
    """Says once that functions are being compiled, when that has taken some time."""

    def __init__(self) -> None:
        self._before, self._said = COMPILING.seconds, False

    def __call__(self) -> None:
        if not self._said and COMPILING.seconds > self._before + PATIENCE:
            self._said = True
            print_error("functions are being compiled, once, which takes some seconds", "note")


@contextmanager
def compilation_said(quiet: bool) -> Iterator[None]:
    """Say so on a terminal, if the block compiles."""
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    notice = _Notice()
    COMPILING.watchers.append(notice)
    try:
        yield
    finally:
        COMPILING.watchers.remove(notice)
