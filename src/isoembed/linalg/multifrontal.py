"""Multifrontal L D L^T factorization of sparse symmetric matrices.

The front of a supernode is a symmetric matrix on its columns and the rows below them: the sum of entries of A
and of what its children pass on. Its columns are eliminated, and what that leaves of the rows below is passed
on to its parent. As every supernode comes after its children, what waits for a parent lies on a stack (Duff,
Reid, The multifrontal solution of indefinite sparse symmetric linear, ACM Trans. Math. Softw. 9, 1983).

Pivots are taken down the diagonal, in the order given.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices32, Singles
from isoembed.linalg.fronts import eliminate, substitute_backward, substitute_forward
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.supernodes import Supernodes
from isoembed.linalg.tasks import TaskTree
from isoembed.threads import taken, thread_count


@dataclass(frozen=True, eq=False)
class Fronts:
    """A symmetric pattern in elimination order, and its supernodes.

    Attributes
    ----------
    indptr, indices : ndarray of int32
        The lower triangle in compressed columns with sorted rows.
    definite : bool
        Whether the matrices must be positive definite.
    tree : TaskTree
    """

    indptr: Indices32
    indices: Indices32
    definite: bool
    tree: TaskTree

    @property
    def nodes(self) -> Supernodes:
        """The supernodes."""
        return self.tree.nodes

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        nodes, tree = self.nodes, self.tree
        threads = min(thread_count(), len(tree.tasks))
        work = max(tree.rooms) + int(nodes.starts[-1])
        return 8 * (nodes.entries + tree.room + (threads - 1) * max(tree.sizes) + threads * work)

    def factor(self, data: Floats, *, single: bool = False) -> "FrontalFactors":
        """Factorize the matrix with these entries, and keep the factors in single precision if asked to.

        Without exchanges single precision is stable for definite matrices only: the factors of others are
        rounded in the end, and substituted in double precision.

        Raises
        ------
        SingularMatrix
            A pivot is zero, or negative where the matrices must be definite.
        """
        count, tree = self.nodes.entries, self.tree
        L: Floats | Singles = np.empty(count, dtype=np.float32) if single else np.empty(count)
        precision = L.dtype if self.definite else np.dtype(np.float64)
        least = 0.0 if self.definite else -np.inf
        passed: dict[int, Floats | Singles] = {}
        negative = [0] * len(tree.tasks)
        spare: list[Floats | Singles] = []  # arrays for the next tasks: new ones would be cleared first

        def run(t: int) -> None:
            work, size = taken(spare), tree.sizes[t]
            if work is None or work.size < size + tree.rooms[t]:
                work = np.empty(size + tree.rooms[t], dtype=precision)
            stack, room = work[:size], work[size:]
            if tree.children[t]:
                begin = sum(map(tree.passed, tree.tasks[t].roots))
                np.concatenate([passed.pop(child) for child in tree.children[t]], out=stack[:begin])
            task = tree.tasks[t]
            negative[t] = eliminate(self, task, data, L, stack, room, least)
            if negative[t] < 0:
                if self.definite:
                    raise SingularMatrix("the matrix is not positive definite")
                raise SingularMatrix("the matrix has no factors L D L^T in this order")
            passed[t] = stack[: tree.passed(task.last - 1)].copy()
            spare.append(work)

        tree.upward.run(run)
        return FrontalFactors(tree, L, precision, sum(negative))


@dataclass(frozen=True, eq=False)
class FrontalFactors:
    """The factors of one matrix: the trapezoids of its supernodes one after the other, in each D and L."""

    _tree: TaskTree
    _L: Floats | Singles
    _precision: np.dtype[Any]  # of substitutions
    negative_pivots: int

    def solve(self, b: Floats) -> Floats:
        """Solve for b (n,) or (n, k)."""
        if self._precision == np.float64:
            return self._substituted(b)
        size = np.abs(b).max(axis=0, initial=0.0)  # numbers of single precision have a small range
        scale = np.ldexp(1.0, np.frexp(size)[1].clip(-1000, 1000))
        return np.asarray(self._substituted(b / scale).astype(np.float64) * scale)

    def _substituted(self, b: Floats) -> Floats:
        tree, L = self._tree, self._L
        x = np.array(b.T, dtype=self._precision, order="C", ndmin=2)
        tails: dict[int, Floats | Singles] = {}

        def forward(t: int) -> None:
            passed = [tails.pop(child) for child in tree.children[t]]
            tails[t] = substitute_forward(tree.nodes, tree.tasks[t], L, x, passed)

        def backward(t: int) -> None:
            substitute_backward(tree.nodes, tree.tasks[t], L, x)

        tree.upward.run(forward)
        tree.downward.run(backward)
        return np.asarray(x.reshape(b.T.shape).T)
