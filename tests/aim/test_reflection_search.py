"""Vertices on the wrong side of their neighbors."""

import numpy as np
import pytest

import isoembed
import smooth_bodies
from isoembed import Aim, NotEmbedded
from isoembed.aim.anneal import anneal
from isoembed.aim.reflection_search import _halves, with_reflected_vertices
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.vertex_reflections import reflections
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.linalg import OutOfMemory
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem, length_residuals

PUSHED = [20, 150]


@pytest.fixture(scope="module")
def pushed_in():
    """The metric of an ellipsoid with two vertices pushed in, and the ellipsoid."""
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 300, irregular=2)
    whole = PolyhedralMetric.from_mesh(vertices, faces)
    given = vertices.copy()
    given[PUSHED] += reflections(whole.triangulation, vertices)[PUSHED]
    metric = PolyhedralMetric.from_mesh(given, faces)
    return metric.normalized, vertices / metric.unit


def searched(metric, charts, start, most):
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, charts, recorder.work)
    system = LengthSystem(metric.triangulation, work=recorder.work)
    return with_reflected_vertices(energy, system, start, metric.lengths, recorder, most), recorder


def missed(metric, vertices):
    return np.abs(length_residuals(metric.triangulation, vertices, metric.lengths)).max()


def test_a_realization_is_found_to_which_newtons_method_does_not_lead(pushed_in):
    metric, whole = pushed_in
    found, recorder = searched(metric, whole, whole, 500)
    assert missed(metric, found) < 1e-11
    assert 0 < recorder.factorizations < 500
    system = LengthSystem(metric.triangulation)
    assert not anneal(system, whole, metric.lengths, recorder).residual < 1e-3


def test_it_stops_when_all_is_spent(pushed_in):
    metric, whole = pushed_in
    few, recorder = searched(metric, whole, whole, 3)
    assert recorder.factorizations == 3
    more, _ = searched(metric, whole, whole, 20)
    assert missed(metric, more) < missed(metric, few) < missed(metric, whole)


def test_where_memory_is_short_what_was_met_is_kept(pushed_in, monkeypatch):
    def refused(*_):
        raise OutOfMemory("the factors need more than is free")

    monkeypatch.setattr(RegularizedEnergy, "newton_factor", refused)
    metric, whole = pushed_in
    found, _ = searched(metric, whole, whole, 500)
    assert 0 < missed(metric, found) < missed(metric, whole)


def test_a_search_that_finds_nothing_more_ends_before_all_is_spent():
    lengths = [1.0, 1.0, 1.0, 1.0, 1.0, 1.95]  # of no tetrahedron
    metric = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], lengths).normalized
    start = np.array([[1.0, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]]) / 2.8
    _, recorder = searched(metric, start, start, 5_000)
    assert recorder.factorizations < 1_000


def test_the_two_halves_of_what_is_tried_together():
    assert _halves(list("abcde")) == [list("abcde"), list("ab")]
    assert _halves(["a"]) == []


@pytest.mark.slow
def test_a_bumpy_body_that_only_a_longer_search_finds():
    x, faces = triangulate(Ellipsoid((1, 1, 1)), 400, irregular=3)
    rng = np.random.default_rng(11)
    bumps = sum(np.cos(x @ (3 * rng.normal(size=3)) + rng.uniform(0, 6.3)) for _ in range(6))
    vertices = x * (1 + rng.uniform(0.03, 0.08) * bumps)[:, None]
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with pytest.raises(NotEmbedded, match=r"Aim\(effort=20\)"):
        isoembed.embed(metric)
    found = isoembed.embed(metric, method=Aim(effort=10))
    assert found.residual < 1e-11
    assert "changes of sides" in [stage.name for stage in found.stages]
