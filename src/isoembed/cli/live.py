"""The live view of a running computation: one line a stage, on standard error."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from isoembed.stages import Listener, Progress

if TYPE_CHECKING:
    from rich.table import Table

FRAMES_A_SECOND = 8


class StageTable:
    """The last snapshot of every stage, in the order in which they began."""

    def __init__(self) -> None:
        self._stages: dict[str, tuple[float, Progress]] = {}

    def listen(self, progress: Progress) -> None:
        """Take a snapshot in."""
        start, _ = self._stages.get(progress.stage, (progress.seconds, progress))
        self._stages[progress.stage] = (start, progress)

    def __rich__(self) -> Table:
        from rich.table import Table

        table = Table(box=None, pad_edge=False, header_style="dim")
        table.add_column("stage", style="bold")
        for heading in ("iteration", "t", "residual", "inverted", "partially", "seconds"):
            table.add_column(heading, justify="right")
        for name, (start, last) in tuple(self._stages.items()):
            table.add_row(
                name,
                str(last.iteration),
                "" if last.t is None else f"{last.t:.3f}",
                "" if last.residual is None else f"{last.residual:.1e}",
                _count(last.inverted),
                _count(last.partially_inverted),
                f"{last.seconds - start:.1f}",
            )
        return table


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
        yield table.listen
