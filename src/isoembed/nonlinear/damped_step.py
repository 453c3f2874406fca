"""Levenberg-Marquardt step of a problem with a dense matrix: (H + damping I) d = g."""

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix


def damped_step(hessian: Floats, gradient: Floats, damping: float) -> Floats:
    """The step d to be subtracted, (n,); raises SingularMatrix where the matrix is not positive definite."""
    matrix = hessian.copy()
    matrix[np.diag_indices(len(matrix))] += damping
    try:
        factor = cho_factor(matrix, overwrite_a=True, check_finite=False)
    except LinAlgError:
        raise SingularMatrix("the damped matrix is not positive definite") from None
    return np.asarray(cho_solve(factor, gradient, check_finite=False))
