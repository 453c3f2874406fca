"""Task tree of a parallel multifrontal factorization: subtrees of the elimination tree, and ancestors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.linalg.fronts import largest_room
from isoembed.linalg.supernodes import Supernodes, stack_size
from isoembed.threads import TaskGraph

SMALL = 2.0**24
"""Multiplications up to which a matrix is one task: a thread starts in the time of a hundredth of them."""
SHARES = 12
"""A subtree is divided further if its work is more than this part of the whole."""


@dataclass(frozen=True, eq=False)
class Task:
    """Supernodes that one thread eliminates, one after the other.

    Attributes
    ----------
    first, last : int
        The first of them, and the one after the last.
    roots : tuple of int
        The supernodes in other tasks that pass on to these, in their order.
    """

    first: int
    last: int
    roots: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class TaskTree:
    """The tasks of a factorization, each after those that it depends on.

    They depend on the pattern alone, so that all sums are the same for any number of threads.
    """

    nodes: Supernodes
    tasks: tuple[Task, ...]

    @classmethod
    def of(cls, nodes: Supernodes) -> TaskTree:
        """Divide the supernodes, unless the matrix is small."""
        ends = np.concatenate(([0.0], np.cumsum(_work(nodes))))
        count = len(nodes.parents)
        if ends[-1] <= SMALL:
            return cls(nodes, (Task(0, count, ()),))
        below = ends[1:] - ends[nodes.leaves]  # work of each subtree
        divided = below > ends[-1] / SHARES
        undivided = ~divided & ((nodes.parents < 0) | divided[nodes.parents])  # as large as may be
        roots: list[list[int]] = [[] for _ in range(count + 1)]  # the last one of no parent
        tasks: list[Task] = []
        for s in np.flatnonzero(divided | undivided).tolist():
            if undivided[s]:
                tasks.append(Task(int(nodes.leaves[s]), s + 1, ()))
            elif roots[s] == [s - 1] and divided[s - 1]:  # a chain
                tasks[-1] = Task(tasks[-1].first, s + 1, tasks[-1].roots)
            else:
                tasks.append(Task(s, s + 1, tuple(roots[s])))
            roots[nodes.parents[s]].append(s)
        return cls(nodes, tuple(tasks))

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """The tasks that each depends on, in the order of their roots."""
        place = {task.last - 1: t for t, task in enumerate(self.tasks)}
        return tuple(tuple(place[root] for root in task.roots) for task in self.tasks)

    @cached_property
    def upward(self) -> TaskGraph:
        """Each task after its children."""
        return TaskGraph(self.children)

    @cached_property
    def downward(self) -> TaskGraph:
        """Each task before its children."""
        above: list[tuple[int, ...]] = [()] * len(self.tasks)
        for t, children in enumerate(self.children):
            for child in children:
                above[child] = (t,)
        return TaskGraph(above)

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Entries of the stack of each task."""
        return tuple(
            stack_size(self.nodes, task.first, task.last, sum(map(self.passed, task.roots)))
            for task in self.tasks
        )

    @cached_property
    def rooms(self) -> tuple[int, ...]:
        """Entries of the room of each task for products of matrices."""
        return tuple(largest_room(self.nodes, task.first, task.last) for task in self.tasks)

    def passed(self, s: int) -> int:
        """Entries that a supernode passes on to its parent."""
        below = int(self.nodes.ends[s + 1] - self.nodes.ends[s])
        return below * (below + 1) // 2

    @cached_property
    def room(self) -> int:
        """Entries of the fronts that exist at once at most, where tasks are done one after the other."""
        room = waiting = 0
        for task, size in zip(self.tasks, self.sizes, strict=True):
            room = max(room, waiting + size)
            waiting += self.passed(task.last - 1) - sum(map(self.passed, task.roots))
        return room


def _work(nodes: Supernodes) -> Floats:
    """Multiplications in the front of each supernode."""
    k, below = np.diff(nodes.starts).astype(float), np.diff(nodes.ends).astype(float)
    m = k + below
    return np.asarray(0.5 * k * (m * m - m * k + k * k / 3.0))
