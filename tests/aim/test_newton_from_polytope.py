"""Newton's method on the radii from a polyhedron: convex and nearly convex metrics in few factorizations."""

from functools import partial

import numpy as np
import pytest

import smooth_bodies
from convex import CONVEX, in_units
from isoembed.aim.convexification import NEAR_MARGIN, Convexification
from isoembed.aim.newton_from_polytope import _reflected, newton_from_polytope, polytope_start
from isoembed.aim.newton_on_radii import inverted_vertices, without_curvature
from isoembed.alexandrov.newton import Analyses, pinned
from isoembed.alexandrov.placement import realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.linalg import Work
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.surface.measures import outward, vertex_normals
from isoembed.surface.rigidity import LengthSystem, length_residuals
from sprinkled import box


def solved(metric):
    """The start, the solution, and the log."""
    given, log = GluedMetric.of(metric), Log()
    with log.stage("waypoint") as recorder:
        convex = Convexification(given).metric(NEAR_MARGIN, recorder)
    analyses = Analyses.of(given.half_edges(), log.work)
    start = polytope_start(given, convex, analyses, log)
    return start, newton_from_polytope(given, start, analyses, log, partial(outward, given.faces)), log


@pytest.mark.parametrize("name", CONVEX)
def test_convex_metrics_in_three_factorizations(name):
    vertices, metric = in_units(*CONVEX[name]())
    start, solution, log = solved(metric)
    assert start.shape == (len(vertices),)
    assert smooth_bodies.misfit(solution.vertices, vertices) < 1e-12
    assert np.abs(length_residuals(metric.triangulation, solution.vertices, metric.lengths)).max() < 1e-12
    assert sum(stage.factorizations for stage in log.stages) <= 3


def test_many_edges_of_what_is_found_may_be_concave():
    _, metric = in_units(*CONVEX["irregular"]())
    assert Convexification(GluedMetric.of(metric)).is_convex
    x = solved(metric)[1].vertices
    t = metric.triangulation
    opposite = t.faces.sum(axis=1)[t.edge_faces] - t.edges.sum(axis=1)[:, None]
    sides = x[np.column_stack([t.edges, opposite])]
    volumes = np.linalg.det(sides[:, 1:] - sides[:, :1])
    assert min((volumes > 0).sum(), (volumes < 0).sum()) > len(volumes) / 20


def test_nearly_convex_metrics_by_way_of_a_convex_one():
    vertices, metric = in_units(*smooth_bodies.drum())
    assert not Convexification(GluedMetric.of(metric)).is_convex
    start, solution, _ = solved(metric)
    assert 1e-4 < smooth_bodies.misfit(start, vertices) < 0.1
    assert smooth_bodies.misfit(solution.vertices, vertices) < 1e-12


def test_it_deviates_to_second_order():
    # Two convex metrics, one twice as far from the given one; three surfaces predict the next.
    vertices, faces = CONVEX["Kerr"]()
    x = vertices / vertices.std()
    bend = x * (1 + 0.05 * np.cos(2 * x[:, :1]))
    missed = []
    for share in (1.0, 0.5):
        start = PolyhedralMetric.from_mesh(x + share * (bend - x), faces)
        metric = PolyhedralMetric.from_mesh(x, faces)
        convex = GluedMetric.of(metric.with_lengths(start.lengths))
        given = GluedMetric.of(metric)
        log = Log()
        analyses = Analyses.of(given.half_edges(), log.work)
        start = polytope_start(given, convex, analyses, log)
        solution = newton_from_polytope(given, start, analyses, log, partial(outward, given.faces))
        missed.append(solution.branch_deviation)
    assert 3 < missed[0] / missed[1] < 5


def test_it_agrees_with_newtons_method_on_the_lengths():
    _, metric = in_units(*CONVEX["irregular"]())
    x = solved(metric)[1].vertices
    r = length_residuals(metric.triangulation, x, metric.lengths)
    step = LengthSystem(metric.triangulation).step(x, metric.lengths, r)
    assert np.abs(step).max() < 1e-10  # nothing is left to do


def test_where_the_curvature_is_negative_it_says_that_it_does_not_converge():
    start, solution, _ = solved(in_units(*triangulate(CassiniPeanut(), 600))[1])
    assert start.shape == (600, 3)
    assert solution is None


def test_flat_vertices_have_no_radii():
    vertices, faces, flat = box(3)
    assert flat.any()
    metric = GluedMetric.of(in_units(vertices, faces)[1])
    assert polytope_start(metric, metric, Analyses.of(metric.half_edges(), Work()), Log()) is None


@pytest.mark.parametrize("rank", [0, 10, 20, 40])
def test_a_vertex_that_went_in_comes_out(rank):
    # The realization of an ellipsoid's lengths with one vertex pushed in: from there, back to the ellipsoid.
    vertices, metric = in_units(*smooth_bodies.ellipsoid(800))
    given = GluedMetric.of(metric)
    tables = given.half_edges()
    v = np.argsort(given.deficits)[rank]  # where the surface is flattest
    ring = np.flatnonzero(metric.triangulation.adjacency[[v]].toarray()[0])
    normal = vertex_normals(metric.faces, vertices)[v]
    pushed = vertices.copy()
    pushed[v] -= 2 * ((vertices[v] - vertices[ring].mean(axis=0)) @ normal) * normal
    recorder = smooth_bodies.recorder()
    p = Polytope.on(tables, np.linalg.norm(pushed, axis=1))
    start = pinned(p, Analyses.of(tables, recorder.work))
    inside, _ = without_curvature(start, 1e-12, recorder)
    assert np.flatnonzero(inverted_vertices(inside.polytope)).tolist() == [v]
    outside = _reflected(inside, recorder)
    assert not inverted_vertices(outside.polytope).any()
    assert (
        smooth_bodies.misfit(realized(outside, recorder), vertices)
        < 1e-12
        < 1e-3
        < smooth_bodies.misfit(pushed, vertices)
    )
