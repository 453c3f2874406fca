"""Annealing: quadratic convergence, tolerances, the best vertices, impossible lengths, damped steps."""

from itertools import pairwise

import numpy as np
import pytest

import smooth_bodies
import sprinkled
import zoo
from isoembed.aim.anneal import anneal, anneal_damped, anneal_on_sphere
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.vertex_system import VertexSystem


def problem(amount, mesh=None):
    """An ellipsoid, its lengths (of mean 1) and vertices off by so much of the mean length."""
    vertices, faces = mesh or smooth_bodies.ellipsoid()
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    vertices = vertices / np.linalg.norm(vertices[a] - vertices[b], axis=1).mean()
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    noise = np.random.default_rng(0).normal(size=vertices.shape)
    return triangulation, lengths, vertices, vertices + amount * noise


def watched():
    """A recorder and the residuals that are shown on it."""
    shown = []
    return StageRecorder("test", Log(lambda progress: shown.append(progress.residual))), shown


def largest(triangulation, vertices, lengths):
    return np.abs(length_residuals(triangulation, vertices, lengths)).max()


def test_newtons_method_is_quadratic():
    triangulation, lengths, vertices, start = problem(1e-3)
    recorder, shown = watched()
    annealed = anneal(
        LengthSystem(triangulation, work=recorder.work), start, lengths, recorder, residual_tolerance=1e-12
    )
    assert annealed.converged
    assert annealed.residual <= 1e-12
    assert annealed.residual == largest(triangulation, annealed.vertices, lengths)
    assert smooth_bodies.misfit(annealed.vertices, vertices) < 1e-9
    rates = [np.log(after) / np.log(before) for before, after in pairwise(shown) if after > 1e-12]
    assert len(shown) <= 6
    assert max(rates) > 1.7
    assert recorder.iterations == recorder.factorizations == len(shown) - 1


def test_the_answer_is_checked_before_any_step():
    triangulation, lengths, vertices, _ = problem(0)
    recorder = smooth_bodies.recorder()
    annealed = anneal(
        LengthSystem(triangulation, work=recorder.work), vertices, lengths, recorder, residual_tolerance=1e-12
    )
    assert annealed.converged
    assert annealed.vertices is vertices
    assert recorder.factorizations == 0


def test_a_step_below_its_tolerance_ends_it():
    triangulation, lengths, _, start = problem(1e-3)
    tight, loose = smooth_bodies.recorder(), smooth_bodies.recorder()
    system = LengthSystem(triangulation)
    first = anneal(system, start, lengths, loose, residual_tolerance=1e-30, step_tolerance=1.0)
    assert first.converged
    assert loose.iterations == 1
    last = anneal(system, start, lengths, tight, residual_tolerance=1e-30, step_tolerance=1e-8)
    assert last.converged
    assert last.residual < 1e-12
    assert 3 <= tight.iterations <= 6


def test_the_rounding_floor_ends_it():
    triangulation, lengths, _, start = problem(1e-3)
    recorder, shown = watched()
    annealed = anneal(
        LengthSystem(triangulation, work=recorder.work), start, lengths, recorder, residual_tolerance=0.0
    )
    assert not annealed.converged
    assert annealed.residual == min(shown) < 1e-14
    assert recorder.iterations < 15


def test_iterations_that_run_out():
    triangulation, lengths, _, start = problem(1e-2)
    recorder, shown = watched()
    annealed = anneal(
        LengthSystem(triangulation), start, lengths, recorder, residual_tolerance=1e-12, max_iterations=1
    )
    assert not annealed.converged
    assert recorder.iterations == 1
    assert annealed.residual == min(shown)


def flat_top(lift):
    """A square pyramid, closed below by a flat one."""
    base = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    vertices = np.vstack([base, [[0, 0, 2.0], [0, 0, -lift]]])
    faces = np.array([[k, (k + 1) % 4, 4] for k in range(4)] + [[(k + 1) % 4, k, 5] for k in range(4)])
    return vertices, faces


def test_impossible_lengths_do_not_converge_and_the_best_is_returned():
    # With spokes of 0.8 to the center of a square of diagonal 2, whose rim is held by its own lengths, there
    # is no octahedron: the equator has to fold, which the other apex's legs of sqrt 5 do not permit.
    vertices, faces = flat_top(0.1)
    triangulation = Triangulation(faces)
    a, b = triangulation.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    lengths[(triangulation.edges == 5).any(axis=1)] = 0.8
    system = LengthSystem(triangulation)
    recorder, shown = watched()
    annealed = anneal(system, vertices, lengths, recorder, residual_tolerance=1e-9)
    assert not annealed.converged
    assert annealed.residual == min(shown)
    assert annealed.residual == largest(triangulation, annealed.vertices, lengths) > 1e-3
    damped = anneal_damped(system, vertices, lengths, recorder, residual_tolerance=1e-9, max_iterations=99)
    assert not damped.converged
    assert damped.residual == largest(triangulation, damped.vertices, lengths) > 1e-3


