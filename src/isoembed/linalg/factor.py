"""Sparse factorizations: one analysis of a pattern, numeric factors with a growth check, refined solves."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.linalg.elimination import first_asymmetry, first_gap, inverse, permuted, symbolic_analysis
from isoembed.linalg.memory import require_memory
from isoembed.linalg.multifrontal import FrontalFactors, Fronts
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.superlu import checked_lu
from isoembed.linalg.supernodes import find_supernodes
from isoembed.linalg.symmetric import SymmetricMatrix
from isoembed.linalg.tasks import TaskTree
from isoembed.linalg.work import Work

SINGLE_ENTRIES = 2**20
"""Entries of L from which on single precision is worth it: smaller factors stay in the cache."""


class Solves(Protocol):
    """The factors of one matrix in elimination order."""

    def solve(self, b: Floats) -> Floats:
        """Solve for b (n,) or (n, k)."""
        ...


def analyze(
    pattern: sp.sparray | sp.spmatrix, order: ArrayLike, *, definite: bool = True, work: Work | None = None
) -> Solver:
    """Prepare to factor symmetric matrices of one pattern.

    Parameters
    ----------
    pattern : sparse, (n, n)
        Every stored entry belongs to the pattern, zeros included: both triangles and the whole diagonal.
        Build it from connectivity, because scipy's products drop entries that happen to be zero.
    order : (n,) int
        Elimination order, such as `Dissection.edge_order`: ``order[k]`` is the k-th unknown to eliminate.
    definite : bool
        Whether the matrices must be positive definite. If not, they are factored as L D L^T with a diagonal
        D, down the diagonal in the order given. That is good for matrices with few negative eigenvalues; a
        pivot that is zero or lost in rounding is refused even where the matrix is regular.
    work : Work, optional
        Counts the factorizations, those that fail included.

    Returns
    -------
    Solver

    Raises
    ------
    ValueError
        If pattern or order are not as described.
    OutOfMemory
        If the factors would need more memory than is free.
    """
    return Solver(pattern, order, definite, Work() if work is None else work)


class Solver:
    """Factorizations of symmetric matrices of one pattern, made by `analyze`.

    Attributes
    ----------
    pattern : CSC, (n, n)
        The pattern, rows sorted within columns; its entries are all 1. The data for `factor` align with its
        ``.data``.
    definite : bool
        Whether the matrices must be positive definite.
    """

    def __init__(
        self, pattern: sp.sparray | sp.spmatrix, order: ArrayLike, definite: bool, work: Work
    ) -> None:
        self.definite, self._work = definite, work
        self.pattern = _checked(pattern)
        n = self.pattern.shape[0]
        order = np.array(order, dtype=np.int64)
        if order.shape != (n,) or inverse(order).size != n:
            raise ValueError(f"the elimination order is not a permutation of the {n} unknowns")
        elimination = symbolic_analysis(self.pattern.indptr, self.pattern.indices, order)
        self._order = elimination.order
        self._indptr, self._indices, self._source = permuted(
            self.pattern.indptr, self.pattern.indices, self._order, True
        )
        nodes = find_supernodes(self.pattern.indptr, self.pattern.indices, elimination)
        self._fronts = Fronts(self._indptr, self._indices, definite, TaskTree.of(nodes))
        self._require_memory()

    def factor(self, data: ArrayLike, *, single: bool = False) -> SymmetricFactor:
        """Factorize one matrix.

        Parameters
        ----------
        data : (nnz,) float
            Its entries, both triangles, in the order of ``pattern.data``.
        single : bool
            Whether large factors are kept in single precision, which is enough for a preconditioner: solving
            with them waits for memory. Solutions of definite matrices without refinement have its rounding
            errors, too.

        Returns
        -------
        SymmetricFactor

        Raises
        ------
        SingularMatrix
            If the matrix is singular to working precision, or is not positive definite though it must be, or
            has no factors L D L^T in this order.
        OutOfMemory
            If the factors would need more memory than is free.
        """
        values = np.asarray(data, dtype=np.float64)
        if values.shape != (self.pattern.nnz,):
            raise ValueError(
                f"the pattern has {self.pattern.nnz} entries, but the data have shape {values.shape}"
            )
        self._work.factorizations += 1
        _refuse_infinite(values)
        matrix = SymmetricMatrix(self._indptr, self._indices, values[self._source])
        del data, values  # if nobody else holds them, their memory is free for the factors
        if self.definite:
            diagonal = matrix.diagonal()
            if diagonal.min() <= 0:
                k, least = self._order[diagonal.argmin()], diagonal.min()
                raise SingularMatrix(
                    f"the matrix is not positive definite: diagonal entry {k} is {least:.3g}"
                )
        self._require_memory()
        single = single and self._fronts.nodes.entries > SINGLE_ENTRIES
        numeric = self._fronts.factor(matrix.data, single=single)
        if not self.definite:
            scale = matrix.sizes()
            b, x = _refuse_growth(numeric, scale, scale)
            _refuse_residual((b - matrix @ x) / scale)
        elif not single:  # whose rounding limits the growth
            _refuse_growth(numeric, np.sqrt(diagonal), np.sqrt(diagonal))
        return SymmetricFactor(matrix, numeric, self._order)

    @property
    def needs(self) -> int:
        """Bytes of memory that the next factors will take, from the pattern alone."""
        return self._fronts.needs

    def _require_memory(self) -> None:
        require_memory(self.needs, f"the factors of a matrix of {self._order.size} unknowns")


class Factor:
    """The factors of one matrix: solves, and refines what it solves."""

    def __init__(self, matrix: SymmetricMatrix | sp.csc_matrix, numeric: Solves, order: Indices) -> None:
        """The matrix, its rows and columns, and its factors are in elimination order."""
        self._matrix, self._numeric, self._order = matrix, numeric, order

    def solve(self, b: ArrayLike, sweeps: int = 2) -> Floats:
        """Solve A x = b.

        Parameters
        ----------
        b : (n,) or (n, k) float
            One or several right-hand sides.
        sweeps : int
            Largest number of sweeps of iterative refinement; they end when the residual no longer halves. A
            preconditioner needs none.

        Returns
        -------
        (n,) or (n, k) float64
        """
        b = np.asarray(b, dtype=np.float64)
        n = self._order.size
        if b.ndim not in (1, 2) or b.shape[0] != n:
            raise ValueError(f"the matrix has {n} rows, but the right-hand side has shape {b.shape}")
        x = np.empty_like(b)
        x[self._order] = self._solved(b[self._order], sweeps)
        return x

    def _solved(self, b: Floats, sweeps: int) -> Floats:
        """Solution of `solve`, in elimination order."""
        x = self._numeric.solve(b)
        if sweeps == 0:
            return x
        residual = b - self._matrix @ x
        size = np.linalg.norm(residual, axis=0)
        for _ in range(sweeps):
            refined = x + self._numeric.solve(residual)
            remaining = b - self._matrix @ refined
            remaining_size = np.linalg.norm(remaining, axis=0)
            better = remaining_size < size
            x = np.where(better, refined, x)
            if not (remaining_size < 0.5 * size).any():  # a sweep that leaves more than half is the last
                break
            residual, size = np.where(better, remaining, residual), np.minimum(remaining_size, size)
        return x


class SymmetricFactor(Factor):
    """The factors of one symmetric matrix, L D L^T with diagonal D."""

    def __init__(self, matrix: SymmetricMatrix, numeric: FrontalFactors, order: Indices) -> None:
        super().__init__(matrix, numeric, order)
        self._negative_pivots = numeric.negative_pivots

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D, which is that of negative eigenvalues."""
        return self._negative_pivots


