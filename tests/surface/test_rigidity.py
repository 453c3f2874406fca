"""Newton's steps on lengths: J by differences, steps by dense algebra, patterns that stay."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

import smooth_bodies
import zoo
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.rigidity_matrix import MEAN_DIAGONAL
from isoembed.surface.vertex_system import DIAGONAL_SHIFT, VertexSystem


def dense_jacobian(triangulation, vertices, lengths):
    a, b = triangulation.edges.T
    J = np.zeros((len(a), len(vertices), 3))
    rows = edge_rows(triangulation, vertices, lengths)
    J[np.arange(len(a)), a] = rows
    J[np.arange(len(a)), b] = -rows
    return J.reshape(len(a), -1)


def perturbed(n, seed):
    """A random hull with vertices moved: (triangulation, vertices, lengths that they miss, residuals)."""
    vertices, faces = zoo.random_hull(n, seed)
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    vertices = vertices + 0.02 * np.random.default_rng(seed).normal(size=vertices.shape)
    return triangulation, vertices, lengths, length_residuals(triangulation, vertices, lengths)


def test_residuals_are_the_errors_of_the_lengths_to_first_order():
    triangulation, vertices, lengths, residuals = perturbed(20, 1)
    a, b = triangulation.edges.T
    error = np.linalg.norm(vertices[a] - vertices[b], axis=1) - lengths
    assert residuals == pytest.approx(error + error**2 / (2 * lengths), abs=1e-15)


def test_residuals_do_not_cancel():
    triangulation = Triangulation(zoo.TETRAHEDRON)
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.8, 0], [0.5, 0.3, 0.9]])
    a, b = triangulation.edges.T
    realized = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    lengths = np.nextafter(realized, np.inf)  # one rounding apart: squares would lose it
    residuals = length_residuals(triangulation, vertices, lengths)
    assert residuals == pytest.approx(-(lengths - realized), rel=1e-9, abs=0)


def test_rows_are_the_derivatives_of_the_residuals():
    triangulation, vertices, lengths, _ = perturbed(15, 2)
    J = dense_jacobian(triangulation, vertices, lengths)
    for k in range(vertices.size):
        h = np.zeros(vertices.size)
        h[k] = 1e-6
        h = h.reshape(-1, 3)
        after, before = (length_residuals(triangulation, vertices + s * h, lengths) for s in (1, -1))
        assert (after - before) / 2e-6 == pytest.approx(J[:, k], abs=1e-8)


@given(st.integers(0, 10**6), st.integers(4, 25))
def test_newtons_step_is_the_one_of_least_norm(seed, n):
    triangulation, vertices, lengths, residuals = perturbed(n, seed)
    step = LengthSystem(triangulation).step(vertices, lengths, residuals)
    J = dense_jacobian(triangulation, vertices, lengths)
    assert J @ step.ravel() == pytest.approx(residuals, abs=1e-12)
    expected = np.linalg.lstsq(J, residuals, rcond=None)[0].reshape(-1, 3)
    assert step == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("mu", [1e-6, 1e-2, 10.0])
def test_the_damped_step_is_levenberg_and_marquardts(mu):
    triangulation, vertices, lengths, residuals = perturbed(20, 4)
    step = LengthSystem(triangulation).step(vertices, lengths, residuals, mu)
    J = dense_jacobian(triangulation, vertices, lengths)
    N = J.T @ J + 2 * mu * np.eye(J.shape[1])
    assert step.ravel() == pytest.approx(np.linalg.solve(N, J.T @ residuals), abs=1e-8)


@pytest.mark.parametrize("mu", [0.0, 1e-3])
def test_steps_about_a_vertex_of_many_edges_are_the_same_by_fewer_entries(mu):
    n = 80
    angles = 2 * np.pi * np.arange(n) / n
    vertices = np.array(
        [*zip(np.cos(angles), np.sin(angles), 0 * angles, strict=True), (0, 0, 0.5), (0, 0, -0.4)]
    )
    faces = [face for i in range(n) for face in ((i, (i + 1) % n, n), ((i + 1) % n, i, n + 1))]
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    vertices = vertices + 1e-3 * np.random.default_rng(1).normal(size=vertices.shape)
    residuals = length_residuals(triangulation, vertices, lengths)
    system = LengthSystem(triangulation)
    step = system.step(vertices, lengths, residuals, mu)
    assert "_solver" not in vars(system)  # J J^T, which would be dense
    J = dense_jacobian(triangulation, vertices, lengths)
    tensions = np.linalg.solve(J @ J.T + MEAN_DIAGONAL * mu * np.eye(len(J)), residuals)
    assert step.ravel() == pytest.approx(J.T @ tensions, abs=1e-9)


def bending(triangulation):
    """A penalty that reaches across two edges, singular on constants: the graph Laplacian, squared."""
    L = np.diag(triangulation.degrees) - triangulation.adjacency.toarray()
    return csr_array(L.T @ L / 36)


def penalized_step(system, penalty, vertices, lengths, residuals, mu, damping):
    """Gauss-Newton's step on ``|r|^2 + mu <x, P x>``, its matrix damped by ``damping P``."""
    rows = edge_rows(system.triangulation, vertices, lengths)
    gradient = system.triangulation.incidence @ (rows * residuals[:, None]) + mu * penalty @ vertices
    return system.penalized(rows, mu + damping).solve(gradient.ravel()).reshape(-1, 3)


