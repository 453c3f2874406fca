"""Live display of a running computation, one line per stage."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from isoembed.progress.stages import Listener, Progress

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

FRAMES_A_SECOND = 8
PAGES_A_SECOND = 2  # in a notebook, where each is a message to a browser
HEADINGS = ("stage", "iteration", "level", "t", "residual", "inverted", "partially", "seconds")


class StageTable:
    """Last snapshot of every stage, in order of their start, and the remaining time.

    Parameters
    ----------
    clock : callable
        Function that returns the time in seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._stages: dict[str, tuple[float, Progress]] = {}
        self._running: tuple[Progress, float] | None = None

    def listen(self, progress: Progress) -> None:
        """Process a snapshot."""
        start, _ = self._stages.get(progress.stage, (progress.seconds, progress))
        self._stages[progress.stage] = (start, progress)
        self._running = progress, self._clock()

    def finish(self) -> None:
        """Stop the clock."""
        if self._running is not None:
            last, _ = self._running
            start, _ = self._stages[last.stage]
            self._stages[last.stage] = (start, replace(last, seconds=last.seconds + self._since(last)))
            self._running = None

    def __rich__(self) -> Table:
        from rich.table import Table

        rows = [self._row(start, last) for start, last in tuple(self._stages.values())]
        columns = [column for column in zip(HEADINGS, *rows, strict=True) if any(column[1:])]
        table = Table(box=None, pad_edge=False, header_style="dim", caption_style="dim")
        table.caption, table.caption_justify = self._left(), "left"
        for heading, *_ in columns:
            left = heading == HEADINGS[0]
            table.add_column(heading, justify="left" if left else "right", style="bold" if left else None)
        for row in zip(*(cells for _, *cells in columns), strict=True):
            table.add_row(*row)
        return table

    def _row(self, start: float, last: Progress) -> tuple[str, ...]:
        return (
            last.stage,
            str(last.iteration),
            last.level or "",
            "" if last.t is None else f"{last.t:.3f}",
            "" if last.residual is None else f"{last.residual:.1e}",
            _count(last.inverted),
            _count(last.partially_inverted),
            f"{last.seconds - start + self._since(last):.1f}",
        )

    def _left(self) -> str | None:
        running = self._running  # may be set by another thread
        if running is None or running[0].remaining is None:
            return None
        return f"about {duration(running[0].remaining - self._since(running[0]))} left"

    def _since(self, last: Progress) -> float:
        """Seconds since a snapshot arrived, if it is the latest."""
        running = self._running
        return self._clock() - running[1] if running is not None and running[0] is last else 0.0


def duration(seconds: float) -> str:
    """Duration in words, rounded to the accuracy of an estimate.

    Parameters
    ----------
    seconds : float

    Examples
    --------
    >>> duration(7.2), duration(42), duration(100), duration(5000)
    ('8 s', '45 s', '2 min', '1 h 24 min')
    """
    if seconds <= 10:
        return f"{max(math.ceil(seconds), 1)} s"
    if seconds <= 55:
        return f"{5 * math.ceil(seconds / 5)} s"
    hours, minutes = divmod(math.ceil(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"


def _count(value: int | None) -> str:
    return "" if value is None else str(value)


@contextmanager
def bar(console: Console | None = None) -> Iterator[Listener]:
    """Live view of a running computation: its stages and approximate remaining time.

    Parameters
    ----------
    console : rich.console.Console, optional
        Output console; by default standard error, or the output of a notebook cell.  Without a terminal,
        only the final state is shown.

    Yields
    ------
    callable
        Listener for the ``progress`` argument of `isoembed.embed`.

    Examples
    --------
    ::

        with isoembed.progress.bar() as progress:
            surface = isoembed.embed(metric, progress=progress)
    """
    table = StageTable()
    if console is None and sys.stderr is None:
        yield table.listen
        return
    from rich.console import Console
    from rich.live import Live

    shown = console or Console(stderr=True)
    with _cell(table) if shown.is_jupyter else Live(table, console=shown, refresh_per_second=FRAMES_A_SECOND):
        try:
            yield table.listen
        finally:
            table.finish()


@contextmanager
def _cell(table: StageTable) -> Iterator[None]:
    """Show a table in the output of a notebook cell; rich's own live view requires ipywidgets."""
    from IPython.display import display  # type: ignore[import-not-found,unused-ignore]

    handle, over = display(table.__rich__(), display_id=True), threading.Event()

    def refresh() -> None:
        while not over.wait(1 / PAGES_A_SECOND):
            handle.update(table.__rich__())

    thread = threading.Thread(target=refresh, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        handle.update(table.__rich__())
