"""Scheduling of a run's tasks: chunks, shards for several machines, restarts after killed processes."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass
from itertools import islice

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.runs.chunk import MISSING, Outcome, Wish, solve_chunk, solved, stored
from isoembed.runs.result import FAILED, Result
from isoembed.runs.store import Store
from isoembed.runs.task import Task, key_of

CHUNK = 8  # tasks: the first task of a chunk has no predecessor to start from


@dataclass(frozen=True)
class Shard:
    """One part of a run, for array jobs of a batch system.

    Attributes
    ----------
    number, of : int
        Number of the part, from 1, and number of parts.
    """

    number: int = 1
    of: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.of:
            raise InvalidParameter(f"shard number must be from 1 to {self.of}, not {self.number}")


WHOLE = Shard()


def run(
    tasks: Iterable[Task],
    *,
    store: Store | None = None,
    executor: Executor | None = None,
    chunk: int = CHUNK,
    shard: Shard = WHOLE,
    wish: Wish = MISSING,
) -> Iterator[Outcome]:
    """Run tasks, and yield their outcomes as available; outcomes of a chunk are in order.

    Parameters
    ----------
    tasks : iterable of Task
    store : Store, optional
        Store of results; tasks with stored results are not recomputed.
    executor : concurrent.futures.Executor, optional
        By default the tasks run sequentially in this process.  If the process of a chunk is killed, the chunk
        is rerun once; after a second failure, its tasks are run separately.
    chunk : int
        Number of consecutive tasks that start from each other; stored results of a chunk are used, so that
        an interrupted run has the same results.
    shard : Shard
        Part of the chunks to run.
    wish : Wish
        Rerun policy for tasks with stored results.

    Raises
    ------
    InvalidParameter
        The chunk size is not positive, or the executor, such as a lost cluster, cancels running tasks.
    """
    if chunk < 1:
        raise InvalidParameter(f"chunk must be at least 1, not {chunk}")
    mine = islice(_chunks(tasks, chunk), shard.number - 1, None, shard.of)
    if executor is None:
        for part in mine:
            yield from solved(part, store, wish)
        return
    under_way: dict[Future[list[Outcome]], _Attempt] = {}

    def begin(attempt: _Attempt) -> None:
        under_way[executor.submit(solve_chunk, attempt.tasks, store, wish)] = attempt

    for part in mine:
        begin(_Attempt(part))
        yield from _finished(under_way, begin, store, timeout=0)
    while under_way:
        yield from _finished(under_way, begin, store, timeout=None)


@dataclass(frozen=True)
class _Attempt:
    """Tasks executed together, and the number of times their process was lost."""

    tasks: tuple[Task, ...]
    deaths: int = 0


def _finished(
    under_way: dict[Future[list[Outcome]], _Attempt],
    begin: Callable[[_Attempt], None],
    store: Store | None,
    timeout: float | None,
) -> Iterator[Outcome]:
    """Outcomes of finished chunks; chunks whose process was lost are resubmitted."""
    for future in wait(under_way, timeout, FIRST_COMPLETED).done:
        attempt = under_way.pop(future)
        if future.cancelled():
            raise InvalidParameter("the executor canceled the running tasks; finished results are kept")
        error = future.exception()
        if error is None:
            yield from future.result()
        elif attempt.deaths == 0:
            begin(_Attempt(attempt.tasks, deaths=1))
        elif len(attempt.tasks) > 1:
            for task in attempt.tasks:
                begin(_Attempt((task,), deaths=1))
        else:
            yield _aborted(attempt.tasks[0], error, store)


def _aborted(task: Task, error: BaseException, store: Store | None) -> Outcome:
    """Outcome of a task that cannot be sent to a process, or whose process was lost twice."""
    why = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, BrokenExecutor):
        why = (
            "the system ended its process, and that of a second attempt: most likely memory ran out, "
            "or the task is defined in a module that it cannot import"
        )
    sent = not (isinstance(error, pickle.PicklingError) or "pickle" in why)
    if not sent:
        why = (
            "it cannot be sent to another process, which requires functions defined at the top level "
            f"of a module: {why}; without an executor, any function works"
        )
    result = Result.without_answer(task.label, FAILED, why, **task.facts)
    if store is None or not sent:  # a task that cannot be sent may still be computed in this process
        return Outcome(result, computed=True)
    try:
        key = key_of(task.digest())
    except (FileError, InvalidParameter, MemoryError):
        key = key_of(why)
    return stored(result, key, store)


def chunk_of(tasks: int) -> int:
    """Chunk size for a number of tasks; independent of anything else, for reproducible results."""
    return min(max(tasks // 8, 1), CHUNK)  # eight chunks of a short run occupy many processes


def _chunks(tasks: Iterable[Task], size: int) -> Iterator[tuple[Task, ...]]:
    left = iter(tasks)
    while part := tuple(islice(left, size)):
        yield part
