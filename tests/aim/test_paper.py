"""AIM as printed: its test bodies, stages one by one, crumpled variants, refusals and diagnoses."""

import numpy as np
import pytest

import isoembed
import smooth_bodies
from isoembed.aim.adiabatic_pullback import pull_back
from isoembed.aim.anneal import anneal_on_sphere
from isoembed.aim.embedding_tree import embedding_tree
from isoembed.aim.paper import Paper
from isoembed.aim.paths import path_factors, path_times
from isoembed.errors import NotEmbedded
from isoembed.metric.conformal import rescaled
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem

BODIES = {"ellipsoid": smooth_bodies.ellipsoid, "drum": smooth_bodies.drum}


def embedded(mesh, tolerance=1e-10, **parameters):
    metric = PolyhedralMetric.from_mesh(*mesh)
    return isoembed.embed(metric, method=Paper(**parameters), tolerance=tolerance)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_the_papers_bodies(body, tolerance):
    vertices, faces = BODIES[body]()
    surface = embedded((vertices, faces), tolerance)
    assert surface.residuals.mean() < tolerance
    assert surface.residuals.std() < tolerance
    assert not surface.surface.inverted_vertices.any()
    assert not surface.surface.partially_inverted_vertices.any()
    assert smooth_bodies.misfit(surface.vertices, vertices) < 3e4 * tolerance
    assert surface.method == "paper"


@pytest.mark.parametrize(
    "parameters",
    [
        {"flow": "BDF", "epsilon": 1e-3},
        pytest.param({"flow": "RK45", "epsilon": 1e-2}, marks=pytest.mark.slow),
        {"flow": "BDF", "epsilon": 1e-3, "path": "flow"},
        {"path": "exponential"},
        {"path": "exponential", "alpha": 1.0, "Tsteps": 5},
        {"root": 395},
        {"Tsteps": 3},
        {"sphere": False},
    ],
    ids=str,
)
def test_every_parameter_leads_to_the_same_surface(parameters):
    vertices, faces = smooth_bodies.ellipsoid()
    surface = embedded((vertices, faces), **parameters)
    assert smooth_bodies.misfit(surface.vertices, vertices) < 1e-7


def test_every_stage_by_itself_returns_what_the_next_one_takes():
    vertices, faces = smooth_bodies.ellipsoid()
    method, recorder = Paper(Tsteps=6), smooth_bodies.recorder()
    given = PolyhedralMetric.from_mesh(vertices, faces)
    metric = given.normalized
    system = LengthSystem(metric.triangulation)

    uniform = method.uniformize(metric, recorder)
    assert uniform.converged
    placed = embedding_tree(uniform.metric, uniform.radius, 0, recorder).vertices
    # Nearly right: what is left are the inconsistencies of the determined edges.
    a, b = metric.edges.T
    missed = np.abs(np.linalg.norm(placed[a] - placed[b], axis=1) - uniform.metric.lengths)
    assert np.median(missed) < 0.05
    assert missed.max() > 1e-3
    annealed = method.anneal(system, placed, uniform.metric.lengths, 1e-10, recorder)
    assert annealed.converged
    convex = method.make_convex(system, annealed, uniform.metric.lengths, 1e-10, recorder)
    assert convex.converged

    def relax(guess, t):
        lengths = rescaled(metric, path_factors("linear", uniform, t)).lengths
        return method.make_convex(
            system, method.anneal(system, guess, lengths, 1e-10, recorder), lengths, 1e-10, recorder
        )

    *_, (t, last) = pull_back(convex.vertices, path_times("linear", 6, 1.0), relax)
    assert t == 0
    assert last.converged
    assert smooth_bodies.misfit(last.vertices * given.unit, vertices) < 1e-7


@pytest.mark.parametrize("body", BODIES)
def test_at_once_and_without_the_convexity_routine_the_surface_is_crumpled(body):
    crumpled = embedded(BODIES[body](), 1e-6, Tsteps=1, convexity="none", sphere=False)
    assert crumpled.residual <= 1e-6
    assert crumpled.surface.inverted_vertices.any() or crumpled.surface.partially_inverted_vertices.any()
    assert "the surface may be crumpled" in crumpled.message
    smooth_one = embedded(BODIES[body](), 1e-6)
    assert smooth_one.integrated_mean_curvature > crumpled.integrated_mean_curvature
    assert smooth_one.volume > crumpled.volume


def test_the_convexity_routine_mends_what_its_printed_sign_does_not():
    vertices, faces = smooth_bodies.ellipsoid()
    counts = {
        convexity: int(
            embedded((vertices, faces), Tsteps=1, convexity=convexity).surface.inverted_vertices.sum()
        )
        for convexity in ("none", "printed", "corrected")
    }
    assert counts["none"] > 0
    assert counts["printed"] > 0
    assert counts["corrected"] == 0


