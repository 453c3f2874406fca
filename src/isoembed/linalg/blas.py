"""Matrix products by BLAS for compiled modules, declared in ``blas.pxd``; by NumPy in interpreted runs."""

from isoembed.arrays import Floats


def multiply_transposed(
    room: Floats, left: int, right: int, product: int, k: int, width: int, begin: int, end: int
) -> None:
    """Multiply the transpose of a matrix by another, from a column on, all three stored in one array.

    The two are (k, width), by rows, and begin at the entries `left` and `right`. The product of the columns
    from `begin` to `end` of the first with those from `begin` on of the second is stored by rows, from the
    entry `product` on.
    """
    a, b = (room[at : at + k * width].reshape(k, width) for at in (left, right))
    values = a[:, begin:end].T @ b[:, begin:]
    room[product : product + values.size] = values.ravel()
