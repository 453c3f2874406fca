"""Newton's method on the radii at once: convex and nearly convex metrics, or None."""

from functools import partial

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from convex import CONVEX, in_units
from isoembed.aim import newton_on_radii as module
from isoembed.aim.newton_on_radii import newton_on_radii
from isoembed.alexandrov import homotopy
from isoembed.alexandrov.newton import Analyses, pinned
from isoembed.alexandrov.polytope import Polytope
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.linalg import Work
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import length_residuals
from sprinkled import box


def at_once(metric):
    """What the given triangles alone lead to, and the log."""
    given, log = GluedMetric.of(metric), Log()
    analyses = Analyses.of(given.half_edges(), log.work)
    return newton_on_radii(given, analyses, log, partial(outward, given.faces)), log


AT_ONCE = {
    **CONVEX,
    "drum": smooth_bodies.drum,
    "fluted": lambda: triangulate(HarmonicSurface(3, 2, 0.12), 500),
}


@pytest.mark.parametrize("name", AT_ONCE)
def test_the_given_triangles_lead_there_at_once(name):
    vertices, metric = in_units(*AT_ONCE[name]())
    found, log = at_once(metric)
    assert smooth_bodies.misfit(found, vertices) < 1e-12
    assert np.abs(length_residuals(metric.triangulation, found, metric.lengths)).max() < 1e-12
    assert sum(stage.factorizations for stage in log.stages) <= 4


def test_at_once_or_not_at_all():
    flat, faces, _ = box(3)
    for mesh in ((flat, faces), triangulate(HarmonicSurface(3, 2, 0.2), 500), needles()):
        assert at_once(in_units(*mesh)[1])[0] is None


def test_what_has_too_many_negative_eigenvalues_is_left_to_flips(monkeypatch):
    mesh = zoo.shallow_cap(51, 0.061774863832462806, 20)
    vertices, metric = in_units(*mesh)
    assert at_once(metric)[0] is None
    assert smooth_bodies.misfit(isoembed.embed(metric).vertices, vertices) < 1e-10
    monkeypatch.setattr(module, "CONVEX", 2)
    found, _ = at_once(metric)  # it has the same lengths
    assert np.abs(length_residuals(metric.triangulation, found, metric.lengths)).max() < 1e-12
    assert smooth_bodies.misfit(found, vertices) > 1e-3


def needles():
    """Points strewn on a sphere, on a long ellipsoid: their triangles are far from Delaunay there."""
    vertices, faces = zoo.random_hull(200, 1)
    return vertices * [20, 1, 1], faces


@pytest.mark.parametrize("count", [0, 1, 3])
def test_every_vertex_that_is_turned_inside_out_adds_a_negative_eigenvalue(count):
    vertices, faces = zoo.icosphere(2)
    inward = np.isin(np.arange(len(vertices)), [0, 3, 9][:count])  # no neighbors
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    t = metric.triangulation
    rings = t.adjacency @ vertices / t.adjacency.sum(axis=1)[:, None]
    mirrored = vertices * np.where(inward, 2 * (rings * vertices).sum(axis=1) - 1, 1.0)[:, None]
    assert np.abs(length_residuals(t, mirrored, metric.lengths)).max() < 1e-12  # the same lengths
    tables = GluedMetric.of(metric).half_edges()
    p = Polytope.on(tables, np.linalg.norm(mirrored + np.array([0.01, 0.02, 0.03]), axis=1))
    assert np.abs(p.curvatures).max() < 1e-12
    state = pinned(p, Analyses.of(tables, Work()))
    assert state.inverse.negative_pivots == homotopy.CONVEX + count
