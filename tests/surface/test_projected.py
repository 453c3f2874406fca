"""Rigidity in hyperbolic and spherical space: rows and steps against differences; curvature to zero."""

import numpy as np
import pytest

import zoo
from isoembed import Euclidean, Hyperbolic, Space, Spherical
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.vertex_system import VertexSystem

SPACES = [Hyperbolic(1.0), Hyperbolic(4.0), Spherical(0.5), Hyperbolic(1e-14), Euclidean()]


def body(space, seed=0, n=20):
    """Points of a space, not centered: triangulation, points, lengths."""
    x, faces = zoo.random_hull(n, seed)
    x = space.translated(x, np.array([0.2, 0.1, -0.1]))
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    return triangulation, x, space.distances(x[a], x[b])


def dense(triangulation, x, lengths, space):
    """J by its rows, acting on motions of the points x."""
    rows, (a, b) = edge_rows(triangulation, x, lengths, space), triangulation.edges.T
    J = np.zeros((len(a), len(x), 3))
    J[np.arange(len(a)), a], J[np.arange(len(a)), b] = rows, -rows
    return (J / space.heights(x)[:, None]).reshape(len(a), -1)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_rows_are_the_derivatives_of_the_lengths(space):
    t, x, lengths = body(space)
    a, b = t.edges.T
    J = dense(t, x, lengths, space)
    rng = np.random.default_rng(1)
    for _ in range(5):
        d = rng.standard_normal(x.shape)
        after, before = (space.distances(*((x + s * 1e-6 * d)[[a, b]])) for s in (1, -1))
        assert (after - before) / 2e-6 == pytest.approx(J @ d.ravel(), abs=1e-8)
        after, before = (length_residuals(t, x + s * 1e-6 * d, lengths, space) for s in (1, -1))
        assert (after - before) / 2e-6 == pytest.approx(J @ d.ravel(), abs=1e-8)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_steps_converge_quadratically(space):
    t, exact, lengths = body(space)
    x = exact + 0.003 * np.random.default_rng(2).standard_normal(exact.shape)
    system, worst = LengthSystem(t, space=space), []
    for _ in range(5):
        r = length_residuals(t, x, lengths, space)
        worst.append(np.abs(r).max())
        x = x - system.step(x, lengths, r)
    assert worst[-1] < 1e-14
    assert worst[2] < 100 * worst[1] ** 2
    everywhere = space.distances(x[:, None], x)
    assert everywhere == pytest.approx(space.distances(exact[:, None], exact), abs=1e-10)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_damped_steps_solve_their_equations(space):
    t, x, lengths = body(space)
    r = np.random.default_rng(3).standard_normal(len(lengths))
    d = LengthSystem(t, space=space).step(x, lengths, r, mu=1e-2)
    rows, w = edge_rows(t, x, lengths, space), space.heights(x)
    J = dense(t, x, lengths, space).reshape(-1, len(x), 3) * w[:, None]
    J = J.reshape(len(r), -1)
    mean = np.mean(np.sum(rows**2, axis=1)) if not space.is_euclidean else 1.0
    z = np.linalg.solve(J.T @ J + 0.02 * mean * np.eye(J.shape[1]), J.T @ r)
    assert (d / w[:, None]).ravel() == pytest.approx(z, abs=1e-8 * np.abs(z).max())


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_the_smallest_singular_values_are_those_of_velocities(space):
    t, x, lengths = body(space)
    surface, a, b = Projected.of(space, x), *t.edges.T
    J = np.zeros((len(a), len(x), 3))  # unit vectors along the edges, carried to the origin
    for i, j in ((a, b), (b, a)):
        v = space.logarithm(x[i], x[j])
        J[np.arange(len(a)), i] = -v / np.linalg.norm(v, axis=1)[:, None]
    J = J.reshape(len(a), -1)
    expected = np.linalg.svd(J, compute_uv=False)[::-1][:2]
    sigma, motions, changes = LengthSystem(t, space=space).smallest_singular_values(x, lengths, 2)
    assert sigma == pytest.approx(expected, rel=1e-3)
    for s, motion, change in zip(sigma, motions, changes, strict=True):
        assert np.linalg.norm(change) == pytest.approx(1)
        v = surface.velocities(motion / space.heights(x)[:, None])
        assert np.linalg.norm(v) == pytest.approx(1)
        assert J @ v.ravel() == pytest.approx(s * change, abs=0.05 * s)
    moved = space.centered(x)
    again = LengthSystem(t, space=space).smallest_singular_values(moved, lengths, 1)[0]
    assert again == pytest.approx(sigma[:1], rel=2e-3)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_isometries_change_no_length(space):
    t, x, lengths = body(space)
    surface = Projected.of(space, x)
    fields = surface.isometries().T.reshape(6, -1, 3)
    z = np.array([surface.from_velocities(v) for v in fields])
    rows, (a, b) = edge_rows(t, x, lengths, space), t.edges.T
    assert np.abs(np.einsum("ei,kei->ke", rows, z[:, a] - z[:, b])).max() < 1e-14
    assert np.abs(surface.velocities(z[0]) - fields[0]).max() < 1e-15


def test_curvature_to_zero_is_linear():
    t, x, lengths = body(Euclidean())
    steps = [
        LengthSystem(t, space=space).step(x, lengths, length_residuals(t, x, lengths, space) + 0.01)
        for space in (Euclidean(), Space(-1e-4), Space(-1e-5))
    ]
    off = [np.abs(step - steps[0]).max() for step in steps[1:]]
    assert off[0] / off[1] == pytest.approx(10, rel=0.02)


def test_penalized_steps_take_the_rows():
    space = Hyperbolic(1.0)
    t, exact, lengths = body(space)
    x = exact + 1e-3 * np.random.default_rng(4).standard_normal(exact.shape)
    system = VertexSystem(t)
    for _ in range(4):
        r, rows = length_residuals(t, x, lengths, space), edge_rows(t, x, lengths, space)
        z = system.penalized(rows, 0.0).solve((t.incidence @ (rows * r[:, None])).ravel()).reshape(-1, 3)
        x = x - Projected.of(space, x).motion(z)
    assert np.abs(length_residuals(t, x, lengths, space)).max() < 1e-13
