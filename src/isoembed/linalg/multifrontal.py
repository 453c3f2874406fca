"""Multifrontal L D L^T factorization of sparse symmetric matrices.

The front of a supernode is a symmetric matrix on its columns and the rows below them: the sum of entries of A
and of what its children pass on. Its columns are eliminated, and what that leaves of the rows below is passed
on to its parent. As every supernode comes after its children, what waits for a parent lies on a stack (Duff,
Reid, The multifrontal solution of indefinite sparse symmetric linear, ACM Trans. Math. Softw. 9, 1983).

Pivots are taken down the diagonal, in the order given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32, Singles
from isoembed.linalg.branches import Part, cut
from isoembed.linalg.fronts import back, eliminate, forward
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.supernodes import Supernodes
from isoembed.linalg.threads import in_threads, thread_count


class Fronts:
    """A symmetric pattern in elimination order, and its supernodes.

    Parameters
    ----------
    indptr, indices : ndarray of int32
        The lower triangle in compressed columns with sorted rows.
    definite : bool
        Whether the matrices must be positive definite.
    nodes : Supernodes

    Attributes
    ----------
    entries : int
        Of L, with the zeros that are stored.
    needs : int
        Bytes that the next factors will take.
    """

    def __init__(self, indptr: Indices32, indices: Indices32, definite: bool, nodes: Supernodes) -> None:
        self.definite = definite
        self.entries = nodes.entries
        self._branches, self._top = cut(nodes, indptr, indices)
        rooms = sorted(branch.nodes.room for branch in self._branches)[-thread_count() :]
        passed = sum(triangle(branch.beyond.size) for branch in self._branches)
        # What branches pass on is there twice while the top is eliminated: from each, and in one array.
        self.needs = 8 * (nodes.entries + passed + max(sum(rooms), passed + self._top.nodes.room))

    def factor(self, data: Floats, *, single: bool = False) -> FrontalFactors:
        """Factorize the matrix with these entries, and keep the factors in single precision if asked to.

        Without exchanges elimination in single precision is stable for definite matrices only: of others the
        factors are rounded in the end.

        Raises
        ------
        SingularMatrix
            A pivot is zero, or negative where the matrices must be definite.
        """
        worked_single = single and self.definite
        nothing = _empty(0, worked_single)

        def eliminated(
            part: Part, passed: Floats | Singles = nothing
        ) -> tuple[int, Floats | Singles, Floats | Singles]:
            """The number of negative pivots, L, and what is passed on."""
            nodes = part.nodes
            L, stack = _empty(nodes.entries, single), _empty(nodes.room, worked_single)
            least = 0.0 if self.definite else -np.inf
            negative = eliminate(
                nodes, part.indptr, part.indices, data[part.entries], L, stack, passed, least
            )
            if negative < 0:
                raise SingularMatrix(self._refusal)
            return negative, L, stack[: triangle(part.beyond.size)].copy()

        done = in_threads(eliminated, self._branches)
        done.append(eliminated(self._top, np.concatenate([nothing, *(passed for _, _, passed in done)])))
        return FrontalFactors(
            self._branches, self._top, [L for _, L, _ in done], sum(negative for negative, _, _ in done)
        )

    @property
    def _refusal(self) -> str:
        if self.definite:
            return "the matrix is not positive definite"
        return "the matrix has no factors L D L^T in this order"


@dataclass(frozen=True, eq=False)
class FrontalFactors:
    """The factors of one matrix: of each part the trapezoids of its supernodes, in each D and L."""

    _branches: tuple[Part, ...]
    _top: Part
    _L: list[Floats | Singles]
    negative_pivots: int

    def solve(self, b: Floats) -> Floats:
        """Solve for b (n,) or (n, k)."""
        x = np.array(b.T, order="C", ndmin=2)
        numbers = range(len(self._branches))

        def up(k: int) -> Floats:
            branch = self._branches[k]
            own = _with_room(x[:, branch.columns], branch.beyond.size)
            forward(branch.nodes, self._L[k], own)
            return own

        def down(k: int) -> None:
            branch, own = self._branches[k], waiting[k]
            own[:, own.shape[1] - branch.beyond.size :] = top[:, branch.beyond]
            back(branch.nodes, self._L[k], own)
            x[:, branch.columns] = own[:, : own.shape[1] - branch.beyond.size]

        waiting = in_threads(up, numbers)
        top = np.ascontiguousarray(x[:, self._top.columns])
        for branch, own in zip(self._branches, waiting, strict=True):
            top[:, branch.beyond] += own[:, own.shape[1] - branch.beyond.size :]
        forward(self._top.nodes, self._L[-1], top)
        back(self._top.nodes, self._L[-1], top)
        in_threads(down, numbers)
        x[:, self._top.columns] = top
        return x.reshape(b.T.shape).T


def _empty(count: int, single: bool) -> Floats | Singles:
    return np.empty(count, dtype=np.float32) if single else np.empty(count)


def triangle(m: int) -> int:
    """Entries of a symmetric matrix of m rows."""
    return m * (m + 1) // 2


def _with_room(x: Floats, more: int) -> Floats:
    """Columns of x, and as many more of zeros."""
    wide = np.zeros((x.shape[0], x.shape[1] + more))
    wide[:, : x.shape[1]] = x
    return wide
