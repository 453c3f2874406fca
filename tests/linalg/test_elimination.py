"""Symbolic elimination, against elimination of dense matrices."""

import numpy as np
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from isoembed.linalg.elimination import symbolic_analysis
from patterns import eliminated_pattern, random_pattern


def analyzed(pattern, order):
    """The elimination of a pattern in this order."""
    csc = sp.csc_matrix(pattern.astype(float))
    return symbolic_analysis(csc.indptr, csc.indices, order.astype(np.int64))


@given(st.integers(1, 40), st.floats(0.0, 0.5), st.integers(0, 10**6))
def test_parents_and_counts_are_those_of_dense_elimination(n, density, seed):
    rng = np.random.default_rng(seed)
    pattern, order = random_pattern(n, density, rng), rng.permutation(n)
    elimination = analyzed(pattern, order)
    L = eliminated_pattern(pattern[np.ix_(elimination.order, elimination.order)])
    assert np.array_equal(elimination.counts, L.sum(axis=0))
    below = [np.flatnonzero(L[j + 1 :, j]) for j in range(n)]
    parents = [j + 1 + rows[0] if rows.size else -1 for j, rows in enumerate(below)]
    assert elimination.parent.tolist() == parents
    # Reordered within the tree, the fill is that of the order asked for; and subtrees are contiguous.
    assert L.sum() == eliminated_pattern(pattern[np.ix_(order, order)]).sum()
    first = np.arange(n)  # of each subtree
    for j, parent in enumerate(elimination.parent):
        if parent >= 0:
            first[parent] = min(first[parent], first[j])
    sizes = np.ones(n, dtype=int)
    for j, parent in enumerate(elimination.parent):
        if parent >= 0:
            sizes[parent] += sizes[j]
    assert np.array_equal(np.arange(n) - first + 1, sizes)


def test_a_chain_fills_in_proportion():
    for n in (1000, 4000):
        chain = sp.diags_array(np.ones((3, n)), offsets=(-1, 0, 1), shape=(n, n)).tocsc()
        elimination = symbolic_analysis(chain.indptr, chain.indices, np.arange(n))
        assert elimination.counts.sum() == 2 * n - 1
