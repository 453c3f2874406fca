"""Pull-back by levels."""

import numpy as np
import pytest

import smooth_bodies
from isoembed import Aim, embed
from isoembed.aim import levels
from isoembed.aim.levels import goes_by_levels, pulled_back_by_levels
from isoembed.aim.nearest_polyhedron import nearest_polyhedron
from isoembed.aim.pipeline import Pipeline
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.rigidity import LengthSystem, length_residuals


@pytest.fixture(scope="module")
def peanut():
    """Its metric, a convex surface near it, and its vertices."""
    x, faces = triangulate(CassiniPeanut(), 3000)
    metric = PolyhedralMetric.from_mesh(x, faces)
    x, metric = x / metric.unit, metric.normalized
    pipeline = Pipeline(metric, Aim(), 1e-9, Log())
    return metric, nearest_polyhedron(pipeline.problem, pipeline), x


@pytest.fixture
def small(monkeypatch):
    """Levels of a surface of 3,000 vertices: two after the guided path."""
    for name, value in {"LEAST_VERTICES": 2000, "GUIDED": 600, "FINEST": 5.15, "GROWTH": 1.2}.items():
        monkeypatch.setattr(levels, name, value)


def test_the_peanut_is_brought_near_also_if_interrupted(peanut, small, monkeypatch):
    metric, start, x = peanut
    system, kept = LengthSystem(metric.triangulation), []
    monkeypatch.setattr(StageRecorder, "keep", lambda _, **arrays: kept.append(arrays))
    found = pulled_back_by_levels(metric, system, start, smooth_bodies.recorder())
    residuals = length_residuals(metric.triangulation, found, metric.lengths)
    assert np.abs(residuals).max() < 1e-4
    assert smooth_bodies.misfit(found, x) < 1e-4
    (only,) = kept
    assert set(only) == {"split"}
    recorder = smooth_bodies.recorder()
    again = pulled_back_by_levels(metric, system, start, recorder, only)
    assert (again == found).all()
    assert recorder.iterations < 12  # no guided path


def test_what_is_not_convex_is_given_up(peanut, small):
    metric, _, x = peanut
    system = LengthSystem(metric.triangulation)
    assert pulled_back_by_levels(metric, system, x, smooth_bodies.recorder()) is None


def test_only_many_vertices_go_by_levels_and_not_after_that_was_given_up(peanut, small):
    metric = peanut[0]
    n = metric.triangulation.n_vertices
    assert goes_by_levels(metric, None)
    assert goes_by_levels(metric, {"split": np.zeros((n, 3))})
    assert not goes_by_levels(metric, {"x": np.zeros((2, n, 3))})
    assert not goes_by_levels(PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid()), None)
    assert not goes_by_levels(PolyhedralMetric(metric.faces, metric.lengths, curvature=-0.01), None)


def test_the_default_method_goes_by_levels(peanut, small):
    metric, _, x = peanut
    found = embed(metric, method=Aim())
    assert found.converged
    assert smooth_bodies.misfit(found.vertices, x) < 1e-9


def test_where_levels_fail_the_path_of_all_vertices_is_followed(monkeypatch):
    for name, value in {
        "LEAST_VERTICES": 500,
        "LANDED": 0.0,
        "GUIDED": 200,
        "FINEST": 4.5,
        "GROWTH": 3.1,
    }.items():
        monkeypatch.setattr(levels, name, value)
    x, faces = triangulate(CassiniPeanut(), 600)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, method=Aim())
    assert smooth_bodies.misfit(found.vertices, x) < 1e-9


@pytest.mark.parametrize("n", [16_000, 40_000, 160_000, 1_000_000])
def test_no_level_has_many_times_the_vertices_of_the_one_before(n):
    counts = np.array([levels.GUIDED, *levels._counts(n)])
    assert (counts[1:] > counts[:-1]).all()
    assert (counts[1:] < 1.01 * levels.GROWTH * counts[:-1]).all()
    assert counts[-1] == pytest.approx(levels.FINEST * n ** (5 / 8), abs=1)


def test_last_steps_are_held_where_rounding_makes_the_matrix_singular(peanut, monkeypatch):
    metric, _, x = peanut
    system, asked, step = LengthSystem(metric.triangulation), [], LengthSystem.step

    def singular(self, vertices, lengths, residuals, mu=0.0):
        asked.append(mu)
        if mu == 0:
            raise SingularMatrix("to rounding")
        return step(self, vertices, lengths, residuals, mu)

    monkeypatch.setattr(LengthSystem, "step", singular)
    nearby = x * (1 + 1e-9 * np.sin(x))
    found = levels._ended(system, metric.lengths, nearby, smooth_bodies.recorder())
    assert np.abs(length_residuals(metric.triangulation, found, metric.lengths)).max() < 1e-12
    assert asked[0] == 0
    assert set(asked[1:]) == {levels.HELD}


def test_last_steps_end_where_they_cannot_be_held(peanut, monkeypatch):
    metric, _, x = peanut

    def singular(*_):
        raise SingularMatrix("to rounding")

    monkeypatch.setattr(LengthSystem, "step", singular)
    recorder, nearby = smooth_bodies.recorder(), x * (1 + 1e-9 * np.sin(x))
    found = levels._ended(LengthSystem(metric.triangulation), metric.lengths, nearby, recorder)
    assert (found == nearby).all()
    assert recorder.iterations == 2
