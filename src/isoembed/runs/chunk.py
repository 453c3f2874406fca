"""Execution of a chunk of tasks in one process, and the rerun policy."""

from __future__ import annotations

import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.runs.result import FAILED, REFUSED, Result
from isoembed.runs.store import Store
from isoembed.runs.task import Task, key_of
from isoembed.threads import reserve_threads

MEMORY = "not enough memory"


@dataclass(frozen=True)
class Wish:
    """Rerun policy: which tasks with stored results are recomputed.

    Attributes
    ----------
    again : bool
        Whether to recompute all of them.
    retry : bool
        Whether to recompute those without an answer.
    """

    again: bool = False
    retry: bool = False


MISSING = Wish()
"""Policy that computes only tasks without stored results."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of a task, and how it was obtained.

    Attributes
    ----------
    result : Result
    computed : bool
        Whether it was computed, rather than taken from the store.
    seconds : float
        Time taken.
    complaint : str
        Reason why it could not be stored.
    """

    result: Result
    computed: bool
    seconds: float = 0.0
    complaint: str = ""


def solve_chunk(tasks: Sequence[Task], store: Store | None, wish: Wish) -> list[Outcome]:
    """See `solved`."""
    return list(solved(tasks, store, wish))


def solved(tasks: Sequence[Task], store: Store | None, wish: Wish) -> Iterator[Outcome]:
    """Outcomes of the tasks of a chunk; each task may start from the previous answer."""
    before: Result | None = None
    for task in tasks:
        outcome = _outcome(task, before, store, wish)
        if outcome.result.answered:
            before = outcome.result
        yield outcome


def _outcome(task: Task, before: Result | None, store: Store | None, wish: Wish) -> Outcome:
    start = perf_counter()
    if store is None:
        return Outcome(_computed(task, before), computed=True, seconds=perf_counter() - start)
    unreadable = None
    try:
        key = key_of(task.digest())
    except (FileError, InvalidParameter) as error:
        key = key_of(str(error))
        unreadable = Result.without_answer(task.label, REFUSED, str(error), **task.facts)
    except MemoryError:
        key = key_of(MEMORY)
        unreadable = Result.without_answer(task.label, FAILED, MEMORY, **task.facts)
    found = None if wish.again else store.find(task.label, key)
    if found is not None and (found.answered or not wish.retry):
        return Outcome(found, computed=False, seconds=perf_counter() - start)
    outcome = stored(unreadable or _computed(task, before), key, store)
    return replace(outcome, seconds=perf_counter() - start)


def stored(result: Result, key: str, store: Store) -> Outcome:
    """Outcome of a computed result, which is stored if possible."""
    try:
        store.keep(result, key)
    except FileError as error:
        return Outcome(result, computed=True, complaint=str(error))
    return Outcome(result, computed=True)


def _computed(task: Task, before: Result | None) -> Result:
    try:
        with reserve_threads(1):  # the processes share the cores
            return task.compute(before)
    except MemoryError:
        return Result.without_answer(task.label, FAILED, MEMORY, **task.facts)
    except Exception as error:  # a bug: stored with its traceback, without affecting other tasks
        message = f"{type(error).__name__}: {error}"
        where = {"traceback": traceback.format_exc()}
        return Result.without_answer(task.label, FAILED, message, **task.facts, **where)
