"""L D L^T of sparse symmetric matrices by dense fronts.

The front of a supernode is a symmetric matrix on its columns and the rows below them: the sum of entries of A
and of what its children pass on. Its columns are eliminated, and what that leaves of the rows below is passed
on to its parent. As every supernode comes after its children, what waits for a parent lies on a stack (Duff,
Reid, The multifrontal solution of indefinite sparse symmetric linear, ACM Trans. Math. Softw. 9, 1983).

Pivots are taken down the diagonal, in the order given.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32, Singles
from isoembed.kernel import kernel
from isoembed.linalg.fronts import beginning, eliminate_columns, extend, room_to_multiply
from isoembed.linalg.supernodes import Supernodes
from isoembed.linalg.symbolic import Symbolic


@dataclass(eq=False)
class Fronts(Symbolic):
    """A pattern in elimination order, and its supernodes."""

    nodes: Supernodes

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        return 8 * (self.nodes.entries + self.nodes.room)

    def factor(self, data: Floats, *, single: bool = False) -> "FrontalFactors":
        """Factorize the matrix with these entries; raises SingularMatrix.

        Without exchanges elimination in single precision is stable for definite matrices only: of others the
        factors are rounded in the end.
        """
        count = self.nodes.entries
        L: Floats | Singles = np.empty(count, dtype=np.float32) if single else np.empty(count)
        stack = np.empty(self.nodes.room, dtype=L.dtype if self.definite else np.float64)
        least = 0.0 if self.definite else -np.inf
        negative = _eliminate(self.nodes, self.indptr, self.indices, data, L, stack, least)
        if negative < 0:
            raise self.refusal()
        return FrontalFactors(self.nodes, L, negative)


@dataclass(frozen=True, eq=False)
class FrontalFactors:
    """The factors of one matrix: the trapezoids of its supernodes one after the other, in each D and L."""

    _nodes: Supernodes
    _L: Floats | Singles
    negative_pivots: int

    def solve(self, b: Floats) -> Floats:
        """Solve for b (n,) or (n, k)."""
        x = np.array(b.T, order="C", ndmin=2)
        _substitute(self._nodes, self._L, x)
        return x.reshape(b.T.shape).T


@kernel
def _eliminate(
    nodes: Supernodes,
    indptr: Indices32,
    indices: Indices32,
    data: Floats,
    L: Floats | Singles,
    stack: Floats | Singles,
    least: float,
) -> int:
    """Fill L; the number of negative pivots, or -1 where one is zero or not larger than the least."""
    starts, ends = nodes.starts, nodes.ends
    place = np.empty(indptr.size - 1, dtype=np.int64)  # in the front, of its rows
    places, room = np.empty(nodes.widest, dtype=np.int64), room_to_multiply(stack, nodes.widest)
    waiting = np.empty(starts.size, dtype=np.int64)  # supernodes, in the order of the stack
    waits = top = done = negative = 0
    for s in range(starts.size - 1):
        k, below = starts[s + 1] - starts[s], ends[s + 1] - ends[s]
        m = k + below
        for i in range(k):
            place[starts[s] + i] = i
        for i in range(below):
            place[nodes.rows[ends[s] + i]] = k + i
        front = stack[top : top + beginning(m, m)]
        for i in range(front.size):
            front[i] = 0.0
        for j in range(k):
            at = beginning(j, m) - j
            for p in range(indptr[starts[s] + j], indptr[starts[s] + j + 1]):
                front[at + place[indices[p]]] = data[p]
        bottom = top
        for _ in range(nodes.children[s]):
            waits -= 1
            c = waiting[waits]
            size = ends[c + 1] - ends[c]
            for i in range(size):
                places[i] = place[nodes.rows[ends[c] + i]]
            extend(front, m, stack[bottom - beginning(size, size) : bottom], places[:size])
            bottom -= beginning(size, size)
        if not eliminate_columns(front, k, m, least, room):
            return -1
        for j in range(k):
            at = beginning(j, m)
            pivot, scale = front[at], 1.0 / front[at]
            negative += int(pivot < 0)
            L[done] = pivot
            for i in range(1, m - j):
                L[done + i] = front[at + i] * scale
            done += m - j
        at = beginning(k, m)
        for i in range(front.size - at):
            stack[bottom + i] = front[at + i]
        top = bottom + front.size - at
        waiting[waits] = s
        waits += 1
    return negative


@kernel
def _substitute(nodes: Supernodes, L: Floats | Singles, x: Floats) -> None:
    """Solve for every row of x, (columns, n), in its place."""
    starts, ends, count = nodes.starts, nodes.ends, nodes.starts.size - 1
    front = np.empty(nodes.widest)
    done = 0
    for s in range(count):
        own, rows = slice(starts[s], starts[s + 1]), nodes.rows[ends[s] : ends[s + 1]]
        k, m = starts[s + 1] - starts[s], starts[s + 1] - starts[s] + rows.size
        columns = L[done : done + beginning(k, m)]
        for c in range(len(x)):
            v, solved = front[:m], x[c, own]
            v[:k], v[k:] = solved, 0.0
            _forward(columns, k, v, solved)
            for i in range(rows.size):
                x[c, rows[i]] += v[k + i]
        done += columns.size
    for s in range(count - 1, -1, -1):
        own, rows = slice(starts[s], starts[s + 1]), nodes.rows[ends[s] : ends[s + 1]]
        k, m = starts[s + 1] - starts[s], starts[s + 1] - starts[s] + rows.size
        columns = L[done - beginning(k, m) : done]
        for c in range(len(x)):
            v, solved = front[:m], x[c, own]
            v[:k] = solved
            for i in range(rows.size):
                v[k + i] = x[c, rows[i]]
            _back(columns, k, v)
            solved[:] = v[:k]
        done -= columns.size


@kernel(fastmath={"contract", "reassoc"})
def _forward(L: Floats | Singles, k: int, v: Floats, solved: Floats) -> None:
    """Solve with D L for the first k of v, and subtract from the others what these contribute."""
    m = v.size
    for j in range(0, k - k % 4, 4):  # four columns at once: v is read and written once for them
        a, b = beginning(j, m), beginning(j + 1, m)
        c, d = beginning(j + 2, m), beginning(j + 3, m)
        v0 = v[j]
        v1 = v[j + 1] - v0 * L[a + 1]
        v2 = v[j + 2] - v0 * L[a + 2] - v1 * L[b + 1]
        v3 = v[j + 3] - v0 * L[a + 3] - v1 * L[b + 2] - v2 * L[c + 1]
        rest, l0, l1, l2, l3 = v[j + 4 :], L[a + 4 : b], L[b + 3 : c], L[c + 2 : d], L[d + 1 : d + m - j - 3]
        for i in range(rest.size):
            rest[i] -= v0 * l0[i] + v1 * l1[i] + v2 * l2[i] + v3 * l3[i]
        solved[j], solved[j + 1] = v0 / L[a], v1 / L[b]
        solved[j + 2], solved[j + 3] = v2 / L[c], v3 / L[d]
    for j in range(k - k % 4, k):
        at = beginning(j, m)
        rest, column, known = v[j + 1 :], L[at + 1 : at + m - j], v[j]
        for i in range(rest.size):
            rest[i] -= known * column[i]
        solved[j] = known / L[at]


@kernel(fastmath={"contract", "reassoc"})
def _back(L: Floats | Singles, k: int, v: Floats) -> None:
    """Solve with the transpose of L for the first k of v, the others being known."""
    m = v.size
    for j in range(k - 1, k - k % 4 - 1, -1):
        at = beginning(j, m)
        rest, column, total = v[j + 1 :], L[at + 1 : at + m - j], 0.0
        for i in range(rest.size):
            total += rest[i] * column[i]
        v[j] -= total
    for j in range(k - k % 4 - 4, -1, -4):
        a, b = beginning(j, m), beginning(j + 1, m)
        c, d = beginning(j + 2, m), beginning(j + 3, m)
        rest, l0, l1, l2, l3 = v[j + 4 :], L[a + 4 : b], L[b + 3 : c], L[c + 2 : d], L[d + 1 : d + m - j - 3]
        t0 = t1 = t2 = t3 = 0.0
        for i in range(rest.size):
            t0 += rest[i] * l0[i]
            t1 += rest[i] * l1[i]
            t2 += rest[i] * l2[i]
            t3 += rest[i] * l3[i]
        v[j + 3] -= t3
        v[j + 2] -= t2 + v[j + 3] * L[c + 1]
        v[j + 1] -= t1 + v[j + 2] * L[b + 1] + v[j + 3] * L[b + 2]
        v[j] -= t0 + v[j + 1] * L[a + 1] + v[j + 2] * L[a + 2] + v[j + 3] * L[a + 3]
