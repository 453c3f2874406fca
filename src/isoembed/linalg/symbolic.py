"""Interfaces of symbolic and numeric factorizations."""

from dataclasses import dataclass
from typing import Protocol

from isoembed.arrays import Floats, Indices32


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


@dataclass(eq=False)
class Symbolic:
    """A symmetric pattern in elimination order.

    Attributes
    ----------
    indptr, indices : ndarray of int32
        The lower triangle in compressed columns with sorted rows.
    definite : bool
        Whether the matrices must be positive definite.
    """

    indptr: Indices32
    indices: Indices32
    definite: bool

    @property
    def needs(self) -> int:
        """Bytes that the next factors will take."""
        raise NotImplementedError

    def factor(self, data: Floats, *, single: bool = False) -> Numeric:
        """Factorize the matrix with these entries, and keep them in single precision where that saves memory.

        Raises
        ------
        SingularMatrix
        """
        raise NotImplementedError

    def refusal(self) -> SingularMatrix:
        """The error where elimination meets a pivot that it must not."""
        if self.definite:
            return SingularMatrix("the matrix is not positive definite")
        return SingularMatrix("the matrix has no factors L D L^T in this order")
