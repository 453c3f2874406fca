"""Multifrontal L D L^T factorization of sparse symmetric matrices.

The front of a supernode is a symmetric matrix on its columns and the rows below them: the sum of entries of A
and of what its children pass on. Its columns are eliminated, and what that leaves of the rows below is passed
on to its parent. As every supernode comes after its children, what waits for a parent lies on a stack (Duff,
Reid, The multifrontal solution of indefinite sparse symmetric linear, ACM Trans. Math. Softw. 9, 1983).

Pivots are taken down the diagonal, in the order given.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices32, Singles
from isoembed.linalg.fronts import eliminate, substitute
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.supernodes import Supernodes


@dataclass(frozen=True, eq=False)
class Fronts:
    """A symmetric pattern in elimination order, and its supernodes.

    Attributes
    ----------
    indptr, indices : ndarray of int32
        The lower triangle in compressed columns with sorted rows.
    definite : bool
        Whether the matrices must be positive definite.
    nodes : Supernodes
    """

    indptr: Indices32
    indices: Indices32
    definite: bool
    nodes: Supernodes

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        return 8 * (self.nodes.entries + self.nodes.room)

    def factor(self, data: Floats, *, single: bool = False) -> "FrontalFactors":
        """Factorize the matrix with these entries, and keep the factors in single precision if asked to.

        Without exchanges elimination in single precision is stable for definite matrices only: of others the
        factors are rounded in the end.

        Raises
        ------
        SingularMatrix
            A pivot is zero, or negative where the matrices must be definite.
        """
        count = self.nodes.entries
        L: Floats | Singles = np.empty(count, dtype=np.float32) if single else np.empty(count)
        stack = np.empty(self.nodes.room, dtype=L.dtype if self.definite else np.float64)
        least = 0.0 if self.definite else -np.inf
        negative = eliminate(self.nodes, self.indptr, self.indices, data, L, stack, least)
        if negative >= 0:
            return FrontalFactors(self.nodes, L, negative)
        if self.definite:
            raise SingularMatrix("the matrix is not positive definite")
        raise SingularMatrix("the matrix has no factors L D L^T in this order")


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
