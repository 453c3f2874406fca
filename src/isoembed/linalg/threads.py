"""Threads for compiled loops, which hold no lock of the interpreter."""

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def thread_count() -> int:
    """``OMP_NUM_THREADS``, if it is a positive number; otherwise how many cores this process may use.

    One in the processes of a pool, which take the cores already.
    """
    given = os.environ.get("OMP_NUM_THREADS", "")
    if given.isdecimal() and int(given) > 0:
        return int(given)
    if multiprocessing.parent_process() is not None:
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def in_threads(task: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """What a task makes of each item, in their order; by as many threads as are of use."""
    count = min(thread_count(), len(items))
    if count < 2:
        return [task(item) for item in items]
    with ThreadPoolExecutor(count) as executor:
        return list(executor.map(task, items))
