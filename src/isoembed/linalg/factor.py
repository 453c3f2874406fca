"""Analyze a pattern once, factor matrices that have it, solve with refinement: the same for every backend."""

from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu

from isoembed.errors import InvalidParameter
from isoembed.linalg.singular import SingularMatrix

_BACKENDS = {"pardiso": "mkl", "cholmod": "cholmod", "superlu": ""}
"""The fastest first: each with the extra that installs it."""

_WORST_GROWTH = 1.0 / (64 * np.finfo(np.float64).eps)
"""A scaled inverse larger than this leaves less than two digits to a solution."""


class Numeric(Protocol):
    """What a backend returns: the factors of one matrix in elimination order."""

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        ...


def available_backends() -> tuple[str, ...]:
    """Names of the backends that are installed, the fastest first. Imports none of them."""
    return tuple(name for name in _BACKENDS if _installed(name))


def analyze(pattern: sp.sparray | sp.spmatrix, order: ArrayLike, backend: str | None = None) -> "Solver":
    """Prepare to factor symmetric positive definite matrices of one pattern.

    Parameters
    ----------
    pattern : sparse, (n, n)
        Every stored entry belongs to the pattern, zeros included: both triangles and the whole diagonal.
        Build it from connectivity, because scipy's products drop entries that happen to be zero.
    order : (n,) int
        Elimination order, such as `Dissection.edge_order`: ``order[k]`` is the k-th unknown to eliminate.
    backend : {"pardiso", "cholmod", "superlu"}, optional
        By default the fastest that is installed.

    Returns
    -------
    Solver

    Raises
    ------
    ValueError
        If the backend is unknown or not installed, or pattern or order are not as described.
    """
    return Solver(pattern, order, chosen_backend(backend))


def chosen_backend(backend: str | None) -> str:
    """The named backend, or the fastest that is installed.

    Raises
    ------
    InvalidParameter
        If the backend is unknown or not installed.
    """
    if backend is None:
        return available_backends()[0]
    if backend not in _BACKENDS:
        raise InvalidParameter(f"unknown backend {backend!r}: choose one of {', '.join(_BACKENDS)}")
    if not _installed(backend):
        raise InvalidParameter(
            f"backend {backend!r} is missing: pip install 'isoembed[{_BACKENDS[backend]}]'"
        )
    return backend


