"""PARDISO of Intel's MKL, by the library that pypardiso brings: Cholesky or L D L^T with symbolic reuse."""

import ctypes
import weakref
from functools import partial

import numpy as np
from numpy.typing import NDArray
from pypardiso.scipy_aliases import pypardiso_solver

from isoembed.linalg.elimination import Elimination
from isoembed.linalg.memory import OutOfMemory
from isoembed.linalg.singular import SingularMatrix

Pointers = NDArray[np.int32]

# pypardiso only finds the library: its own calls analyze anew every time and know no Cholesky.
_pardiso = pypardiso_solver.libmkl["pardiso"]

_POSITIVE_DEFINITE, _INDEFINITE = 2, -2
_ANALYZE, _FACTOR, _SOLVE, _RELEASE = 11, 22, 33, -1
_ZERO_PIVOT, _OUT_OF_MEMORY = -4, -2
_PERTURBED, _NEGATIVE = 13, 22  # counts of pivots, among the parameters

# Bytes, measured: for an entry of L with its padding; for the analysis, an entry of the matrix and a row.
FACTOR, ENTRY, ROW = 9.2, 19, 310


class Symbolic:
    """A pattern in elimination order: the lower triangle by columns, the upper one by rows, sorted."""

    def __init__(self, indptr: Pointers, indices: Pointers, elimination: Elimination, definite: bool) -> None:
        self._indptr, self._indices, self._definite = indptr, indices, definite
        self._count = int(elimination.counts.sum())
        # A handle comes back here when its factors are let go: a loop that replaces its factor analyzes twice
        # at most, and nobody's factors are overwritten.
        self._idle: list[_Handle] = []

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take, with PARDISO's analysis; none where it has room already."""
        if self._idle:
            return 0
        return int(FACTOR * self._count) + ENTRY * self._indices.size + ROW * self._indptr.size

    def factor(self, data: NDArray[np.float64]) -> "Numeric":
        """Factorize the matrix with these entries; raises SingularMatrix."""
        handle = self._idle.pop() if self._idle else _Handle(self._indptr, self._indices, self._definite)
        numeric = Numeric(handle)
        weakref.finalize(numeric, self._idle.append, handle)
        handle.factor(data)
        return numeric


class Numeric:
    """The factors of one matrix."""

    def __init__(self, handle: "_Handle") -> None:
        self._handle = handle

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D."""
        return self._handle.negative_pivots

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for b (n,) or (n, k)."""
        return self._handle.solve(b)


class _Handle:
    """MKL's memory for one analysis and one set of factors, released when this object goes."""

    def __init__(self, indptr: Pointers, indices: Pointers, definite: bool) -> None:
        n = indptr.size - 1
        self._data = np.zeros(indices.size)
        parameters = np.zeros(64, dtype=np.int32)
        parameters[0] = 1  # all parameters are set here, none by default
        parameters[4] = 1  # eliminate in the order given
        parameters[9] = 300  # perturb pivots below 10 to the power minus this
        parameters[34] = 1  # indices start at zero
        memory = np.zeros(64, dtype=np.int64)
        order = np.arange(n, dtype=np.int32)
        kind = _POSITIVE_DEFINITE if definite else _INDEFINITE
        self._parameters = parameters
        self._call = partial(_call, kind, memory, parameters, indptr, indices, order, self._data)
        self._call(_ANALYZE)
        weakref.finalize(self, self._call, _RELEASE)

    def factor(self, data: NDArray[np.float64]) -> None:
        self._data[:] = data
        self._call(_FACTOR)
        self.negative_pivots = int(self._parameters[_NEGATIVE])
        if self._parameters[_PERTURBED]:
            raise SingularMatrix("the matrix has no factors L D L^T in this order")

    def solve(self, b: NDArray[np.float64]) -> NDArray[np.float64]:
        b = np.asfortranarray(b)
        x = np.empty_like(b)
        self._call(_SOLVE, b, x)
        return np.ascontiguousarray(x)


def _call(
    kind: int,
    memory: NDArray[np.int64],
    parameters: NDArray[np.int32],
    indptr: Pointers,
    indices: Pointers,
    order: NDArray[np.int32],
    data: NDArray[np.float64],
    phase: int,
    b: NDArray[np.float64] | None = None,
    x: NDArray[np.float64] | None = None,
) -> None:
    columns = 1 if b is None or b.ndim == 1 else b.shape[1]
    status = ctypes.c_int(0)
    _pardiso(
        _address(memory),
        ctypes.byref(ctypes.c_int(1)),  # matrices in this memory
        ctypes.byref(ctypes.c_int(1)),  # which of them
        ctypes.byref(ctypes.c_int(kind)),
        ctypes.byref(ctypes.c_int(phase)),
        ctypes.byref(ctypes.c_int(order.size)),
        _address(data),
        _address(indptr),
        _address(indices),
        _address(order),
        ctypes.byref(ctypes.c_int(columns)),
        _address(parameters),
        ctypes.byref(ctypes.c_int(0)),  # print nothing
        None if b is None else _address(b),
        None if x is None else _address(x),
        ctypes.byref(status),
    )
    if status.value == _ZERO_PIVOT:
        if kind == _POSITIVE_DEFINITE:
            raise SingularMatrix("the matrix is not positive definite")
        raise SingularMatrix("the matrix has no factors L D L^T in this order")
    if status.value == _OUT_OF_MEMORY:
        raise OutOfMemory(f"PARDISO ran out of memory for the factors of a matrix of {order.size} unknowns")
    if status.value != 0:
        raise RuntimeError(f"PARDISO failed in phase {phase} with status {status.value}")


def _address(array: NDArray[np.generic]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)
