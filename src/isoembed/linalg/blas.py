"""Matrix products by BLAS for compiled modules, declared in ``blas.pxd``; by NumPy in interpreted runs."""

import numpy as np

from isoembed.arrays import Floats


def multiply_transposed(work: Floats, k: int, rows: int, right: Floats, stride: int, columns: int) -> None:
    """Multiply the transpose of a matrix by another.

    The first is (k, rows), by rows, and begins an array, in which the product follows, (rows, columns), by
    rows. The other is (k, columns), and its rows are `stride` numbers apart.
    """
    a = work[: k * rows].reshape(k, rows)
    b = np.lib.stride_tricks.as_strided(right, (k, columns), (stride * right.itemsize, right.itemsize))
    work[k * rows :][: rows * columns] = (a.T @ b).ravel()
