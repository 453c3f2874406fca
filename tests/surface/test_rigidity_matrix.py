"""Products with the rigidity matrix, and their memory."""

import numpy as np
import pytest

import isoembed.linalg.memory as memory
import zoo
from isoembed.linalg import OutOfMemory
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.rigidity_matrix import RigidityMatrix, coupled_edges


class Problem:
    """An ellipsoid with vertices moved a little, by smooth and by rough displacements."""

    def __init__(self, level, stretch=(3.0, 2.0, 1.0)):
        vertices, faces = zoo.icosphere(level)
        exact = vertices * stretch * 2.0**level
        self.triangulation = Triangulation(faces)
        a, b = self.triangulation.edges.T
        self.lengths = np.linalg.norm(exact[a] - exact[b], axis=1)
        noise = np.random.default_rng(level).normal(size=exact.shape)
        self.vertices = exact + 1e-3 * np.sin(exact[:, [1, 2, 0]]) + 1e-4 * noise
        self.residuals = length_residuals(self.triangulation, self.vertices, self.lengths)


def dense(problem):
    a, b = problem.triangulation.edges.T
    J = np.zeros((len(a), len(problem.vertices), 3))
    rows = edge_rows(problem.triangulation, problem.vertices, problem.lengths)
    J[np.arange(len(a)), a], J[np.arange(len(a)), b] = rows, -rows
    return J.reshape(len(a), -1)


def test_products_are_those_of_the_matrix():
    problem = Problem(1)
    J, ends = dense(problem), problem.triangulation.edges.astype(np.int32)
    rigidity = RigidityMatrix.of(ends, problem.vertices, problem.lengths)
    rng = np.random.default_rng(0)
    motion, tensions = rng.normal(size=problem.vertices.shape), rng.normal(size=len(ends))
    assert rigidity.rates(motion) == pytest.approx(J @ motion.ravel(), abs=1e-13)
    assert rigidity.forces(tensions).ravel() == pytest.approx(J.T @ tensions, abs=1e-13)
    assert rigidity.rates(rigidity.forces(tensions)) == pytest.approx(J @ (J.T @ tensions), abs=1e-12)
    indptr, indices = coupled_edges(ends, len(problem.vertices))
    gram = np.zeros((len(ends), len(ends)))
    for e in range(len(ends)):
        here = slice(indptr[e], indptr[e + 1])
        assert (np.diff(indices[here]) > 0).all()
        gram[e, indices[here]] = rigidity.gram(indptr, indices, 0.25)[here]
    assert gram == pytest.approx(J @ J.T + 0.25 * np.eye(len(ends)), abs=1e-13)
    shared = (np.abs(J) > 0).reshape(len(ends), -1, 3).any(axis=2).astype(int)
    assert np.array_equal(np.diff(indptr), (shared @ shared.T > 0).sum(axis=1))


def test_a_hub_of_too_many_edges_is_refused(monkeypatch):
    ends = np.column_stack([np.zeros(50_000), np.arange(1, 50_001)]).astype(np.int32)
    with pytest.raises(OutOfMemory, match=r"J J\^T would have 2500000000 entries, more than can be numbered"):
        coupled_edges(ends, 50_001)
    monkeypatch.setattr(memory, "available_memory", lambda: 10**9)
    with pytest.raises(OutOfMemory, match=r"the products of 10000 edges need about 2\.5 GB of memory"):
        coupled_edges(ends[:10_000], 10_001)


def test_factors_that_do_not_fit_are_refused(monkeypatch):
    problem = Problem(3)
    system = LengthSystem(problem.triangulation)
    needs = system._solver.needs
    monkeypatch.setattr(memory, "UNASKED", 0)
    monkeypatch.setattr(memory, "available_memory", lambda: needs - 1)
    with pytest.raises(OutOfMemory, match=r"the factors of a matrix of \d+ unknowns need"):
        system.step(problem.vertices, problem.lengths, problem.residuals)