def factor_general(matrix: sp.sparray | sp.spmatrix, work: Work | None = None) -> Factor:
    """Factorize a sparse matrix that need be neither symmetric nor definite: SuperLU with row exchanges.

    Parameters
    ----------
    matrix : sparse, (n, n)
    work : Work, optional
        Counts the factorization.

    Returns
    -------
    Factor

    Raises
    ------
    SingularMatrix
        If the matrix is singular to working precision.
    """
    if work is not None:
        work.factorizations += 1
    csc = sp.csc_matrix(matrix, dtype=np.float64, copy=True)
    _refuse_infinite(csc.data)
    # Row exchanges ruin the minimum degree of A^T + A: up to 30 times the fill of COLAMD on meshes.
    lu = checked_lu(csc, "COLAMD")
    rows = abs(csc).max(axis=1).toarray().ravel()
    columns = (sp.diags_array(1.0 / rows) @ abs(csc)).max(axis=0).toarray().ravel()
    _refuse_growth(lu, rows, columns)
    return Factor(csc, lu, np.arange(csc.shape[0]))


def _refuse_infinite(values: Floats) -> None:
    if not np.isfinite(values).all():
        k = int(np.argmin(np.isfinite(values)))
        raise SingularMatrix(f"the matrix is not finite: stored entry {k} is {values[k]}")


def _refuse_growth(numeric: Solves, rows: Floats, columns: Floats) -> tuple[Floats, Floats]:
    """Raise if the inverse of the matrix, its rows and columns scaled to size 1, blows a random probe up.

    Returns the right-hand side and the solution.
    """
    b = rows * np.random.default_rng(0).uniform(-1.0, 1.0, rows.size)
    x = numeric.solve(b)
    growth = np.abs(columns * x).max()
    if not growth < 2.0**46:  # a larger scaled inverse leaves less than two digits
        raise SingularMatrix(
            f"the matrix is singular to working precision: its scaled inverse grows by {growth:.1e}"
        )
    return b, x


def _refuse_residual(residual: Floats) -> None:
    """Raise if elimination without exchanges lost the matrix: much of a random probe, scaled, is left."""
    worst = np.abs(residual).max()
    if not worst < 2.0**-6:  # factors that leave more have less than two digits
        raise SingularMatrix(
            "the matrix has no accurate factors L D L^T in this order: "
            f"a solution leaves {worst:.1e} of the right-hand side"
        )


def _checked(pattern: sp.sparray | sp.spmatrix) -> sp.csc_matrix:
    """The pattern as CSC, rows sorted, entries 1; raises ValueError unless symmetric with a diagonal."""
    checked = sp.csc_matrix(pattern, copy=True)
    checked.sum_duplicates()
    ones = np.ones(checked.nnz, dtype=np.int8)
    checked = sp.csc_matrix(
        (ones, checked.indices.astype(np.int32), checked.indptr.astype(np.int32)), shape=checked.shape
    )
    i, j = first_asymmetry(checked.indptr, checked.indices)
    if i >= 0:
        raise ValueError(f"the pattern is not symmetric: of the entries {i}, {j} and {j}, {i} one is missing")
    k = first_gap(checked.indptr, checked.indices)
    if k >= 0:
        raise ValueError(f"the pattern lacks diagonal entry {k}")
    return checked