@pytest.mark.parametrize("sphere", [True, False])
def test_anneal_a_begins_on_the_sphere_if_asked_to(monkeypatch, sphere):
    radii = []

    def spied(system, vertices, lengths, radius, *arguments, **options):
        radii.append((np.linalg.norm(vertices, axis=1), radius))
        return anneal_on_sphere(system, vertices, lengths, radius, *arguments, **options)

    monkeypatch.setattr("isoembed.aim.paper.anneal_on_sphere", spied)
    embedded(smooth_bodies.ellipsoid(100), sphere=sphere)
    assert len(radii) == sphere
    assert all(norms == pytest.approx(radius, rel=1e-12) for norms, radius in radii)


def test_the_stages_of_section_2():
    surface = embedded(smooth_bodies.ellipsoid())
    names = ["uniformize", "embedding tree", "anneal A", "convexity and anneal B", "pull back"]
    assert [stage.name for stage in surface.stages] == names
    by_name = {stage.name: stage for stage in surface.stages}
    assert by_name["uniformize"].iterations > 0
    assert by_name["embedding tree"].iterations > 5
    assert by_name["embedding tree"].factorizations == 0
    assert by_name["pull back"].factorizations >= 10


def test_progress_follows_the_pull_back():
    seen = []
    metric = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid())
    isoembed.embed(metric, method=Paper(Tsteps=4), progress=seen.append)
    reached = [p for p in seen if p.t is not None]
    times = [p.t for p in reached]
    assert sorted(set(times), reverse=True) == pytest.approx([1.0, 0.75, 0.5, 0.25, 0.0])
    assert times == sorted(times, reverse=True)
    assert all(p.stage == "pull back" for p in reached if p.t < 1)
    assert all(p.inverted == 0 for p in reached if p.stage == "pull back")
    assert reached[-1].residual < 1e-10


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"flow": "euler"}, "flow is 'euler', not one of newton, BDF"),
        ({"path": "flow"}, "path is 'flow', but flow is 'newton', which has no history"),
        ({"path": "exponential", "alpha": 1000.0}, "alpha is 1000.0: the 10 steps of the exponential path"),
        ({"Tsteps": 2.5}, "Tsteps is 2.5, not a whole number"),
        ({"path": "straight"}, "path is 'straight', not one of linear, exponential, flow"),
        ({"convexity": "both"}, "convexity is 'both', not one of corrected, printed, none"),
        ({"epsilon": 0.0}, "epsilon is 0.0, not positive"),
        ({"epsilon": float("nan")}, "epsilon is nan, not positive"),
        ({"t_f": -1.0}, "t_f is -1.0, not positive"),
        ({"alpha": 0}, "alpha is 0, not positive"),
        ({"Tsteps": 0}, "Tsteps is 0, not positive"),
        ({"max_iterations": 0}, "max_iterations is 0, not positive"),
        ({"root": -1}, "root is -1, which is negative"),
        ({"step_tolerance": -1e-9}, "step_tolerance is -1e-09, which is negative"),
    ],
    ids=str,
)
def test_parameters_are_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        Paper(**parameters)


def test_a_root_beyond_the_faces():
    with pytest.raises(ValueError, match="root is 400, but the faces are numbered from 0 to 395"):
        embedded(smooth_bodies.ellipsoid(), root=400)


def failed(mesh_or_metric, **parameters):
    metric = mesh_or_metric
    if not isinstance(metric, PolyhedralMetric):
        metric = PolyhedralMetric.from_mesh(*mesh_or_metric)
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(metric, method=Paper(**parameters))
    attempt = caught.value.embedding
    assert not attempt.converged
    assert attempt.residual > attempt.tolerance
    assert len(attempt.stages) == 5
    assert str(caught.value) == attempt.message
    return attempt.message


def test_the_diagnosis_names_uniformization():
    message = failed(smooth_bodies.ellipsoid(100), flow="BDF", t_f=0.01, Tsteps=1, max_iterations=3)
    assert "the curvature did not become uniform (k / kbar is off 1 by" in message


def test_the_diagnosis_names_the_uniform_surface():
    message = failed(smooth_bodies.ellipsoid(100), Tsteps=1, max_iterations=1, sphere=False)
    assert "the uniform surface could not be annealed (residual" in message


def test_the_diagnosis_names_the_time_of_the_pull_back():
    metric = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid(100))
    noise = np.random.default_rng(0).normal(size=len(metric.lengths))
    noisy = metric.with_lengths(metric.lengths * (1 + 0.05 * noise))
    message = failed(noisy, Tsteps=4, max_iterations=10)
    assert any(
        f"the pull-back lost the surface at t = {t} t_f" in message for t in ("0.75", "0.5", "0.25", "0")
    )
