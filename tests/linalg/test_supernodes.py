"""Supernodes, against elimination of dense patterns."""

import numpy as np
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from grids import grid
from isoembed.linalg.elimination import symbolic_analysis
from isoembed.linalg.supernodes import find_supernodes, stack_size
from patterns import eliminated_pattern, random_pattern


def triangular(m):
    return m * (m + 1) // 2


@given(st.integers(1, 40), st.floats(0.0, 0.5), st.integers(0, 10**6))
def test_rows_are_all_that_the_columns_have_below(n, density, seed):
    rng = np.random.default_rng(seed)
    pattern = random_pattern(n, density, rng)
    csc = sp.csc_matrix(pattern.astype(float))
    elimination = symbolic_analysis(csc.indptr, csc.indices, rng.permutation(n))
    nodes = find_supernodes(csc.indptr, csc.indices, elimination)
    L = eliminated_pattern(pattern[np.ix_(elimination.order, elimination.order)])
    assert nodes.starts[0] == 0
    assert nodes.starts[-1] == n
    assert (np.diff(nodes.starts) > 0).all()
    entries = widest = room = 0
    waiting = []
    for s, (first, last) in enumerate(zip(nodes.starts[:-1], nodes.starts[1:], strict=True)):
        rows = nodes.rows[nodes.ends[s] : nodes.ends[s + 1]]
        expected = last + np.flatnonzero(L[last:, first:last].any(axis=1))
        assert np.array_equal(rows, expected)
        m = last - first + rows.size
        assert nodes.offsets[s] == entries
        entries += triangular(m) - triangular(rows.size)
        widest = max(widest, m)
        room = max(room, triangular(m) + sum(triangular(below.size) for _, _, below in waiting))
        # What its children pass on has a place in its front.
        leaf = s
        while waiting and nodes.parents[waiting[-1][0]] == s:
            _, leaf, below = waiting.pop()
            assert first <= below[0] < last
            assert np.isin(below, np.append(np.arange(first, last), rows)).all()
        assert nodes.leaves[s] == leaf
        if rows.size:
            waiting.append((s, leaf, rows))
        else:
            assert nodes.parents[s] == -1
    assert not waiting
    assert (nodes.entries, nodes.widest) == (entries, widest)
    assert stack_size(nodes, 0, len(nodes.parents), 0) == room


def test_few_fronts_and_few_zeros():
    matrix, order = grid(60)
    elimination = symbolic_analysis(matrix.indptr, matrix.indices, order)
    nodes = find_supernodes(matrix.indptr, matrix.indices, elimination)
    assert nodes.parents.size < order.size / 8
    assert nodes.entries < 1.5 * elimination.counts.sum()