def dense_penalized_step(triangulation, vertices, lengths, residuals, penalty, mu, damping):
    J = dense_jacobian(triangulation, vertices, lengths)
    P = np.kron(penalty.toarray(), np.eye(3))
    N = J.T @ J + (mu + damping) * P + MEAN_DIAGONAL * DIAGONAL_SHIFT * np.eye(J.shape[1])
    return np.linalg.solve(N, J.T @ residuals + mu * P @ vertices.ravel()).reshape(-1, 3)


@pytest.mark.parametrize("mu", [1e-4, 1e-2, 10.0])
@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_the_penalized_step(mu, damping):
    triangulation, vertices, lengths, residuals = perturbed(30, 5)
    penalty = bending(triangulation)
    step = penalized_step(
        VertexSystem(triangulation, penalty), penalty, vertices, lengths, residuals, mu, damping
    )
    expected = dense_penalized_step(triangulation, vertices, lengths, residuals, penalty, mu, damping)
    # Nothing but `DIAGONAL_SHIFT` keeps the whole from drifting: compare the shapes.
    expected = expected - expected.mean(axis=0)
    assert step - step.mean(axis=0) == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_the_undamped_penalized_step_lowers_the_energy_and_vanishes_at_its_minimum():
    triangulation, vertices, lengths, _ = perturbed(30, 6)
    penalty = bending(triangulation)
    system, x, sizes = VertexSystem(triangulation, penalty), vertices, []
    for _ in range(60):
        step = penalized_step(
            system, penalty, x, lengths, length_residuals(triangulation, x, lengths), 1e-3, 0.0
        )
        sizes.append(np.abs(step - step.mean(axis=0)).max())
        x = x - step
    residuals = length_residuals(triangulation, x, lengths)
    J = dense_jacobian(triangulation, x, lengths)
    slope = J.T @ residuals + 1e-3 * (penalty @ x).ravel()
    assert sizes[-1] < 1e-6 < sizes[0]
    assert np.abs(slope).max() < 1e-6


@given(st.integers(0, 10**6), st.floats(0.5, 2.0))
def test_the_step_on_the_sphere_is_gauss_newtons(seed, radius):
    triangulation, vertices, lengths, residuals = perturbed(20, seed)
    step = VertexSystem(triangulation).spherical_step(
        vertices, edge_rows(triangulation, vertices, lengths), residuals, radius
    )
    heights = (np.sum(vertices**2, axis=1) - radius**2) / (2 * radius)
    outward = np.zeros((len(vertices), len(vertices), 3))
    outward[np.arange(len(vertices)), np.arange(len(vertices))] = vertices / radius
    J = np.vstack([dense_jacobian(triangulation, vertices, lengths), outward.reshape(len(vertices), -1)])
    right = np.concatenate([residuals, heights])
    # Rotations about the center change neither lengths nor radii: compare what the step does to them.
    expected = J @ np.linalg.lstsq(J, right, rcond=1e-9)[0]
    assert J @ step.ravel() == pytest.approx(expected, abs=1e-7)


def test_steps_are_those_of_dense_least_squares():
    triangulation, vertices, lengths, residuals = perturbed(60, 6)
    J = dense_jacobian(triangulation, vertices, lengths)
    newton = LengthSystem(triangulation).step(vertices, lengths, residuals)
    assert newton.ravel() == pytest.approx(np.linalg.lstsq(J, residuals, rcond=None)[0], abs=1e-9)
    penalty = bending(triangulation)
    system = VertexSystem(triangulation, penalty)
    step = penalized_step(system, penalty, vertices, lengths, residuals, 0.1, 0.2)
    expected = dense_penalized_step(triangulation, vertices, lengths, residuals, penalty, 0.1, 0.2)
    assert step - step.mean(axis=0) == pytest.approx(expected - expected.mean(axis=0), abs=1e-6)


