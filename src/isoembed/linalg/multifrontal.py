"""Multifrontal L D L^T factorization of sparse symmetric matrices.

The front of a supernode is a symmetric matrix on its columns and the rows below them: the sum of entries of A
and of what its children pass on. Its columns are eliminated, and what that leaves of the rows below is passed
on to its parent. As every supernode comes after its children, what waits for a parent lies on a stack (Duff,
Reid, The multifrontal solution of indefinite sparse symmetric linear, ACM Trans. Math. Softw. 9, 1983).

Pivots are taken down the diagonal, in the order given.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Singles
from isoembed.linalg.fronts import eliminate, substitute
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
        negative = eliminate(self.nodes, self.indptr, self.indices, data, L, stack, least)
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
        substitute(self._nodes, self._L, x)
        return x.reshape(b.T.shape).T
