"""Worker processes, isolated from each other's crashes."""

from __future__ import annotations

import multiprocessing
import os
import queue
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

T = TypeVar("T")
PATIENCE = 10.0  # seconds for the start of a process


class Workers(Executor):
    """An executor of processes, each in its own pool.

    In a single pool, a process killed by the system, for example when memory runs out, ends all running
    tasks without identifying the one responsible.  Here only the future of the killed process fails, with
    `concurrent.futures.process.BrokenProcessPool`, and the process is replaced.

    `submit` blocks while all processes are busy, which limits memory.  Processes are spawned on first use,
    and end with the parent process in all cases.

    Parameters
    ----------
    jobs : int, optional
        Number of processes; by default one per core available to this process.
    """

    def __init__(self, jobs: int | None = None) -> None:
        self._idle: queue.SimpleQueue[_Worker] = queue.SimpleQueue()
        self._all = [_Worker() for _ in range(jobs or cores())]
        for worker in self._all:
            self._idle.put(worker)

    def submit(self, function: Callable[..., T], /, *args: Any, **options: Any) -> Future[T]:
        """See `concurrent.futures.Executor.submit`."""
        worker = self._idle.get()
        try:
            future = worker.submit(function, *args, **options)
        except BaseException:
            self._idle.put(worker)
            raise
        future.add_done_callback(lambda _: self._idle.put(worker))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes, immediately if futures are to be canceled."""
        for worker in self._all:
            worker.end(wait=wait, at_once=cancel_futures)


class _Worker:
    """A pool of one process, recreated after the process is killed."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._number: Future[int] | None = None

    def submit(self, function: Callable[..., T], /, *args: Any, **options: Any) -> Future[T]:
        if self._pool is not None:
            try:
                return self._pool.submit(function, *args, **options)
            except BrokenExecutor:  # killed
                self._pool.shutdown()
        self._pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
        with _interruptions_ignored():
            self._number = self._pool.submit(os.getpid)
        return self._pool.submit(function, *args, **options)

    def end(self, *, wait: bool, at_once: bool) -> None:
        if self._pool is None or self._number is None:
            return
        if at_once:
            with suppress(BrokenExecutor, TimeoutError, ProcessLookupError):
                os.kill(self._number.result(PATIENCE), signal.SIGTERM)  # as soon as it has started
        self._pool.shutdown(wait=wait, cancel_futures=at_once)


def cores() -> int:
    """Number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _interruptions_ignored() -> Iterator[None]:
    """Start child processes that ignore Ctrl-C, by inheritance of the ignored signal."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _begin() -> None:
    """Initialize a process: ignore Ctrl-C, which the parent handles, and end with the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
