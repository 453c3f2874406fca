"""Steps without large factors: those of the factors, in as many iterations at any size, in less memory."""

import numpy as np
import pytest

import isoembed.linalg.memory as memory
import isoembed.surface.two_level as two_level
import zoo
from isoembed.linalg import OutOfMemory, dissect
from isoembed.linalg.factor import Solver
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.rigidity_matrix import RigidityMatrix, coupled_edges
from isoembed.surface.two_level import MAX_AGGREGATE, TwoLevel


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

    def two_level(self, damping=0.0):
        J = RigidityMatrix.of(self.triangulation.edges.astype(np.int32), self.vertices, self.lengths)
        return TwoLevel(J, self.vertices, dissect(self.triangulation.adjacency), damping)


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


@pytest.mark.parametrize("damping", [0.0, 1e-3, 1.0])
def test_steps_are_those_of_dense_algebra(damping):
    problem = Problem(2)
    J = dense(problem)
    found = problem.two_level(damping).step(problem.residuals, 1e-12, 200)
    assert found.residual <= 1e-12
    if damping:
        N = J.T @ J + damping * np.eye(J.shape[1])
        expected = np.linalg.solve(N, J.T @ problem.residuals)
    else:
        expected = np.linalg.lstsq(J, problem.residuals, rcond=None)[0]
    assert found.x.ravel() == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


def test_the_preconditioner_is_symmetric_and_definite():
    problem = Problem(2)
    system = problem.two_level()
    precondition = system._preconditioned
    tensions = np.random.default_rng(5).normal(size=(2, problem.triangulation.n_edges))
    v, w = (system._J.forces(y) for y in tensions)  # without a rigid motion
    assert np.vdot(v, precondition(w)) == pytest.approx(np.vdot(precondition(v), w), rel=1e-9)
    assert np.vdot(v, precondition(v)) > 0


def test_iterations_do_not_grow_with_the_mesh():
    counts = []
    for level in (2, 3, 4):
        problem = Problem(level)
        counts.append(problem.two_level().step(problem.residuals, 1e-10, 100).iterations)
    assert max(counts) < 45
    assert counts[2] < 1.3 * counts[1]


@pytest.mark.parametrize(("damping", "most"), [(1e-6, 40), (1e-2, 25), (1.0, 15)])
def test_damping_makes_it_easier(damping, most):
    problem = Problem(4)
    assert problem.two_level(damping).step(problem.residuals, 1e-10, 100).iterations < most


def test_bodies_are_small_and_the_coarse_factors_take_little(monkeypatch):
    problem = Problem(4)
    system = LengthSystem(problem.triangulation)
    solvers = []

    def analyzed(pattern, order):
        solvers.append(Solver(pattern, order, True))
        return solvers[0]

    monkeypatch.setattr(two_level, "analyze", analyzed)
    bodies = problem.two_level()._bodies
    sizes = np.bincount(bodies.of_vertex)
    assert sizes.max() <= MAX_AGGREGATE
    assert sizes.mean() > MAX_AGGREGATE / 3
    assert solvers[0].needs < system._solver.needs / 6


def test_a_flat_vertex_does_no_harm():
    # Midpoints of the edges of a cube's triangles: most vertices have all edges in a plane.
    vertices, faces = zoo.cube()
    for _ in range(3):
        vertices, faces = zoo.subdivided(vertices, faces)
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    J = RigidityMatrix.of(triangulation.edges.astype(np.int32), vertices, lengths)
    motion = np.sin(5 * vertices[:, [1, 2, 0]])
    step = TwoLevel(J, vertices, dissect(triangulation.adjacency), 0.0).step(J.rates(motion), 1e-10, 500).x
    assert J.rates(step) == pytest.approx(J.rates(motion), abs=1e-7)


@pytest.mark.parametrize("mu", [0.0, 1e-2])
def test_where_factors_do_not_fit_the_step_is_made_without(monkeypatch, mu):
    problem = Problem(3)
    given = (problem.vertices, problem.lengths, problem.residuals, mu)
    expected = LengthSystem(problem.triangulation).step(*given)
    monkeypatch.setattr(memory, "UNASKED", 0)
    refused = LengthSystem(problem.triangulation)
    needs = LengthSystem(problem.triangulation)._solver.needs
    monkeypatch.setattr(memory, "available_memory", lambda: needs // 2)
    with pytest.raises(OutOfMemory):
        refused._solver  # noqa: B018
    step = refused.step(*given)
    assert step == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())
    monkeypatch.setattr(memory, "available_memory", lambda: 0)
    with pytest.raises(OutOfMemory, match=r"the factors of a matrix of \d+ unknowns need"):
        refused.step(*given)
