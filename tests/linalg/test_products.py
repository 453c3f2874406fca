"""Products of sparse matrices with three columns."""

import numpy as np
from scipy.sparse import random_array

from isoembed.linalg.products import Rows


def test_they_are_those_of_the_matrix_and_of_the_transposed_one():
    rng = np.random.default_rng(0)
    matrix = random_array((50, 50), density=0.1, rng=rng, format="csr")
    rows = Rows(matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data)
    vectors = rng.normal(size=(50, 3))
    np.testing.assert_allclose(rows @ vectors, matrix @ vectors, atol=1e-14)
    np.testing.assert_allclose(rows.transposed(vectors), matrix.T @ vectors, atol=1e-14)
