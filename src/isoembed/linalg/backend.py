"""Backends: which are installed and which is chosen; what they have in common, their errors."""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol

from isoembed.arrays import Floats, Indices32
from isoembed.errors import InvalidParameter

_BACKENDS = {"multifrontal": "", "pardiso": "mkl", "superlu": ""}
"""The one to use first: each with the extra that installs it."""


def available_backends() -> tuple[str, ...]:
    """Names of the backends that are installed, the default first. Imports none of them."""
    return tuple(name for name in _BACKENDS if _installed(name))


def chosen_backend(backend: str | None) -> str:
    """The named backend, or the default.

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


def _installed(backend: str) -> bool:
    return backend != "pardiso" or find_spec("pypardiso") is not None


class SingularMatrix(ArithmeticError):  # noqa: N818  (named for what it says, as InvalidMetric is)
    """The matrix is singular, not positive definite where it has to be, or not finite."""


class Solves(Protocol):
    """The factors of one matrix in elimination order."""

    def solve(self, b: Floats) -> Floats:
        """Solve for b (n,) or (n, k)."""
        ...


class Numeric(Solves, Protocol):
    """The factors L D L^T of one symmetric matrix in elimination order."""

    @property
    def negative_pivots(self) -> int:
        """Number of negative entries of D."""
        ...


@dataclass(frozen=True)
class BytesPer:
    """Memory that factors take, as measured: bytes for an entry of L, an entry of the matrix, and a row."""

    factor_entry: float
    entry: float = 0.0
    row: float = 0.0


@dataclass(eq=False)
class Symbolic:
    """A symmetric pattern in elimination order, which a backend analyzes once.

    Attributes
    ----------
    indptr, indices : ndarray of int32
        The lower triangle in compressed columns with sorted rows: by symmetry the upper one by rows.
    count : int
        Entries of L.
    definite : bool
        Whether the matrices must be positive definite.
    """

    indptr: Indices32
    indices: Indices32
    count: int
    definite: bool

    @property
    def bytes_per(self) -> BytesPer:
        """Memory of the next factors."""
        raise NotImplementedError

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        per = self.bytes_per
        return int(per.factor_entry * self.count + per.entry * self.indices.size + per.row * self.indptr.size)

    def factor(self, data: Floats) -> Numeric:
        """Factorize the matrix with these entries; raises SingularMatrix."""
        raise NotImplementedError

    def refusal(self) -> SingularMatrix:
        """The error where elimination meets a pivot that it must not."""
        if self.definite:
            return SingularMatrix("the matrix is not positive definite")
        return SingularMatrix("the matrix has no factors L D L^T in this order")
