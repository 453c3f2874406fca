"""Multithreading of loops that release the global interpreter lock (GIL): task graphs, and parts of ranges.

There are as many threads as BLAS may use, up to eight: `OMP_NUM_THREADS` and
``threadpoolctl.threadpool_limits`` set their number. No result depends on it: work is divided in the same way
for any number of threads.

While they run, BLAS has one thread: the threads of OpenBLAS share vectors that are too short for that, and
wait for more work in a loop.  It can be limited in the main thread only; in others nothing is divided.
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

from threadpoolctl import ThreadpoolController

MAX_THREADS = 8  # elimination trees of surfaces have no work for more

_LIBRARIES = ("OPENBLAS", "MKL", "BLIS")  # that may be BLAS

_reserved: ContextVar[int | None] = ContextVar("_reserved", default=None)


def thread_count() -> int:
    """Number of threads available to `TaskGraph.run`; 1 outside the main thread."""
    if not _in_main_thread():
        return 1
    reserved = _reserved.get()
    if reserved is not None:
        return reserved
    numbers = [library.num_threads for library in _blas().lib_controllers]
    return min([*(numbers or [_wanted()]), MAX_THREADS])


def reserve_threads_of_process() -> None:
    """Limit BLAS to one thread for a whole process, in which NumPy has not been imported yet."""
    _reserved.set(min(_wanted(), MAX_THREADS))
    for name in _LIBRARIES:
        os.environ[f"{name}_NUM_THREADS"] = "1"


@contextmanager
def reserve_threads(count: int | None = None) -> Iterator[None]:
    """Limit BLAS to one thread and reserve the cores for `TaskGraph.run`, with `count` threads at most."""
    limited = _reserved.get() is not None or not _in_main_thread()
    before = _reserved.set(thread_count() if count is None else count)
    try:
        with nullcontext() if limited else _blas().limit(limits=1):
            yield
    finally:
        _reserved.reset(before)


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
        """Run all tasks, several at once, and none after one has failed."""
        # The cores may be reserved already, for thousands of short runs.
        with reserve_threads() if _reserved.get() is None else nullcontext():
            threads = min(thread_count(), len(self.before)) if len(self.before) > 1 else 1
            if threads <= 1:
                for t in self.order:
                    task(t)
            else:
                _Run(self, task).share(threads)

    @cached_property
    def order(self) -> list[int]:
        """The order in which one thread runs them."""
        order: list[int] = []
        _Run(self, order.append).work(0)
        return order


class _Run:
    """State of a run, shared by its threads."""

    def __init__(self, graph: TaskGraph, task: Callable[[int], object]) -> None:
        self._task = task
        self._missing = [len(before) for before in graph.before]
        self._after: list[list[int]] = [[] for _ in graph.before]
        for t, before in enumerate(graph.before):
            for earlier in before:
                self._after[earlier].append(t)
        self._ready = [t for t, missing in enumerate(self._missing) if missing == 0]
        self._waiting = len(self._missing)  # tasks not begun
        self._changed = threading.Condition()
        self._failure: BaseException | None = None

    def share(self, count: int) -> None:
        """Run all tasks in new threads.

        The main thread only waits, as signals may interrupt it anywhere.
        """
        last = len(self._missing) - 1
        threads = [threading.Thread(target=self.work, args=(k * last / (count - 1),)) for k in range(count)]
        try:
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        except BaseException as error:
            self._end(error)
            for thread in threads:
                if thread.ident is not None:
                    thread.join()
            raise
        failure, self._failure = self._failure, None
        if failure is not None:
            try:
                raise failure
            finally:
                del failure  # whose traceback has this frame

    def work(self, place: float) -> None:
        """Run tasks until none is left, those whose numbers are near to a place first."""
        try:
            while (t := self._next(place)) is not None:
                self._task(t)
                self._finish(t)
        except BaseException as error:
            self._end(error)

    def _next(self, place: float) -> int | None:
        with self._changed:
            while not self._ready and self._waiting:
                self._changed.wait()
            if not self._waiting:
                return None
            t = min(self._ready, key=lambda t: abs(t - place))
            self._ready.remove(t)
            self._waiting -= 1
            return t

    def _finish(self, t: int) -> None:
        with self._changed:
            for later in self._after[t]:
                self._missing[later] -= 1
                if self._missing[later] == 0:
                    self._ready.append(later)
            self._changed.notify_all()

    def _end(self, error: BaseException) -> None:
        with self._changed:
            self._failure = self._failure or error
            self._waiting = 0
            self._changed.notify_all()