def test_a_singular_start_is_returned_as_it_is():
    vertices, faces = zoo.icosphere(1)
    triangulation = Triangulation(faces)
    flat = vertices * [1, 1, 0]
    lengths = np.full(triangulation.n_edges, 1.0)
    recorder = smooth_bodies.recorder()
    annealed = anneal(
        LengthSystem(triangulation, work=recorder.work), flat, lengths, recorder, residual_tolerance=1e-9
    )
    assert not annealed.converged
    assert annealed.vertices is flat
    assert (recorder.iterations, recorder.factorizations) == (0, 1)


def test_divergence_stops():
    triangulation, lengths, _, start = problem(50.0)
    recorder = smooth_bodies.recorder()
    annealed = anneal(
        LengthSystem(triangulation, work=recorder.work), start, lengths, recorder, residual_tolerance=1e-9
    )
    assert not annealed.converged
    assert recorder.iterations == 0


@pytest.mark.parametrize("amount", [0.02, 0.3])
def test_damped_steps_never_go_uphill_and_arrive(amount):
    triangulation, lengths, vertices, start = problem(amount)
    recorder, shown = watched()
    energies = []

    class Recorded:
        """Notes the energy of every surface from which a step is taken."""

        def __init__(self, system):
            self.system, self.triangulation, self.space = system, triangulation, system.space

        def step(self, x, lengths, residuals, mu):
            energies.append(float(residuals @ residuals))
            return self.system.step(x, lengths, residuals, mu)

    system = Recorded(LengthSystem(triangulation))
    annealed = anneal_damped(system, start, lengths, recorder, residual_tolerance=1e-6, max_iterations=200)
    assert (np.diff(energies) <= 0).all()
    assert len(energies) == recorder.iterations
    assert annealed.residual == shown[-1] == largest(triangulation, annealed.vertices, lengths)
    if amount < 0.1:
        assert annealed.converged
        assert smooth_bodies.misfit(annealed.vertices, vertices) < 0.03  # as soft as smooth bodies are


def test_damped_steps_outlast_singular_matrices():
    triangulation, lengths, _, start = problem(0.01)

    class Singular:
        """Factors only what is damped heavily."""

        def __init__(self, work):
            self.triangulation, self.tried = triangulation, []
            self.system = LengthSystem(triangulation, work=work)
            self.space = self.system.space

        def step(self, x, lengths, residuals, mu):
            self.tried.append(mu)
            if len(self.tried) < 4:
                raise SingularMatrix("test")
            return self.system.step(x, lengths, residuals, mu)

    recorder = smooth_bodies.recorder()
    system = Singular(recorder.work)
    before = largest(triangulation, start, lengths)
    annealed = anneal_damped(system, start, lengths, recorder, residual_tolerance=1e-12, max_iterations=6)
    assert system.tried[:4] == pytest.approx([0.01, 0.05, 0.25, 1.25])
    assert len(system.tried) == 6
    assert recorder.iterations == recorder.factorizations == 3
    assert annealed.residual < before


def test_annealing_on_the_sphere_meets_lengths_and_radius():
    vertices, faces = zoo.icosphere(2)
    triangulation, lengths, exact, start = problem(0.05, (vertices, faces))
    radius = np.linalg.norm(exact[0])
    recorder = smooth_bodies.recorder()
    system = VertexSystem(triangulation, work=recorder.work)
    fitted = anneal_on_sphere(system, start, lengths, radius, recorder, max_iterations=20)
    assert (
        smooth_bodies.misfit(fitted, exact) < 1e-4
    )  # it stops at steps of 1e-3, and converges quadratically
    assert 1 <= recorder.iterations == recorder.factorizations <= 6
    assert (
        anneal_on_sphere(system, start, lengths, radius, smooth_bodies.recorder(), max_iterations=0) is start
    )


def test_annealing_on_the_sphere_balances_what_cannot_be_met():
    vertices, faces = zoo.icosphere(2)
    triangulation, lengths, exact, _ = problem(0.0, (vertices, faces))
    radius = 1.02 * np.linalg.norm(exact[0])
    system = VertexSystem(triangulation)
    fitted = anneal_on_sphere(system, exact, lengths, radius, smooth_bodies.recorder(), max_iterations=30)
    reached = np.linalg.norm(fitted, axis=1)
    assert np.linalg.norm(exact[0]) < reached.min() < reached.max() < radius

    def cost(x):
        r = length_residuals(triangulation, x, lengths)
        heights = (np.sum(x**2, axis=1) - radius**2) / (2 * radius)
        return r @ r + heights @ heights

    assert cost(fitted) < cost(exact)
    assert cost(fitted) < cost(1.02 * exact)
    assert all(cost(s * fitted) > cost(fitted) for s in (0.999, 1.001))


@pytest.mark.parametrize("k, amount", [(3, 1e-5), (6, 1e-4)])
def test_flat_faces_are_reached_where_the_jacobian_is_singular(k, amount):
    """Newton steps end with residuals of 1e-11 to 1e-8, where J J^T cannot be factored."""
    triangulation, lengths, vertices, start = problem(amount, sprinkled.box(k)[:2])
    recorder = smooth_bodies.recorder()
    system = LengthSystem(triangulation, work=recorder.work)
    annealed = anneal(system, start, lengths, recorder, max_damped=25)
    assert annealed.residual < 1e-12
    assert smooth_bodies.misfit(annealed.vertices, vertices) < 1e-5
