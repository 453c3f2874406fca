"""The live view of a running computation: one line a stage and the time left, on standard error."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from isoembed.progress.stages import Listener, Progress

if TYPE_CHECKING:
    from rich.table import Table

FRAMES_A_SECOND = 8
HEADINGS = ("stage", "iteration", "level", "t", "residual", "inverted", "partially", "seconds")


class StageTable:
    """The last snapshot of every stage, in the order in which they began, and the time left.

    Parameters
    ----------
    clock : callable
        The time in seconds: it goes on where a single step takes long.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._stages: dict[str, tuple[float, Progress]] = {}
        self._running: tuple[Progress, float] | None = None

    def listen(self, progress: Progress) -> None:
        """Take a snapshot in."""
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
        running = self._running  # of another thread's making
        if running is None or running[0].remaining is None:
            return None
        return f"about {duration(running[0].remaining - self._since(running[0]))} left"

    def _since(self, last: Progress) -> float:
        """Seconds since a snapshot came, if it is the last of all."""
        running = self._running
        return self._clock() - running[1] if running is not None and running[0] is last else 0.0


def duration(seconds: float) -> str:
    """Seconds in words, as exactly as an estimate deserves.

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
def live_view(show: bool) -> Iterator[Listener | None]:
    """Show the stages while the block runs.

    Parameters
    ----------
    show : bool
        Without it nothing is shown, and the computation has no listener.

    Yields
    ------
    callable or None
        What takes the snapshots.
    """
    if not show:
        yield None
        return
    from rich.console import Console
    from rich.live import Live

    table = StageTable()
    with Live(table, console=Console(stderr=True), refresh_per_second=FRAMES_A_SECOND):
        try:
            yield table.listen
        finally:
            table.finish()
