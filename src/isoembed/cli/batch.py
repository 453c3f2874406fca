"""Commands with many tasks: workers or clusters, a progress display and a summary."""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from isoembed.cli.console import NOT_EMBEDDED, OK, WRONG, is_terminal, print_error
from isoembed.cli.waiting import suspended
from isoembed.io import FileError
from isoembed.runs import Outcome, Result, Shard, Store, Task, Wish, Workers, run
from isoembed.runs.cluster import dask_workers
from isoembed.runs.result import REFUSED
from isoembed.runs.run import chunk_of

TOLD = 10  # failures printed; the table contains all


@dataclass
class Tally:
    """Counts of the results of a run so far.

    Attributes
    ----------
    total : int
        Number of tasks.
    statuses : Counter of str
        Number of results of each status.
    computed : int
        Number of newly computed results.
    failures, complaints : list of str
        Tasks without an answer, with reasons; errors in storing results.
    """

    total: int
    statuses: Counter[str] = field(default_factory=Counter)
    computed: int = 0
    failures: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def add(self, outcome: Outcome) -> None:
        """Count one outcome."""
        result = outcome.result
        self.statuses[result.status] += 1
        self.computed += outcome.computed
        if not result.answered:
            self.failures.append(f"{result.label}: {result.message}")
        if outcome.complaint:
            self.complaints.append(outcome.complaint)

    @property
    def done(self) -> int:
        """Number of tasks with a result."""
        return self.statuses.total()

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return {
            **{"done": self.done, "of": self.total, "computed": self.computed},
            **{"statuses": dict(self.statuses), "failures": self.failures, "not_kept": self.complaints},
        }

    def __str__(self) -> str:
        statuses = ", ".join(f"{number:,} {status}" for status, number in self.statuses.most_common())
        before = f"; {self.done - self.computed:,} were there" if self.computed < self.done else ""
        return f"{self.done:,} of {self.total:,}: {statuses or 'none'}{before}"

    @property
    def exit_status(self) -> int:
        """Exit status of the command: 0 if all tasks have an answer."""
        if self.complaints or (self.failures and self.statuses[REFUSED] == self.done):
            return WRONG
        return NOT_EMBEDDED if self.failures else OK


def carried_out(
    tasks: Sequence[Task],
    store: Store,
    options: argparse.Namespace,
    hear: Callable[[Result], None] | None = None,
) -> Tally:
    """Run tasks as specified by the options, and report failures.

    Parameters
    ----------
    tasks : sequence of Task
    store : Store
    options : argparse.Namespace
        Options of `add_run_options`, and ``quiet``.
    hear : callable, optional
        Called with every result as it becomes available.

    Raises
    ------
    KeyboardInterrupt
        Interrupted by Ctrl-C; finished results are kept.
    """
    shard, size = Shard(*options.shard or (1, 1)), options.chunk or chunk_of(len(tasks))
    mine = [task for k, task in enumerate(tasks) if k // size % shard.of == shard.number - 1]
    tally = Tally(len(mine))
    try:
        with suspended(options), _executor(options) as executor, _view(tally, quiet=options.quiet) as show:
            wish = Wish(again=options.force, retry=options.retry)
            for outcome in run(tasks, store=store, executor=executor, chunk=size, shard=shard, wish=wish):
                tally.add(outcome)
                show()
                try:
                    if hear is not None:
                        hear(outcome.result)
                except FileError as error:  # a full disk: other tasks continue
                    tally.complaints.append(str(error))
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted: {tally}; the same command continues with the rest") from None
    print_failures(tally)
    for complaint in tally.complaints[:1]:
        more = f" ({len(tally.complaints):,} results could not be saved)" if len(tally.complaints) > 1 else ""
        print_error(f"{complaint}{more}")
    return tally


def print_failures(tally: Tally) -> None:
    """Print the first tasks without an answer, with reasons."""
    for failure in tally.failures[:TOLD]:
        print_error(failure)
    if len(tally.failures) > TOLD:
        print_error(f"{len(tally.failures) - TOLD:,} more failed: see the table for the reasons")


@contextmanager
def _executor(options: argparse.Namespace) -> Iterator[Executor]:
    if options.scheduler is not None:
        with dask_workers(options.scheduler) as executor:
            yield executor
        return
    workers = Workers(options.jobs)
    try:
        yield workers
    except BaseException:
        workers.shutdown(wait=False, cancel_futures=True)
        raise
    workers.shutdown()


@contextmanager
def _view(tally: Tally, *, quiet: bool) -> Iterator[Callable[[], None]]:
    """Live progress line on a terminal, with the estimated remaining time."""
    if quiet or not is_terminal(sys.stderr):
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        line = progress.add_task("", total=tally.total)

        def show() -> None:
            without = len(tally.failures)
            description = f"{without:,} without an answer" if without else ""
            progress.update(line, completed=tally.done, description=description)

        yield show


def seen_by_all(options: argparse.Namespace, paths: Sequence[str | Path]) -> list[str]:
    """Paths visible to the worker processes; absolute for a cluster."""
    return [str(Path(path).absolute() if options.scheduler else path) for path in paths]