class Solver:
    """Factorizations of symmetric positive definite matrices of one pattern, made by `analyze`.

    Attributes
    ----------
    pattern : CSC, (n, n)
        The pattern, rows sorted within columns; its entries are all 1. The data for `factor` align with its
        ``.data``.
    backend : str
        Who does the numbers.
    """

    def __init__(self, pattern: sp.sparray | sp.spmatrix, order: ArrayLike, backend: str) -> None:
        self.backend = backend
        self.pattern = _checked(pattern)
        n = self.pattern.shape[0]
        self._order = np.array(order, dtype=np.int64)
        if not np.array_equal(np.sort(self._order), np.arange(n)):
            raise ValueError(f"the elimination order is not a permutation of the {n} unknowns")
        self._diagonal = np.flatnonzero(self.pattern.indices == _columns(self.pattern))

        # The pattern in elimination order, each entry holding the place its value comes from. Converting to
        # rows and back sorts it.
        place = np.empty(n, dtype=np.int64)
        place[self._order] = np.arange(n)
        source = np.arange(self.pattern.nnz)
        relabeled = sp.csc_matrix((source, place[self.pattern.indices], self.pattern.indptr), shape=(n, n))
        permuted = relabeled[:, self._order].tocsr().tocsc()
        library = import_module(f"isoembed.linalg.{backend}")
        columns = _columns(permuted)
        kept = permuted.indices >= (columns if library.TRIANGLE == "lower" else 0)
        self._gather = permuted.data[kept]
        indptr = np.concatenate(([0], np.cumsum(np.bincount(columns[kept], minlength=n))))
        self._symbolic = library.Symbolic(indptr.astype(np.int32), permuted.indices[kept].astype(np.int32))

    def factor(self, data: ArrayLike) -> "Factor":
        """Factorize one matrix.

        Parameters
        ----------
        data : (nnz,) float
            Its entries, both triangles, in the order of ``pattern.data``.

        Returns
        -------
        Factor

        Raises
        ------
        SingularMatrix
            If the matrix is not positive definite, or singular to working precision.
        """
        values = np.array(data, dtype=np.float64)
        if values.shape != (self.pattern.nnz,):
            raise ValueError(
                f"the pattern has {self.pattern.nnz} entries, but the data have shape {values.shape}"
            )
        _refuse_infinite(values)
        diagonal = values[self._diagonal]
        if diagonal.min() <= 0:
            k = diagonal.argmin()
            raise SingularMatrix(
                f"the matrix is not positive definite: diagonal entry {k} is {diagonal[k]:.3g}"
            )
        matrix = sp.csc_matrix((values, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)
        factor = Factor(matrix, self._symbolic.factor(values[self._gather]), self._order)
        scale = np.sqrt(diagonal)
        _refuse_growth(factor, scale, scale)
        return factor


class Factor:
    """The factors of one matrix: solves, and refines what it solves."""

    def __init__(self, matrix: sp.csc_matrix, numeric: Numeric, order: NDArray[np.int64]) -> None:
        self._matrix, self._numeric, self._order = matrix, numeric, order

    def solve(self, b: ArrayLike, sweeps: int = 2) -> NDArray[np.float64]:
        """Solve A x = b.

        Parameters
        ----------
        b : (n,) or (n, k) float
            One or several right-hand sides.
        sweeps : int
            At most so many sweeps of iterative refinement; they end when the residual no longer halves. A
            preconditioner needs none.

        Returns
        -------
        (n,) or (n, k) float64
        """
        b = np.asarray(b, dtype=np.float64)
        n = self._order.size
        if b.ndim not in (1, 2) or b.shape[0] != n:
            raise ValueError(f"the matrix has {n} rows, but the right-hand side has shape {b.shape}")
        x = self._solve_once(b)
        if sweeps == 0:
            return x
        residual = b - self._matrix @ x
        size = np.linalg.norm(residual, axis=0)
        for _ in range(sweeps):
            refined = x + self._solve_once(residual)
            remaining = b - self._matrix @ refined
            remaining_size = np.linalg.norm(remaining, axis=0)
            better = remaining_size < size
            x = np.where(better, refined, x)
            if not (remaining_size < 0.5 * size).any():
                break
            residual, size = np.where(better, remaining, residual), np.minimum(remaining_size, size)
        return x

    def _solve_once(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        x = np.empty_like(b)
        x[self._order] = self._numeric.solve(b[self._order])
        return x


def factor_general(matrix: sp.sparray | sp.spmatrix) -> Factor:
    """Factorize a sparse matrix that need be neither symmetric nor definite: SuperLU with row exchanges.

    Parameters
    ----------
    matrix : sparse, (n, n)

    Returns
    -------
    Factor

    Raises
    ------
    SingularMatrix
        If the matrix is singular to working precision.
    """
    csc = sp.csc_matrix(matrix, dtype=np.float64, copy=True)
    _refuse_infinite(csc.data)
    try:
        # Row exchanges ruin the minimum degree of A^T + A: up to 30 times the fill of COLAMD on meshes.
        lu = splu(csc, permc_spec="COLAMD")
    except RuntimeError as error:
        raise SingularMatrix("the matrix is singular: elimination met a zero pivot") from error
    factor = Factor(csc, lu, np.arange(csc.shape[0]))
    rows = abs(csc).max(axis=1).toarray().ravel()
    columns = (sp.diags_array(1.0 / rows) @ abs(csc)).max(axis=0).toarray().ravel()
    _refuse_growth(factor, rows, columns)
    return factor


def _refuse_infinite(values: NDArray[np.float64]) -> None:
    if not np.isfinite(values).all():
        k = int(np.argmin(np.isfinite(values)))
        raise SingularMatrix(f"the matrix is not finite: stored entry {k} is {values[k]}")


def _refuse_growth(factor: Factor, rows: NDArray[np.float64], columns: NDArray[np.float64]) -> None:
    """Raise if the inverse of the matrix, its rows and columns scaled to size 1, blows a random probe up."""
    probe = np.random.default_rng(0).uniform(-1.0, 1.0, rows.size)
    growth = np.abs(columns * factor.solve(rows * probe, sweeps=0)).max()
    if not growth < _WORST_GROWTH:
        raise SingularMatrix(
            f"the matrix is singular to working precision: its scaled inverse grows by {growth:.1e}"
        )


def _checked(pattern: sp.sparray | sp.spmatrix) -> sp.csc_matrix:
    """The pattern as CSC, rows sorted, entries 1; raises ValueError unless symmetric with a diagonal."""
    checked = sp.csc_matrix(pattern, dtype=np.float64, copy=True)
    checked.sum_duplicates()
    checked.data[:] = 1.0
    transposed = checked.T.tocsc()
    if not (
        np.array_equal(checked.indptr, transposed.indptr)
        and np.array_equal(checked.indices, transposed.indices)
    ):
        i, j = (int(k[0]) for k in (checked != transposed).nonzero())
        raise ValueError(f"the pattern is not symmetric: of the entries {i}, {j} and {j}, {i} one is missing")
    missing = checked.diagonal() == 0
    if missing.any():
        raise ValueError(f"the pattern lacks diagonal entry {int(missing.argmax())}")
    return checked


def _columns(matrix: sp.csc_matrix) -> NDArray[np.int64]:
    """Column of every stored entry."""
    return np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))


def _installed(backend: str) -> bool:
    if backend == "superlu":
        return True
    if backend == "pardiso":
        return find_spec("pypardiso") is not None
    # scikit-sparse 0.5 has another interface.
    return find_spec("sksparse") is not None and version("scikit-sparse").startswith("0.4.")
