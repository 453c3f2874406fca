"""PARDISO of Intel's MKL, by the library that pypardiso brings: Cholesky or L D L^T with symbolic reuse."""

from __future__ import annotations

import ctypes
import weakref
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pypardiso.scipy_aliases import pypardiso_solver

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.linalg import backend
from isoembed.linalg.memory import OutOfMemory

# pypardiso only finds the library: its own calls analyze anew every time and know no Cholesky.
_pardiso = pypardiso_solver.libmkl["pardiso"]

_POSITIVE_DEFINITE, _INDEFINITE = 2, -2
_ANALYZE, _FACTOR, _SOLVE, _RELEASE = 11, 22, 33, -1
_ZERO_PIVOT, _OUT_OF_MEMORY = -4, -2
_PERTURBED, _NEGATIVE = 13, 22  # counts of pivots, among the parameters

ANALYZED, TO_ANALYZE = backend.BytesPer(0), backend.BytesPer(9.2, 19, 310)  # the second with the analysis


class Symbolic(backend.Symbolic):
    """A pattern in elimination order."""

    @cached_property
    def _idle(self) -> list[_Handle]:
        """Handles whose factors were let go.

        A loop that replaces its factor so analyzes twice at most, and nobody's factors are overwritten.
        """
        return []

    @property
    def bytes_per(self) -> backend.BytesPer:
        """Memory of the next factors."""
        return ANALYZED if self._idle else TO_ANALYZE

    def factor(self, data: Floats) -> Numeric:
        """Factorize the matrix with these entries; raises SingularMatrix."""
        numeric = Numeric(self._idle.pop() if self._idle else _Handle(_Problem.of(self)))
        weakref.finalize(numeric, self._idle.append, numeric.handle)
        if not numeric.handle.factor(data):
            raise self.refusal()
        return numeric


class Numeric:
    """The factors of one matrix."""

    def __init__(self, handle: _Handle) -> None:
        self.handle, self.solve = handle, handle.solve

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D."""
        return self.handle.negative_pivots


class _Handle:
    """One analysis and one set of factors, released when this object goes."""

    def __init__(self, problem: _Problem) -> None:
        self.problem = problem
        problem.call(_ANALYZE)
        weakref.finalize(self, problem.call, _RELEASE)

    def factor(self, data: Floats) -> bool:
        """Whether no pivot was zero."""
        problem = self.problem
        problem.data[:] = data
        done = problem.call(_FACTOR)
        self.negative_pivots = int(problem.parameters[_NEGATIVE])
        return done and not problem.parameters[_PERTURBED]

    def solve(self, b: Floats) -> Floats:
        b = np.asfortranarray(b)
        x = np.empty_like(b)
        self.problem.call(_SOLVE, b, x)
        return np.ascontiguousarray(x)


class _Problem(NamedTuple):
    """What MKL works with: its memory, and the matrix by rows of the upper triangle."""

    kind: int
    memory: Indices
    parameters: Indices32
    indptr: Indices32
    indices: Indices32
    order: Indices32
    data: Floats

    @classmethod
    def of(cls, pattern: Symbolic) -> _Problem:
        """Memory for matrices of a pattern, not yet analyzed."""
        parameters = np.zeros(64, dtype=np.int32)
        parameters[0] = 1  # all parameters are set here, none by default
        parameters[4] = 1  # eliminate in the order given
        parameters[9] = 300  # perturb pivots below 10 to the power minus this
        parameters[34] = 1  # indices start at zero
        return cls(
            _POSITIVE_DEFINITE if pattern.definite else _INDEFINITE,
            np.zeros(64, dtype=np.int64),
            parameters,
            pattern.indptr,
            pattern.indices,
            np.arange(pattern.indptr.size - 1, dtype=np.int32),
            np.zeros(pattern.indices.size),
        )

    def call(self, phase: int, b: Floats | None = None, x: Floats | None = None) -> bool:
        """Go through a phase; False if a pivot was zero."""
        n = self.order.size
        columns = 1 if b is None or b.ndim == 1 else b.shape[1]
        status = ctypes.c_int(0)
        _pardiso(
            _address(self.memory),
            ctypes.byref(ctypes.c_int(1)),  # matrices in this memory
            ctypes.byref(ctypes.c_int(1)),  # which of them
            ctypes.byref(ctypes.c_int(self.kind)),
            ctypes.byref(ctypes.c_int(phase)),
            ctypes.byref(ctypes.c_int(n)),
            _address(self.data),
            _address(self.indptr),
            _address(self.indices),
            _address(self.order),
            ctypes.byref(ctypes.c_int(columns)),
            _address(self.parameters),
            ctypes.byref(ctypes.c_int(0)),  # print nothing
            None if b is None else _address(b),
            None if x is None else _address(x),
            ctypes.byref(status),
        )
        if status.value == _OUT_OF_MEMORY:
            raise OutOfMemory(f"PARDISO ran out of memory for the factors of a matrix of {n} unknowns")
        if status.value not in (0, _ZERO_PIVOT):
            raise RuntimeError(f"PARDISO failed in phase {phase} with status {status.value}")
        return status.value == 0


def _address(array: NDArray[np.generic]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)
