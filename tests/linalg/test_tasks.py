"""Tasks of factorizations: they divide the elimination tree, and no number depends on who does them."""

import tracemalloc

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from grids import grid
from isoembed.linalg import analyze, tasks
from isoembed.linalg.elimination import symbolic_analysis
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.supernodes import find_supernodes, stack_size
from isoembed.linalg.tasks import TaskTree
from patterns import random_pattern


@pytest.fixture
def divided(monkeypatch):
    """Small matrices are divided, too."""
    monkeypatch.setattr(tasks, "SMALL", 0.0)


def nodes_of(pattern, order):
    csc = sp.csc_matrix(pattern)
    return find_supernodes(csc.indptr, csc.indices, symbolic_analysis(csc.indptr, csc.indices, order))


def assert_divides(tree):
    """Every supernode is in one task, after its children, and what other tasks pass on is taken once."""
    nodes, done, taken = tree.nodes, 0, set()
    for task, children in zip(tree.tasks, tree.children, strict=True):
        assert task.first == done < task.last
        done = task.last
        inside = np.arange(task.first, task.last)
        below = np.flatnonzero(np.isin(nodes.parents, inside))
        assert task.roots == tuple(below[below < task.first].tolist())
        assert task.roots == tuple(tree.tasks[child].last - 1 for child in children)
        assert (nodes.parents[inside[:-1]] < task.last).all()
        taken.update(task.roots)
    assert done == len(nodes.parents)
    assert taken == {task.last - 1 for task in tree.tasks if nodes.parents[task.last - 1] >= 0}


@pytest.mark.usefixtures("divided")
def test_two_threads_share_a_grid_evenly():
    matrix, order = grid(120)
    tree = TaskTree.of(nodes_of(matrix, order))
    assert_divides(tree)
    assert tasks.SHARES < len(tree.tasks) < 4 * tasks.SHARES
    work = np.add.reduceat(tasks._work(tree.nodes), [task.first for task in tree.tasks])
    path = np.zeros(len(work))  # of the tasks that wait for one another
    for t, children in enumerate(tree.children):
        path[t] = work[t] + path[list(children)].max(initial=0.0)
    assert path.max() < 0.5 * work.sum()
    assert tree.upward.order == list(range(len(tree.tasks)))  # what `room` assumes
    assert tree.room < stack_size(tree.nodes, 0, len(tree.nodes.parents), 0) + max(tree.sizes)


def test_small_matrices_are_not_divided():
    matrix, order = grid(60)
    assert len(TaskTree.of(nodes_of(matrix, order)).tasks) == 1


@pytest.mark.usefixtures("divided")
@settings(max_examples=40)
@given(st.integers(1, 40), st.floats(0.0, 0.5), st.integers(0, 10**6))
def test_random_patterns_are_divided(n, density, seed):
    rng = np.random.default_rng(seed)
    assert_divides(TaskTree.of(nodes_of(random_pattern(n, density, rng).astype(float), rng.permutation(n))))


@pytest.mark.usefixtures("divided")
@pytest.mark.parametrize("shift", [0.0, 1.2])
@pytest.mark.parametrize("columns", [(), (3,)])
def test_all_numbers_of_threads_give_the_same_bits(shift, columns):
    matrix, order = grid(30)
    matrix = sp.csc_matrix(matrix - shift * sp.eye_array(900))
    b = np.random.default_rng(0).normal(size=(900, *columns))
    answers = []
    for threads in (1, 2, 5):
        with threadpool_limits(threads):
            factor = analyze(matrix, order, definite=not shift).factor(matrix.data)
            answers.append((factor.negative_pivots, factor.solve(b, 0)))
    assert {negative for negative, _ in answers} == {int((np.linalg.eigvalsh(matrix.toarray()) < 0).sum())}
    assert np.array_equal(answers[0][1], answers[1][1])
    assert np.array_equal(answers[0][1], answers[2][1])
    np.testing.assert_allclose(matrix @ answers[0][1], b, atol=1e-10)


def test_divided_and_undivided_elimination_agree(monkeypatch):
    matrix, order = grid(50)
    b = np.random.default_rng(0).normal(size=2500)
    whole = analyze(matrix, order).factor(matrix.data).solve(b, 0)
    monkeypatch.setattr(tasks, "SMALL", 0.0)
    np.testing.assert_allclose(analyze(matrix, order).factor(matrix.data).solve(b, 0), whole, rtol=1e-11)


@pytest.mark.usefixtures("divided")
@pytest.mark.parametrize("threads", [1, 3])
def test_a_matrix_that_is_not_definite_is_refused_by_every_thread(threads):
    matrix, order = grid(40)
    matrix = sp.csc_matrix(matrix - 1.2 * sp.eye_array(1600))
    with threadpool_limits(threads), pytest.raises(SingularMatrix, match="not positive definite"):
        analyze(matrix, order).factor(matrix.data)


def test_a_wide_front_has_the_same_bits_for_any_number_of_threads():
    rng = np.random.default_rng(0)
    n = 700
    matrix = sp.csc_array(np.diag(rng.uniform(n, 2 * n, n)) + rng.uniform(0, 0.5, (n, n)))
    matrix = sp.csc_array(matrix + matrix.T)
    answers = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            answers.append(analyze(matrix, np.arange(n)).factor(matrix.data).solve(np.ones(n), 0))
    assert np.array_equal(*answers)


@pytest.mark.usefixtures("divided")
def test_many_columns_take_little_memory():
    matrix, order = grid(60)
    factor = analyze(matrix, order).factor(matrix.data)
    b = np.ones((3600, 50))
    tracemalloc.start()
    factor.solve(b, 0)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * b.nbytes  # b and x in elimination order, and the answer
