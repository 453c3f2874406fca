"""Matrices of other fields: finite differences, elasticity, networks, saddle points; inertia and refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.csgraph import minimum_spanning_tree

from isoembed.linalg import SingularMatrix, analyze, dissect


def factored(matrix, order, *, definite):
    pattern = sp.csc_matrix(matrix)
    pattern.sort_indices()
    return analyze(pattern, order, definite=definite).factor(pattern.data)


def second_difference(n):
    return sp.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])


def box(*sides):
    """The Laplacian by finite differences on a box, with values zero around it, and its eigenvalues."""
    total = sp.csc_array((1, 1))
    eigenvalues = np.zeros(1)
    for side in sides:
        one = second_difference(side)
        total = sp.kron(total, sp.eye_array(side)) + sp.kron(sp.eye_array(total.shape[0]), one)
        along = 4 * np.sin(np.pi * np.arange(1, side + 1) / (2 * side + 2)) ** 2
        eigenvalues = (eigenvalues[:, None] + along).ravel()
    return sp.csc_array(total), np.sort(eigenvalues)


@pytest.mark.parametrize("sides", [(60, 45), (13, 11, 9)], ids=["membrane", "cavity"])
def test_eigenvalues_are_counted_by_the_inertia(sides):
    """Sylvester's law: negative pivots of A - s I are the eigenvalues below s, which are known."""
    matrix, eigenvalues = box(*sides)
    order = dissect(matrix).vertex_order()
    for count in (0, 1, 3, 20):
        gap = np.flatnonzero(np.diff(eigenvalues) > 1e-9)
        k = -1 if count == 0 else int(gap[gap >= count - 1][0])
        shift = eigenvalues[0] / 2 if k < 0 else (eigenvalues[k] + eigenvalues[k + 1]) / 2
        shifted = matrix - shift * sp.eye_array(matrix.shape[0])
        assert factored(shifted, order, definite=False).negative_pivots == k + 1


def test_elasticity_of_a_plate():
    """Bilinear elements in plane stress, clamped on one side: two unknowns a node."""
    nx, ny, nu = 24, 10, 0.3
    g = np.array([-1, 1]) / np.sqrt(3)
    D = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)
    stiffness = np.zeros((8, 8))
    for x in g:
        for y in g:
            dx = np.array([-(1 - y), 1 - y, 1 + y, -(1 + y)]) / 2
            dy = np.array([-(1 - x), -(1 + x), 1 + x, 1 - x]) / 2
            B = np.zeros((3, 8))
            B[0, ::2], B[1, 1::2] = dx, dy
            B[2, ::2], B[2, 1::2] = dy, dx
            stiffness += B.T @ D @ B / 4
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    nodes = np.column_stack([i, i + 1, i + 1, i]) * (ny + 1) + np.column_stack([j, j, j + 1, j + 1])
    unknowns = (2 * nodes[:, :, None] + [0, 1]).reshape(len(nodes), 8)
    rows, columns = np.repeat(unknowns, 8, axis=1).ravel(), np.tile(unknowns, 8).ravel()
    whole = sp.csc_array((np.tile(stiffness.ravel(), len(nodes)), (rows, columns)))
    free = np.arange(2 * (ny + 1), whole.shape[0])
    matrix = whole[free][:, free]
    neighbors = sp.csr_array(abs(matrix)[::2][:, ::2])
    order = dissect(neighbors).block_order(2)
    load = np.zeros(len(free))
    load[-1] = -1.0
    x = factored(matrix, order, definite=True).solve(load)
    assert abs(load @ x / np.linalg.solve(matrix.toarray(), load)[-1] / load[-1] - 1) < 1e-9
    with pytest.raises(SingularMatrix):  # without the clamp three motions are free
        factored(whole, np.arange(whole.shape[0]), definite=True)


def network(n, rng):
    """Nodes in the plane joined to near ones, as power lines are: a spanning tree and some chords."""
    points = rng.uniform(size=(n, 2))
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    tree = minimum_spanning_tree(distances).toarray() > 0
    near = distances <= np.partition(distances, 2, axis=1)[:, 2:3]
    joined = tree | tree.T | near | near.T
    np.fill_diagonal(joined, False)
    return sp.csr_array(joined * rng.uniform(0.5, 2.0, (n, n)))


def test_conductances_of_a_network():
    rng = np.random.default_rng(0)
    conductances = network(300, rng)
    conductances = (conductances + conductances.T) / 2
    laplacian = sp.csc_array(sp.diags_array(conductances.sum(axis=0)) - conductances)
    order = dissect(conductances).vertex_order()
    with pytest.raises(SingularMatrix):  # a constant potential drives no current
        factored(laplacian, order, definite=False)
    grounded = laplacian + sp.diags_array(np.eye(300)[0])
    b = rng.normal(size=300)
    np.testing.assert_allclose(
        factored(grounded, order, definite=True).solve(b), np.linalg.solve(grounded.toarray(), b), rtol=1e-9
    )


@pytest.mark.parametrize("seed", range(4))
def test_quasidefinite_saddle_points_have_factors_in_any_order(seed):
    """Interior-point and regularized equality constraints; Vanderbei, SIAM J. Optim. 5 (1995)."""
    rng = np.random.default_rng(seed)
    n, m = 120, 40
    H, _ = box(12, 10)
    B = sp.random_array((m, n), density=0.05, rng=rng)
    matrix = sp.csc_array(sp.block_array([[H, B.T], [B, -0.5 * sp.eye_array(m)]]))
    b = rng.normal(size=n + m)
    factors = factored(matrix, rng.permutation(n + m), definite=False)
    assert factors.negative_pivots == m
    np.testing.assert_allclose(factors.solve(b), np.linalg.solve(matrix.toarray(), b), rtol=0, atol=1e-10)


def test_a_saddle_point_that_needs_exchanges_is_refused():
    """With constraints first their pivots are zero: no L D L^T with a diagonal D in this order."""
    H, _ = box(6, 5)
    B = sp.csr_array(np.random.default_rng(0).normal(size=(4, 30)))
    matrix = sp.csc_array(sp.block_array([[sp.csr_array((4, 4)), B], [B.T, H]]))
    ones = sp.csc_array((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    pattern = sp.csc_matrix(ones + sp.eye_array(34))
    dense = matrix.toarray()
    rows, columns = pattern.indices, np.repeat(np.arange(34), np.diff(pattern.indptr))
    with pytest.raises(SingularMatrix, match=r"no (accurate )?factors L D L\^T in this order"):
        analyze(pattern, np.arange(34), definite=False).factor(dense[rows, columns])
    last = np.concatenate([np.arange(4, 34), np.arange(4)])
    factors = analyze(pattern, last, definite=False).factor(dense[rows, columns])
    b = np.ones(34)
    np.testing.assert_allclose(factors.solve(b), np.linalg.solve(dense, b), rtol=0, atol=1e-10)
    assert factors.negative_pivots == 4
