"""Newton's method on the radii: what its linear equations are solved with."""

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array

from isoembed.alexandrov.newton import Preconditioner
from isoembed.linalg import SingularMatrix, analyze, factor


def test_factors_are_double_where_single_precision_loses_the_matrix(monkeypatch):
    monkeypatch.setattr(factor, "SINGLE_ENTRIES", 0)
    # The pivot leaves nothing of the 3 beside its multiples in single precision.
    matrix = csc_array(block_diag([np.array([[1e-9, 1.0], [1.0, 3.0]])] * 10))
    matrix.sort_indices()
    solver = analyze(matrix, np.arange(20), definite=False)
    with pytest.raises(SingularMatrix):
        solver.factor(matrix.data, single=True)
    inverse = Preconditioner(solver)
    inverse.renew(matrix.data)
    x = np.arange(20.0)
    assert inverse.solve(matrix @ x) == pytest.approx(x, abs=1e-5)
