"""The cited methods where they must work, where they must fail, and the table that compares them."""

import re

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.gallery import Ellipsoid, KerrHorizon
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.metric.curvature import area
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import gauss_newton
from isoembed.smooth.two_metric import PulledBack
from isoembed.studies.baselines.embedding_flow import embedding_flow
from isoembed.studies.baselines.spherical_harmonics import fit_harmonics, projected, sphere
from isoembed.studies.baselines.study import study
from isoembed.studies.baselines.subjects import Problem, Subject, paper_subjects, saddled, star_shaped
from isoembed.studies.baselines.table import COLUMNS, compare, run_table
from isoembed.studies.baselines.uniformization import uniformized
from isoembed.studies.baselines.wire_frame import sphere_layout, wire_frame
from smooth_bodies import misfit

ROUND = PulledBack(lambda u: np.broadcast_to(2.0 * np.eye(3), (len(u), 3, 3)))
KERR = Subject("Kerr", KerrNewmanHorizon(mass=1.0, spin=0.5), KerrHorizon(spin=0.5).point)
NEARLY_ROUND = star_shaped("nearly round", Ellipsoid((1.2, 1.1, 1.0)))


@pytest.mark.parametrize("subject", [*paper_subjects(), saddled()], ids=lambda s: s.name)
def test_subjects_have_the_metrics_of_their_surfaces(subject):
    u, h = fibonacci_directions(40), 1e-4
    q = subject.metric.tensor(u)
    t = np.cross(u, [0.3, -0.5, 0.8])
    t /= np.linalg.norm(t, axis=1)[:, None]
    there, back = (subject.point(np.cos(h) * u + np.sin(s) * t) for s in (h, -h))
    squares = ((there - back) ** 2).sum(axis=1) / (2 * h) ** 2
    np.testing.assert_allclose(squares, np.einsum("ni,nij,nj->n", t, q, t), rtol=1e-5)


def test_a_wire_frame_near_the_true_surface_returns_to_it():
    problem = Problem.of(paper_subjects()[1], 100)
    shaken = problem.vertices + 0.01 * np.random.default_rng(1).standard_normal(problem.vertices.shape)
    found = wire_frame(problem.metric, shaken)
    assert found.converged
    assert misfit(found.vertices, problem.vertices) < 1e-9


def test_a_wire_frame_from_a_sphere_has_the_lengths_and_is_crumpled():
    problem = Problem.of(paper_subjects()[1], 200)
    found = wire_frame(problem.metric, sphere_layout(problem.metric))
    assert found.converged  # measured on the vertices
    assert misfit(found.vertices, problem.vertices) > 0.02
    assert found.concave_edges.sum() > 120  # of 594; the true mesh has 100


def test_layouts_are_spheres_of_the_same_area_and_scale():
    problem = Problem.of(NEARLY_ROUND, 100)
    radii = np.linalg.norm(sphere_layout(problem.metric), axis=1)
    np.testing.assert_allclose(radii, radii[0], rtol=1e-12)
    assert 4 * np.pi * radii[0] ** 2 == pytest.approx(area(problem.metric), rel=1e-12)
    rough = sphere_layout(problem.metric, noise=0.3, seed=3) - sphere_layout(problem.metric)
    assert rough.std() == pytest.approx(0.3 * problem.metric.mean_length, rel=0.1)


def test_starts_of_another_shape_are_refused():
    problem = Problem.of(NEARLY_ROUND, 30)
    with pytest.raises(InvalidParameter, match=re.escape("has the shape (29, 3), not (30, 3)")):
        wire_frame(problem.metric, problem.vertices[:-1])
    with pytest.raises(InvalidParameter, match=re.escape("has the shape (4, 3), not (9, 3)")):
        fit_harmonics(ROUND, Harmonics(2, 2), np.zeros((4, 3)))
    with pytest.raises(InvalidParameter, match="order 0 hold no sphere"):
        sphere(ROUND, Harmonics(2, 0))


def test_the_sphere_is_a_start_of_the_same_area_with_bumps_of_the_given_size():
    u = fibonacci_directions(2000)
    harmonics = Harmonics(6, 6)
    smooth, bumpy = (sphere(ROUND, harmonics, size, seed=2) for size in (0.0, 0.3))
    np.testing.assert_allclose(harmonics.values(u) @ smooth, 2.0 * u, atol=1e-13)
    away = harmonics.values(u) @ (bumpy - smooth)
    assert np.sqrt((away**2).sum(axis=1).mean()) == pytest.approx(0.3 * 2.0, rel=1e-2)


def test_harmonics_find_what_they_contain():
    # In its own coordinates the ellipsoid is linear.
    metric = PulledBack(lambda u: np.broadcast_to(np.diag([3.0, 2.0, 1.0]), (len(u), 3, 3)))
    harmonics = Harmonics(3, 3)
    found = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    u = fibonacci_directions(50)
    assert found.settled
    assert misfit(found.points(u), u * [3.0, 2.0, 1.0]) < 1e-6


def test_harmonics_end_where_gauss_newton_steps_end():
    # With few harmonics strains are left, and a wrong slope would show in their least sum of squares.
    metric, harmonics = paper_subjects()[1].metric, Harmonics(4, 4)
    found = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    again = gauss_newton(metric, harmonics, found.coefficients)
    u = fibonacci_directions(50)
    assert found.strain > 0.1
    assert misfit(found.points(u), harmonics.values(u) @ again) < 1e-5