def test_the_pattern_does_not_shrink_where_entries_vanish():
    # In the octahedron edges meet at right angles, in the cube they do and coordinates coincide: zeros in
    # J J^T and J^T J at first, but not once the surface has moved.
    for vertices, faces in (zoo.octahedron(), zoo.cube()):
        triangulation = Triangulation(faces)
        a, b = triangulation.edges.T
        lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
        newton, damped = LengthSystem(triangulation), VertexSystem(triangulation, bending(triangulation))
        noise = np.random.default_rng(0).normal(size=vertices.shape)
        for x in (vertices + 1e-3 * np.eye(len(vertices))[:, :3], vertices + 0.1 * noise):
            residuals = length_residuals(triangulation, x, lengths)
            J = dense_jacobian(triangulation, x, lengths)
            expected = np.linalg.lstsq(J, residuals, rcond=None)[0]
            assert newton.step(x, lengths, residuals).ravel() == pytest.approx(expected, abs=1e-10)
            penalty = bending(triangulation)
            step = penalized_step(damped, penalty, x, lengths, residuals, 1e-2, 0.0)
            expected = dense_penalized_step(triangulation, x, lengths, residuals, penalty, 1e-2, 0.0)
            assert step - step.mean(axis=0) == pytest.approx(expected - expected.mean(axis=0), abs=1e-6)


def test_penalties_beyond_the_edges_are_in_the_pattern():
    triangulation, vertices, lengths, residuals = perturbed(20, 8)
    n = len(vertices)
    spring = np.zeros((n, n))
    i, j = 0, int(np.flatnonzero(triangulation.adjacency.toarray()[0] == 0)[-1])
    assert j != i
    spring[[i, j], [i, j]], spring[[i, j], [j, i]] = 1.0, -1.0
    penalty = csr_array(spring)
    step = penalized_step(
        VertexSystem(triangulation, penalty), penalty, vertices, lengths, residuals, 0.5, 0.0
    )
    expected = dense_penalized_step(triangulation, vertices, lengths, residuals, penalty, 0.5, 0.0)
    J = dense_jacobian(triangulation, vertices, lengths)
    assert J @ step.ravel() == pytest.approx(J @ expected.ravel(), abs=1e-6)


def test_a_surface_that_flexes_has_no_newton_step_but_a_damped_one():
    vertices, faces = zoo.icosphere(1)
    triangulation = Triangulation(faces)
    flat = vertices * [1, 1, 0]
    lengths = np.ones(triangulation.n_edges)
    residuals = length_residuals(triangulation, flat, lengths)
    system = LengthSystem(triangulation)
    with pytest.raises(SingularMatrix):
        system.step(flat, lengths, residuals)
    assert np.isfinite(system.step(flat, lengths, residuals, 1e-3)).all()


def test_steps_commute_with_rotations():
    triangulation, vertices, lengths, residuals = perturbed(40, 10)
    Q = zoo.rotation(1)
    newton = LengthSystem(triangulation)
    step = newton.step(vertices, lengths, residuals, 1e-2)
    assert newton.step(vertices @ Q, lengths, residuals, 1e-2) == pytest.approx(step @ Q, abs=1e-9)
    penalty = bending(triangulation)
    system = VertexSystem(triangulation, penalty)
    step = penalized_step(system, penalty, vertices, lengths, residuals, 1e-2, 0.0)
    turned = penalized_step(system, penalty, vertices @ Q, lengths, residuals, 1e-2, 0.0)
    assert turned - turned.mean(axis=0) == pytest.approx((step - step.mean(axis=0)) @ Q, abs=1e-6)


def test_newtons_step_is_refined_where_the_surface_nearly_flexes():
    vertices, faces = zoo.icosphere(2)
    triangulation, flat = Triangulation(faces), vertices * [1, 1, 1e-3]
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(flat[a] - flat[b], axis=1)
    residuals = 1e-3 * np.random.default_rng(0).normal(size=len(lengths))
    J = dense_jacobian(triangulation, flat, lengths)
    once = np.linalg.solve(J @ J.T, residuals)
    unrefined = np.abs(J @ (J.T @ once) - residuals).max()
    step = LengthSystem(triangulation).step(flat, lengths, residuals)
    assert np.abs(J @ step.ravel() - residuals).max() < unrefined / 10


def test_smooth_bodies_are_rigid():
    vertices, faces = smooth_bodies.ellipsoid()
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    J = dense_jacobian(triangulation, vertices, lengths)
    assert np.linalg.matrix_rank(J, tol=1e-8) == triangulation.n_edges  # 3 V - 6: all but the motions
