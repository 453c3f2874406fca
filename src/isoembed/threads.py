"""Multithreading of loops that release the global interpreter lock (GIL): task graphs, and parts of ranges.

There are as many threads as BLAS may use, up to eight: `OMP_NUM_THREADS` and
``threadpoolctl.threadpool_limits`` set their number. No result depends on it: work is divided in the same way
for any number of threads.

While they run, BLAS has one thread: the threads of OpenBLAS share vectors that are too short for that, and
wait for more work in a loop.  It can be limited in the main thread only; in others nothing is divided.

A task may run a graph of its own, of which threads that have no task do a part: the last fronts of an
elimination tree are the largest, and wait for one another.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from typing import TypeVar

from threadpoolctl import ThreadpoolController

T = TypeVar("T")

MAX_THREADS = 8  # elimination trees of surfaces have no work for more

_LIBRARIES = ("OPENBLAS", "MKL", "BLIS")  # that may be BLAS

_reserved: ContextVar[_Team | None] = ContextVar("_reserved", default=None)


def thread_count() -> int:
    """Number of threads available to `TaskGraph.run`: in the main thread and within its tasks, or else 1."""
    team = _member.team or (_reserved.get() if _in_main_thread() else None)
    if team is not None:
        return team.count
    if not _in_main_thread():
        return 1
    numbers = [library.num_threads for library in _blas().lib_controllers]
    return min([*(numbers or [_wanted()]), MAX_THREADS])


def reserve_threads_of_process() -> None:
    """Limit BLAS to one thread for a whole process, in which NumPy has not been imported yet."""
    _reserved.set(_Team(min(_wanted(), MAX_THREADS)))
    for name in _LIBRARIES:
        os.environ[f"{name}_NUM_THREADS"] = "1"


@contextmanager
def reserve_threads(count: int | None = None) -> Iterator[None]:
    """Limit BLAS to one thread and reserve the cores for `TaskGraph.run`, with `count` threads at most.

    The threads are started when they are needed first, and end with the reservation.
    """
    outer = _reserved.get()
    if outer is not None and count in (None, outer.count):
        yield
        return
    team = _Team(thread_count() if count is None else count)
    before = _reserved.set(team)
    try:
        with nullcontext() if outer is not None or not _in_main_thread() else _blas().limit(limits=1):
            yield
    finally:
        _reserved.reset(before)
        team.end()


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _wanted() -> int:
    """Number of threads in the first environment variable that is set, or of available cores."""
    for name in ("OMP", *_LIBRARIES):
        number = os.environ.get(f"{name}_NUM_THREADS", "").split(",")[0]
        if number.isdecimal() and int(number) > 0:
            return int(number)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _blas() -> ThreadpoolController:
    """BLAS of NumPy and of SciPy, which may be the same library."""
    import_module("scipy.linalg")  # loads both
    return ThreadpoolController().select(user_api="blas")


def run_ranges(task: Callable[[range], object], count: int, fewest: int) -> None:
    """Run a task on parts of a range in parallel.

    Parameters
    ----------
    task : callable
        Its results must not depend on how the range is divided.
    count : int
        Length of the range.
    fewest : int
        Minimum length of a part.
    """
    threads = thread_count()
    parts = max(1, min(4 * threads if threads > 1 else 1, count // fewest))  # four: some finish early
    ends = [count * k // parts for k in range(parts + 1)]
    TaskGraph([()] * parts).run(lambda k: task(range(ends[k], ends[k + 1])))


def taken(spare: list[T]) -> T | None:
    """Take an item out of a list that other threads change, too; None if it is empty."""
    try:
        return spare.pop()
    except IndexError:
        return None


@dataclass(frozen=True, eq=False)
class TaskGraph:
    """Tasks, some of which must be done before others.

    A thread begins with tasks whose numbers are near to its own part of them.

    Attributes
    ----------
    before : sequence of sequence of int
        The tasks that each depends on.
    """

    before: Sequence[Sequence[int]]

    def run(self, task: Callable[[int], object]) -> None:
        """Run all tasks, several at once, and none after one has failed.

        Within a task of another run the threads of that run take part.
        """
        if len(self.before) > 1 and _member.team is not None:
            _member.team.join(_Run(self, task))
            return
        with reserve_threads():
            team = _reserved.get()
            if len(self.before) > 1 and team is not None and thread_count() > 1:
                team.share(_Run(self, task))
            else:
                for t in self.order:
                    task(t)

    @cached_property
    def order(self) -> list[int]:
        """The order in which one thread runs them."""
        run, order = _Run(self, lambda t: None), []
        while run.ready:
            order.append(run.begin(0.0))
            run.finish(order[-1])
        return order


class _Run:
    """State of a run."""

    def __init__(self, graph: TaskGraph, task: Callable[[int], object]) -> None:
        self.task = task
        self._missing = [len(before) for before in graph.before]
        self._after: list[list[int]] = [[] for _ in graph.before]
        for t, before in enumerate(graph.before):
            for earlier in before:
                self._after[earlier].append(t)
        self.ready = [t for t, missing in enumerate(self._missing) if missing == 0]
        self.ended = threading.Event()
        self._running = 0
        self._unfinished = len(self._missing)
        self._failure: BaseException | None = None

    def begin(self, place: float) -> int:
        """Take the ready task whose number is nearest to a place between 0 and 1."""
        at = place * (len(self._missing) - 1)
        t = min(self.ready, key=lambda t: abs(t - at))
        self.ready.remove(t)
        self._running += 1
        return t

    def finish(self, t: int) -> None:
        """Note that a task is done or has failed: others may be ready, or none may be left."""
        self._running -= 1
        self._unfinished -= 1
        for later in self._after[t]:
            self._missing[later] -= 1
            if self._missing[later] == 0 and self._failure is None:
                self.ready.append(later)
        self._check_end()

    def fail(self, error: BaseException) -> None:
        """Begin no more tasks."""
        self._failure = self._failure or error
        self.ready = []
        self._check_end()

    def raise_failure(self) -> None:
        """Raise what a task has raised."""
        failure, self._failure = self._failure, None
        if failure is not None:
            try:
                raise failure
            finally:
                del failure  # whose traceback has this frame

    def _check_end(self) -> None:
        if self._unfinished == 0 or (self._failure is not None and self._running == 0):
            self.ended.set()


class _Member(threading.local):
    """The team of a thread, and its place in it."""

    team: _Team | None = None
    place = 0.0


_member = _Member()


class _Team:
    """Threads that share the tasks of a run, and of runs within these."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._threads: list[threading.Thread] = []
        self._runs: list[_Run] = []  # that have not ended, inner ones last
        self._changed = threading.Condition()
        self._ended = False

    def share(self, run: _Run) -> None:
        """Run all tasks; the main thread only waits, as signals may interrupt it anywhere."""
        try:
            for k in range(len(self._threads), self.count):
                thread = threading.Thread(target=self._work, args=(k,), daemon=True)
                thread.start()
                self._threads.append(thread)
            self._add(run)
            run.ended.wait()
        except BaseException as error:
            with self._changed:
                run.fail(error)
            run.ended.wait()  # for tasks that have begun
            raise
        finally:
            self._remove(run)
        run.raise_failure()

    def join(self, run: _Run) -> None:
        """Run all tasks within a task: threads that have no other take some."""
        self._add(run)
        self._take_part(lambda: [run], run.ended.is_set)
        self._remove(run)
        run.raise_failure()

    def end(self) -> None:
        """End the threads."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        for thread in self._threads:
            thread.join()

    def _add(self, run: _Run) -> None:
        with self._changed:
            self._runs.append(run)
            self._changed.notify_all()

    def _remove(self, run: _Run) -> None:
        with self._changed:
            self._runs = [other for other in self._runs if other is not run]

    def _work(self, k: int) -> None:
        _member.team, _member.place = self, k / (self.count - 1)
        self._take_part(lambda: self._runs[::-1], lambda: self._ended)

    def _take_part(self, runs: Callable[[], list[_Run]], over: Callable[[], bool]) -> None:
        """Run tasks of the first run that has any, and wait for more, until it is over."""
        while (begun := self._next(runs, over)) is not None:
            self._complete(*begun)
            del begun  # or it would live while the thread waits

    def _next(self, runs: Callable[[], list[_Run]], over: Callable[[], bool]) -> tuple[_Run, int] | None:
        with self._changed:
            while not over():
                run = next((each for each in runs() if each.ready), None)
                if run is not None:
                    return run, run.begin(_member.place)
                self._changed.wait()
        return None

    def _complete(self, run: _Run, t: int) -> None:
        try:
            run.task(t)
        except BaseException as error:
            with self._changed:
                run.fail(error)
        finally:
            with self._changed:
                run.finish(t)
                self._changed.notify_all()
