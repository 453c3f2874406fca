"""The solvers: answers, refinement, inertia and refusals, against NumPy."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from isoembed.linalg import SingularMatrix, analyze, dissect, factor_general
from isoembed.linalg.elimination import first_asymmetry, first_gap, inverse, permuted
from isoembed.linalg.symmetric import SymmetricMatrix


class Mesh:
    """The hull of points on an ellipsoid, and the matrices that live on it."""

    def __init__(self, n, stretch=(3.0, 2.0, 1.0), seed=0):
        points = np.random.default_rng(seed).normal(size=(n, 3))
        self.points = points / np.linalg.norm(points, axis=1)[:, None] * stretch
        faces = ConvexHull(self.points).simplices.astype(np.int64)
        halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        self.edges = np.unique(np.sort(halves, axis=1), axis=0)
        self.n, self.n_edges = n, len(self.edges)
        graph = sp.coo_array((np.ones(self.n_edges), self.edges.T), shape=(n, n))
        self.adjacency = (graph + graph.T).tocsr()
        self.tree = dissect(self.adjacency)
        row = np.arange(self.n_edges)
        incidence = sp.csr_array((np.ones(2 * row.size), (np.tile(row, 2), self.edges.T.ravel())))
        self.edge_pattern = sp.csc_array(incidence @ incidence.T)
        self.edge_pattern.sort_indices()

    def rigidity_gram(self):
        """J J^T of the squared-length map over the lengths, values in the order of `edge_pattern`."""
        a, b = self.points[self.edges[:, 0]], self.points[self.edges[:, 1]]
        d = (a - b) / np.linalg.norm(a - b, axis=1)[:, None]
        i, j = (
            self.edge_pattern.indices,
            np.repeat(np.arange(self.n_edges), np.diff(self.edge_pattern.indptr)),
        )
        sign = np.zeros(i.size)
        for p in range(2):
            for q in range(2):
                sign += (1 if p == q else -1) * (self.edges[i, p] == self.edges[j, q])
        return sign * np.einsum("ej,ej->e", d[i], d[j])

    def solver(self):
        return analyze(self.edge_pattern, self.tree.edge_order(self.edges))

    def laplacian(self, shift):
        degrees = self.adjacency.sum(axis=1)
        return sp.csc_array(sp.diags_array(degrees + shift) - self.adjacency)


def with_data(pattern, data):
    return sp.csc_array((data, pattern.indices, pattern.indptr), shape=pattern.shape)


def rhs(n, *columns):
    return np.random.default_rng(7).normal(size=(n, *columns))


def test_solves_what_numpy_solves():
    mesh = Mesh(60)
    data = mesh.rigidity_gram()
    b = rhs(mesh.n_edges)
    x = mesh.solver().factor(data).solve(b)
    exact = np.linalg.solve(with_data(mesh.edge_pattern, data).toarray(), b)
    np.testing.assert_allclose(x, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_vertex_and_block_orders():
    mesh = Mesh(300)
    laplacian = mesh.laplacian(0.1)
    b = rhs(mesh.n)
    x = analyze(laplacian, mesh.tree.vertex_order()).factor(laplacian.data).solve(b)
    assert np.abs(laplacian @ x - b).max() < 1e-12
    blocks = sp.csc_array(sp.kron(laplacian, [[2.0, 0.5, 0.5], [0.5, 2.0, 0.5], [0.5, 0.5, 2.0]]))
    blocks.sort_indices()
    b = rhs(3 * mesh.n)
    x = analyze(blocks, mesh.tree.block_order(3)).factor(blocks.data).solve(b)
    assert np.abs(blocks @ x - b).max() < 1e-12


def test_any_order_gives_the_same_answer():
    mesh = Mesh(200)
    data, b = mesh.rigidity_gram(), rhs(mesh.n_edges)
    shuffled = np.random.default_rng(3).permutation(mesh.n_edges)
    x = analyze(mesh.edge_pattern, shuffled).factor(data).solve(b)
    expected = mesh.solver().factor(data).solve(b)
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-9 * np.abs(x).max())


def test_tiny_matrices():
    mesh = Mesh(4)
    data, b = mesh.rigidity_gram(), rhs(6)
    matrix = with_data(mesh.edge_pattern, data)
    np.testing.assert_allclose(matrix @ mesh.solver().factor(data).solve(b), b, atol=1e-12)
    one = analyze(sp.csc_array([[4.0]]), [0]).factor([4.0])
    assert one.solve([2.0]) == pytest.approx([0.5])


def test_several_right_hand_sides():
    mesh = Mesh(150)
    factor = mesh.solver().factor(mesh.rigidity_gram())
    b = rhs(mesh.n_edges, 4)
    x = factor.solve(b)
    assert x.shape == b.shape
    for k in range(4):
        np.testing.assert_allclose(x[:, k], factor.solve(b[:, k]), rtol=1e-8, atol=1e-9 * np.abs(x).max())


def test_one_analysis_serves_many_matrices():
    mesh = Mesh(200)
    solver, data, b = mesh.solver(), mesh.rigidity_gram(), rhs(mesh.n_edges)
    matrices = [data.copy() for _ in range(4)]
    diagonal = mesh.edge_pattern.indices == np.repeat(
        np.arange(mesh.n_edges), np.diff(mesh.edge_pattern.indptr)
    )
    for k, values in enumerate(matrices):
        values[diagonal] += k
    factors = [solver.factor(values) for values in matrices]
    del factors[2]  # its memory may be used again
    factors.insert(2, solver.factor(matrices[2]))
    # every factor still is of its own matrix, and as if it had been alone
    for values, factor in zip(matrices, factors, strict=True):
        fresh = mesh.solver().factor(values).solve(b)
        np.testing.assert_allclose(factor.solve(b), fresh, rtol=0, atol=1e-10 * np.abs(fresh).max())


def test_the_factor_keeps_its_own_data():
    mesh = Mesh(50)
    data, b = mesh.rigidity_gram(), rhs(mesh.n_edges)
    factor = mesh.solver().factor(data)
    before = factor.solve(b)
    data[:] = 0.0
    assert np.array_equal(factor.solve(b), before)


def test_explicit_zeros_stay_in_the_pattern():
    mesh = Mesh(100)
    n = mesh.n
    pattern = mesh.laplacian(1.0)
    i, j = pattern.indices, np.repeat(np.arange(n), np.diff(pattern.indptr))
    diagonal_only = np.where(i == j, 2.0, 0.0)
    solver = analyze(with_data(pattern, diagonal_only), mesh.tree.vertex_order())
    assert solver.pattern.nnz == pattern.nnz
    b = rhs(n)
    np.testing.assert_allclose(solver.factor(diagonal_only).solve(b), b / 2, rtol=1e-14)
    assert np.abs(pattern @ solver.factor(pattern.data).solve(b) - b).max() < 1e-12


def singular_matrices():
    mesh = Mesh(300)
    laplacian = mesh.laplacian(0.0)
    yield "laplacian", laplacian, laplacian.data
    pattern = mesh.laplacian(1.0)
    i, j = pattern.indices, np.repeat(np.arange(mesh.n), np.diff(pattern.indptr))
    indefinite = np.where(i == j, 1.0, -1.0)
    yield "indefinite, positive diagonal", pattern, indefinite
    barely = pattern.data - np.where(i == j, 1.001, 0.0)
    yield "one small negative eigenvalue", pattern, barely
    yield "negative definite", pattern, -pattern.data
    zero = np.where((i == 17) | (j == 17), 0.0, pattern.data)
    yield "zero row", pattern, zero
    for name, value in (("nan", np.nan), ("inf", np.inf)):
        bad = pattern.data.copy()
        bad[5] = value
        yield name, pattern, bad
    two_equal_rows = sp.block_diag([sp.identity(50), np.ones((2, 2)), sp.identity(50)], format="csc")
    yield "two equal rows", two_equal_rows, two_equal_rows.data
    # singular but for rounding: the last pivot comes out as a tiny number of either sign
    gram = np.array([[2.0, -1.0, 0.1], [-1.0, 2.0, 0.2], [0.1, 0.2, 0.0]])
    gram[2, 2] = gram[2, :2] @ np.linalg.solve(gram[:2, :2], gram[2, :2])
    yield "schur complement zero", sp.csc_array(gram), gram.ravel()


@pytest.mark.parametrize(
    ("pattern", "data"), [pytest.param(p, d, id=name) for name, p, d in singular_matrices()]
)
def test_what_is_not_positive_definite_is_refused(pattern, data):
    solver = analyze(pattern, np.arange(pattern.shape[0]))
    with pytest.raises(SingularMatrix, match=r"^the matrix is "):
        solver.factor(data)
    # and the solver survives
    good = sp.csc_array(
        with_data(solver.pattern, -np.ones(solver.pattern.nnz)) + sp.identity(pattern.shape[0]) * 999
    )
    assert np.isfinite(solver.factor(good.data).solve(rhs(pattern.shape[0]))).all()


def test_bad_scaling_is_not_singularity():
    mesh = Mesh(200)
    laplacian = mesh.laplacian(0.1)
    scale = sp.diags_array(10.0 ** np.random.default_rng(0).uniform(-12, 12, mesh.n))
    scaled = sp.csc_array(scale @ laplacian @ scale)
    truth = rhs(mesh.n) / scale.diagonal()
    x = analyze(scaled, mesh.tree.vertex_order()).factor(scaled.data).solve(scaled @ truth)
    assert np.abs((x - truth) * scale.diagonal()).max() < 1e-8


def slender():
    """J and J J^T of a slender body: sigma_min(J) = 1e-5, and the condition number of J J^T is 1e11."""
    mesh = Mesh(400, stretch=(1.0, 1.0, 6e-4))
    a, b = mesh.edges.T
    d = mesh.points[a] - mesh.points[b]
    d /= np.linalg.norm(d, axis=1)[:, None]
    rows = np.repeat(np.arange(mesh.n_edges), 3)
    columns = [(3 * end[:, None] + np.arange(3)).ravel() for end in (a, b)]
    rigidity = sp.csr_array(
        (np.concatenate((d.ravel(), -d.ravel())), (np.tile(rows, 2), np.concatenate(columns))),
        shape=(mesh.n_edges, 3 * mesh.n),
    )
    gram = with_data(mesh.edge_pattern, mesh.rigidity_gram())
    sigma = np.sqrt(np.linalg.eigvalsh(gram.toarray())[0])
    assert 1e-6 < sigma < 1e-4
    return mesh, rigidity, gram


def test_refinement_makes_an_ill_conditioned_solve_componentwise_stable():
    mesh, _, gram = slender()
    # An order that fills in rounds often enough to leave something to refine.
    factor = analyze(gram, np.arange(mesh.n_edges)).factor(gram.data)
    b = rhs(mesh.n_edges)

    def backward_error(sweeps):
        x = factor.solve(b, sweeps=sweeps)
        return np.max(np.abs(b - gram @ x) / (abs(gram) @ np.abs(x) + np.abs(b)))

    errors = [backward_error(sweeps) for sweeps in (0, 1, 2)]
    assert errors[1] < 0.8 * errors[0]
    assert max(errors[1:]) < 3e-16


def test_least_norm_steps_are_refined_through_the_rigidity_matrix():
    # y = (J J^T)^-1 r is as large as 1 / sigma^2: rounded, it cannot leave J J^T y - r small. dx = J^T y can.
    mesh, rigidity, gram = slender()
    factor = mesh.solver().factor(gram.data)
    r = rhs(mesh.n_edges)
    step = rigidity.T @ factor.solve(r, sweeps=0)
    rough = np.linalg.norm(rigidity @ step - r) / np.linalg.norm(r)
    step += rigidity.T @ factor.solve(r - rigidity @ step, sweeps=0)
    refined = np.linalg.norm(rigidity @ step - r) / np.linalg.norm(r)
    assert refined < 1e-13
    assert refined < 1e-4 * rough


def shifted(mesh, shift):
    """A Laplacian less a multiple of the identity, and its number of negative eigenvalues."""
    matrix = mesh.laplacian(-shift)
    return matrix, int((np.linalg.eigvalsh(matrix.toarray()) < 0).sum())


@pytest.mark.parametrize("shift", [-0.1, 0.1, 4.1, 30.0])
def test_indefinite_matrices_and_their_inertia(shift):
    mesh = Mesh(200)
    matrix, negative = shifted(mesh, shift)
    assert negative == {-0.1: 0, 0.1: 1, 30.0: 200}.get(shift, negative)
    solver = analyze(matrix, mesh.tree.vertex_order(), definite=False)
    factor = solver.factor(matrix.data)
    assert factor.negative_pivots == negative
    b = rhs(mesh.n, 2)
    np.testing.assert_allclose(factor.solve(b), np.linalg.solve(matrix.toarray(), b), rtol=1e-7, atol=1e-9)
    assert np.abs(matrix @ factor.solve(b, sweeps=0) - b).max() < 1e-9


def test_one_analysis_serves_indefinite_matrices_of_any_inertia():
    mesh = Mesh(100)
    solver = analyze(mesh.laplacian(1.0), mesh.tree.vertex_order(), definite=False)
    cases = [shifted(mesh, shift) for shift in (-1.0, 2.5, 5.5)]
    factors = [solver.factor(matrix.data) for matrix, _ in cases]
    assert [factor.negative_pivots for factor in factors] == [negative for _, negative in cases]
    with pytest.raises(SingularMatrix):
        solver.factor(np.zeros(solver.pattern.nnz))
    b = rhs(mesh.n)
    for (matrix, _), factor in zip(cases, factors, strict=True):
        assert np.abs(matrix @ factor.solve(b) - b).max() < 1e-10


def test_bad_scaling_of_an_indefinite_matrix_is_not_singularity():
    mesh = Mesh(200)
    matrix, negative = shifted(mesh, 2.5)
    scale = sp.diags_array(10.0 ** np.random.default_rng(0).uniform(-12, 12, mesh.n))
    scaled = sp.csc_array(scale @ matrix @ scale)
    truth = rhs(mesh.n) / scale.diagonal()
    factor = analyze(scaled, mesh.tree.vertex_order(), definite=False).factor(scaled.data)
    assert factor.negative_pivots == negative
    assert np.abs((factor.solve(scaled @ truth) - truth) * scale.diagonal()).max() < 1e-8


def unfactorable_matrices():
    yield "exchange", [[0.0, 1.0], [1.0, 0.0]]
    yield "zero", np.zeros((3, 3))
    yield "zero row", [[1.0, 0.0, 2.0], [0.0, 0.0, 0.0], [2.0, 0.0, 1.0]]
    yield "two equal rows", [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    yield "nan", [[1.0, np.nan], [np.nan, 1.0]]
    yield "inf", [[1.0, 0.0], [0.0, np.inf]]
    gram = np.array([[2.0, -1.0, 0.1], [-1.0, -2.0, 0.2], [0.1, 0.2, 0.0]])
    gram[2, 2] = gram[2, :2] @ np.linalg.solve(gram[:2, :2], gram[2, :2])
    yield "schur complement zero", gram


@pytest.mark.parametrize(
    "matrix", [pytest.param(np.array(m), id=name) for name, m in unfactorable_matrices()]
)
def test_what_has_no_factors_down_the_diagonal_is_refused(matrix):
    n = len(matrix)
    solver = analyze(sp.csc_array(np.ones((n, n))), np.arange(n), definite=False)
    with pytest.raises(SingularMatrix, match=r"^the matrix "):
        solver.factor(matrix.ravel())
    # and the solver survives
    good = np.ones((n, n)) - 9 * np.eye(n)
    factor = solver.factor(good.ravel())
    assert factor.negative_pivots == n
    np.testing.assert_allclose(good @ factor.solve(rhs(n)), rhs(n), rtol=1e-12)


def test_a_pivot_lost_in_rounding_spoils_no_solution():
    matrix = np.array([[1e-20, 1.0], [1.0, 1.0]])
    solver = analyze(sp.csc_array(matrix), np.arange(2), definite=False)
    with pytest.raises(SingularMatrix, match=r"^the matrix has no accurate factors L D L\^T in this order"):
        solver.factor(matrix.ravel())


def test_a_zero_on_the_diagonal_is_no_zero_pivot():
    matrix = np.array([[2.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    solver = analyze(sp.csc_array(np.ones((3, 3))), np.arange(3), definite=False)
    factor = solver.factor(matrix.ravel())
    assert factor.negative_pivots == int((np.linalg.eigvalsh(matrix) < 0).sum()) == 1
    np.testing.assert_allclose(factor.solve(rhs(3)), np.linalg.solve(matrix, rhs(3)), rtol=1e-12)


def test_bad_input_is_refused():
    square = sp.csc_array(np.array([[2.0, 1.0], [1.0, 2.0]]))
    with pytest.raises(ValueError, match="not a permutation of the 2 unknowns"):
        analyze(square, [0, 0])
    with pytest.raises(ValueError, match="not symmetric: of the entries 0, 1 and 1, 0 one is missing"):
        analyze(sp.csc_array(np.array([[2.0, 1.0], [0.0, 2.0]])), [0, 1])
    with pytest.raises(ValueError, match="not symmetric: of the entries 1, 0 and 0, 1 one is missing"):
        analyze(sp.csc_array(np.array([[2.0, 0.0], [1.0, 2.0]])), [0, 1])
    with pytest.raises(ValueError, match="not a permutation of the 2 unknowns"):
        analyze(square, [0, 1, 2])
    with pytest.raises(ValueError, match="lacks diagonal entry 1"):
        analyze(sp.csc_array(np.array([[2.0, 1.0], [1.0, 0.0]])), [0, 1])
    solver = analyze(square, [1, 0])
    with pytest.raises(ValueError, match="has 4 entries, but the data have shape"):
        solver.factor(np.ones(3))
    with pytest.raises(ValueError, match="has 2 rows, but the right-hand side has shape"):
        solver.factor(square.data).solve(np.ones(3))


@settings(deadline=None, max_examples=50)
@given(n=st.integers(1, 12), seed=st.integers(0, 10**6), lower=st.booleans())
def test_patterns_are_brought_into_elimination_order(n, seed, lower):
    rng = np.random.default_rng(seed)
    matrix = np.triu(np.where(rng.random((n, n)) < 0.4, rng.integers(1, 1000, (n, n)), 0), 1)
    matrix += matrix.T + np.diag(rng.integers(1, 1000, n))
    csc, order = sp.csc_array(matrix), rng.permutation(n)
    assert np.array_equal(inverse(order)[order], np.arange(n))
    indptr, indices, source = permuted(csc.indptr, csc.indices, order, lower)
    ordered = sp.csc_array((csc.data[source], indices, indptr), shape=(n, n))
    expected = matrix[np.ix_(order, order)]
    assert np.array_equal(ordered.toarray(), np.tril(expected) if lower else expected)
    assert ordered.has_sorted_indices
    assert first_asymmetry(csc.indptr, csc.indices) == (-1, -1)
    assert first_gap(csc.indptr, csc.indices) == -1
    i, j = rng.integers(0, n, 2)
    matrix[i, j] = 0
    holed = sp.csc_array(matrix)
    asymmetry = first_asymmetry(holed.indptr, holed.indices)
    if i == j:
        assert asymmetry == (-1, -1)
        assert first_gap(holed.indptr, holed.indices) == i
    elif csc[i, j] != 0:
        assert asymmetry == (j, i)


def lower_triangle(matrix):
    lower = sp.csc_array(sp.tril(matrix))
    return SymmetricMatrix(lower.indptr.astype(np.int32), lower.indices.astype(np.int32), lower.data)


@pytest.mark.parametrize("columns", [(), (1,), (3,)])
def test_products_with_the_lower_triangle(columns):
    matrix, x = Mesh(50).laplacian(0.3), rhs(50, *columns)
    half = lower_triangle(matrix)
    np.testing.assert_allclose(half @ x, matrix @ x, rtol=0, atol=1e-14)
    assert np.array_equal(half.diagonal(), matrix.diagonal())


def test_sizes_bring_the_entries_of_every_row_to_one():
    matrix = Mesh(100).laplacian(-2.5)
    decades = np.random.default_rng(1).uniform(-6, 6, 100)
    scaled = sp.csc_array(sp.diags_array(10.0**decades) @ matrix @ sp.diags_array(10.0**decades))
    s = lower_triangle(scaled).sizes()
    largest = abs(sp.diags_array(1 / s) @ scaled @ sp.diags_array(1 / s)).max(axis=0).toarray()
    assert largest.min() > 0.3
    assert largest.max() < 3.0


def general_matrix(mesh):
    rng = np.random.default_rng(1)
    values = with_data(sp.csc_array(mesh.adjacency), rng.normal(size=mesh.adjacency.nnz))
    return sp.csc_array(values + sp.diags_array(rng.normal(size=mesh.n)))


def test_general_matrices():
    matrix = general_matrix(Mesh(200))
    for b in (rhs(200), rhs(200, 2)):
        exact = np.linalg.solve(matrix.toarray(), b)
        np.testing.assert_allclose(
            factor_general(matrix).solve(b), exact, rtol=0, atol=1e-9 * np.abs(exact).max()
        )


@pytest.mark.parametrize("unit", [1e-150, 1e150])
def test_units_are_not_singularity(unit):
    matrix, b = general_matrix(Mesh(200)), rhs(200)
    x = factor_general(matrix).solve(b)
    np.testing.assert_allclose(factor_general(unit * matrix).solve(unit * b), x, atol=1e-9 * np.abs(x).max())


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((3, 3)),
        np.array([[1.0, 2.0], [2.0, 4.0]]),
        np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, 0.8, 0.9]]),
        np.array([[np.nan, 1.0], [1.0, 1.0]]),
    ],
)
def test_singular_general_matrices_are_refused(matrix):
    with pytest.raises(SingularMatrix, match=r"^the matrix is "):
        factor_general(sp.csc_array(matrix))