def test_harmonics_converge_spectrally_from_the_sphere():
    strains = []
    for degree in (2, 4, 6, 8):
        harmonics = Harmonics(degree, degree)
        start = sphere(NEARLY_ROUND.metric, harmonics)
        strains.append(fit_harmonics(NEARLY_ROUND.metric, harmonics, start).strain)
    factors = np.array(strains[1:]) / strains[:-1]
    assert (factors < 0.1).all()  # two degrees more, one digit more


def test_harmonics_get_stuck_from_some_bumpy_spheres_and_not_from_others():
    metric, harmonics = paper_subjects()[1].metric, Harmonics(8, 8)
    round_one = fit_harmonics(metric, harmonics, sphere(metric, harmonics))
    found = [fit_harmonics(metric, harmonics, sphere(metric, harmonics, 0.5, seed)) for seed in range(4)]
    worse = [one.settled and one.strain > 2.0 * round_one.strain for one in found]
    assert 0 < sum(worse) < 4


def test_uniformization_undoes_a_conformal_change():
    # A round sphere, conformally changed by a function that no Moebius map makes.
    def w(u):
        return 0.2 * u[:, 0] * u[:, 1] + 0.1 * u[:, 2] ** 2

    metric = PulledBack(lambda u: np.exp(w(u))[:, None, None] * np.eye(3))
    harmonics = Harmonics(12, 12)
    found = uniformized(metric, harmonics)
    assert found.settled

    class Uniform:
        def tensor(self, u):
            factors = np.exp(2.0 * harmonics.values(u) @ found.factors)
            return factors[:, None, None] * metric.tensor(u)

    u = fibonacci_directions(60)
    K = gaussian_curvature(Uniform(), u)
    np.testing.assert_allclose(K, K.mean(), rtol=1e-5)
    X = harmonics.values(u) @ found.coefficients
    np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1 / np.sqrt(K.mean()), rtol=1e-5)
    assert np.linalg.det(np.linalg.lstsq(u, X, rcond=None)[0]) > 0.0  # not turned inside out


def test_the_flow_leaves_a_sphere_alone():
    start = uniformized(ROUND, Harmonics(4, 4))
    found = embedding_flow(ROUND, start, steps=1, order=1)
    u = fibonacci_directions(50)
    assert found.strain < 1e-7  # the curvature has eight digits
    assert misfit(found.points(u), 2.0 * u) < 1e-7


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_flow_has_the_order_of_its_steps(order):
    start = uniformized(KERR.metric, Harmonics(16, 1))
    u = fibonacci_directions(100)
    errors = [
        misfit(embedding_flow(KERR.metric, start, steps, order).points(u), KERR.point(u)) for steps in (4, 8)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def test_flows_that_cannot_be_are_refused():
    start = uniformized(ROUND, Harmonics(2, 2))
    with pytest.raises(InvalidParameter, match="the order is 3, not one of 1, 2 and 4"):
        embedding_flow(ROUND, start, steps=4, order=3)
    with pytest.raises(InvalidParameter, match="the number of steps is 0"):
        embedding_flow(ROUND, start, steps=0)


def test_projection_is_exact_where_it_can_be():
    u = fibonacci_directions(40)
    harmonics = Harmonics(2, 2)
    C = np.random.default_rng(0).standard_normal((harmonics.size, 3))
    np.testing.assert_allclose(projected(harmonics.values(u) @ C, u, harmonics), C, atol=1e-12)


def test_the_table_measures_all_methods_on_the_same_triangles():
    runs = compare([KERR], vertices=100, degree=6, steps=4)
    assert len({run.method for run in runs}) == len(runs) == 9
    i, j = runs[0].problem.metric.edges.T
    lengths = runs[0].problem.metric.lengths
    for run in runs:
        x = run.surface.vertices
        errors = np.abs(np.linalg.norm(x[i] - x[j], axis=1) - lengths)
        assert run.surface.residual == pytest.approx(errors.max() / lengths.mean(), rel=1e-6, abs=1e-14)
    assert {len(row) for row in run_table("all", runs).rows} == {len(COLUMNS)}
    by_method = {run.method: run for run in runs}
    assert by_method["(true surface)"].numbers["distance"] < 1e-14
    for method in ("isoembed, aim", "isoembed, paper"):
        assert by_method[method].note == "the true surface"
    for method in ("harmonics, from a sphere", "embedding flow", "isoembed, aim and harmonics"):
        assert by_method[method].numbers["distance"] < 1e-3


def test_too_few_vertices_for_the_harmonics_are_refused():
    with pytest.raises(
        InvalidParameter, match="60 vertices are too few for the 49 harmonics of degree 6: 98"
    ):
        compare([KERR], vertices=60, degree=6, steps=1)


def test_the_section_has_a_row_for_every_run_and_its_figures(monkeypatch):
    monkeypatch.setattr("isoembed.studies.baselines.study.SIZES", (0.3,))
    monkeypatch.setattr("isoembed.studies.baselines.study.HALVINGS", 3)
    section = study(vertices=60, degree=4, steps=2, seeds=1)
    runs, starts, bent = section.tables
    assert len(runs.rows) == 36
    assert len(starts.rows) == 4
    assert len(bent.rows) == 2
    assert {len(row) for row in runs.rows} == {len(runs.header)}
    assert [one.name for one in section.figures] == ["baselines-convergence", "baselines-surfaces"]
    for one in section.figures:
        one.figure.canvas.draw()
