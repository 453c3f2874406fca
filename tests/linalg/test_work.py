"""Work: every factorization counts, also one that fails; budgets are shares of it."""

import numpy as np
import pytest
import scipy.sparse as sp

from isoembed.linalg import SingularMatrix, analyze, factor_general
from isoembed.linalg.work import Budget, Work
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem


def test_factorizations_count_also_those_that_fail():
    work = Work()
    solver = analyze(sp.csc_array(np.ones((2, 2))), [0, 1], work=work)
    assert work.factorizations == 0
    solver.factor([2.0, 1.0, 1.0, 2.0])
    with pytest.raises(SingularMatrix):
        solver.factor([1.0, 1.0, 1.0, 1.0])
    with pytest.raises(SingularMatrix):
        factor_general(sp.csc_array(np.ones((2, 2))), work)
    assert work.factorizations == 3


@pytest.mark.parametrize("n", [6, 400])  # by edges, and by vertices where one has many edges
@pytest.mark.parametrize("mu", [0.0, 1e-3])
def test_a_step_is_one_factorization_in_the_edges_or_the_vertices(n, mu):
    angles = 2 * np.pi * np.arange(n) / n
    tips = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
    x = np.vstack([np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), tips])
    around = [(k, (k + 1) % n) for k in range(n)]
    faces = [(a, b, n) for a, b in around] + [(b, a, n + 1) for a, b in around]
    metric, work = PolyhedralMetric.from_mesh(x, faces), Work()
    system = LengthSystem(Triangulation(faces), work=work)
    system.step(x, metric.lengths, np.full(len(metric.lengths), 1e-3), mu)
    assert work.factorizations == 1


def test_a_budget_counts_from_when_it_is_made():
    work = Work(5)
    budget = Budget(work, 3)
    work.factorizations += 2
    budget.spend(0.5)
    assert (budget.spent, budget.left, budget.exhausted) == (2.5, 0.5, False)
    budget.spend(1.0)
    assert (budget.left, budget.exhausted) == (0.0, True)
    budget.close()
    assert (work.factorizations, budget.shares) == (9, 0.0)
