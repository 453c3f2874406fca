"""From a metric to its polytope and its vertices, compared with discarded coordinates."""

import numpy as np
import pytest

import zoo
from curved import apart, body, metric_in
from isoembed import PolyhedralMetric, embed
from isoembed.alexandrov import homotopy
from isoembed.alexandrov.homotopy import (
    EXACT,
    FORCING,
    NEWTON_CURVATURE,
    START_RADII,
    Stalled,
    Waypoint,
    follow_path,
)
from isoembed.alexandrov.newton import Analyses, Solution, newton
from isoembed.alexandrov.pins import independent_directions
from isoembed.alexandrov.placement import placed, polished, realized
from isoembed.alexandrov.polytope import Polytope
from isoembed.intrinsic.loops import flip
from isoembed.linalg import Work
from isoembed.metric.curvature import deficits
from isoembed.metric.glued import GluedMetric
from isoembed.progress.stages import Log
from isoembed.space import Space
from isoembed.space.models import from_model
from scrambling import scramble


def problem(vertices, faces, scrambled=None, curvature=0.0):
    metric = metric_in(vertices, faces, curvature)
    tables = GluedMetric.of(metric).half_edges()
    scramble(tables, 10 * len(vertices) if scrambled is None else scrambled, np.random.default_rng(0))
    return tables, deficits(metric)


def solved(tables, deficits):
    with Log().stage("polytope") as recorder:
        *path, last = follow_path(tables, deficits, recorder)
    return path, last, recorder


def worst_edge(solution, vertices):
    tables = solution.polytope.tables
    chords = vertices[tables.corners] - vertices[tables.corners[tables.twins]]
    return np.abs(np.linalg.norm(chords, axis=1) - tables.lengths).max() / tables.lengths.mean()


@pytest.mark.parametrize("axes", [(1, 1, 1), (3, 2, 1), (30, 1, 1), (1, 1, 0.03), (300, 1, 1), (1, 1, 0.003)])
def test_bodies_of_all_shapes(axes):
    points = np.random.default_rng(1).normal(size=(60, 3))
    vertices, faces = zoo.outward_hull(points / np.linalg.norm(points, axis=1)[:, None] * axes)
    _, solution, _ = solved(*problem(vertices, faces))
    assert isinstance(solution, Solution)
    found = polished(solution, placed(solution))
    assert worst_edge(solution, found) < 1e-10
    assert zoo.aligned(found, vertices) < 1e-9 * max(axes)


@pytest.mark.parametrize("aspect", [1.0, 30.0])
@pytest.mark.parametrize(
    ("k", "size"), [(-1.0, 0.02), (-1.0, 2.0), (-1.0, 6.0), (1.0, 0.02), (1.0, 2.0), (1.0, 3.0), (0.25, 6.0)]
)
def test_bodies_of_all_sizes_in_space_forms(k, size, aspect):
    x, faces, _ = body(30, 1, k, size, aspect=aspect)
    tables, epsilon = problem(x, faces, curvature=k)
    _, solution, recorder = solved(tables, epsilon)
    assert isinstance(solution, Solution)
    assert apart(x, realized(solution, recorder), k) < 1e-11


@pytest.mark.parametrize(("k", "size"), [(-1.0, 0.2), (-1.0, 2.0), (1.0, 0.2), (1.0, 2.0)])
def test_a_round_body_in_a_space_form_takes_two_factorizations(k, size):
    sphere, faces = zoo.icosphere(3)
    x = from_model(Space(k), sphere * [0.45 * size, 0.4 * size, 0.35 * size], "projective")
    _, solution, recorder = solved(*problem(x, faces, curvature=k))
    assert recorder.factorizations == 2
    assert apart(x, realized(solution, recorder), k) < 1e-12


@pytest.mark.parametrize(("n", "seed", "size", "aspect"), [(25, 1, 6.0, 0.04), (25, 3, 6.0, 30.0)])
def test_starts_with_negative_curvatures_in_hyperbolic_space(n, seed, size, aspect):
    x, faces, _ = body(n, seed, -1.0, size, aspect=aspect)
    path, solution, recorder = solved(*problem(x, faces, curvature=-1.0))
    # The first start does not arrive.
    starts = [p for p in path if np.ptp(p.radii) == 0]
    assert len(starts) == 2
    assert all(p.curvatures.min() < 0 for p in starts)
    assert apart(x, realized(solution, recorder), -1.0) < 1e-10


@pytest.mark.parametrize("axes", [(1e4, 1.3, 1), (1, 1.3, 1e-4)])
def test_needles_and_slabs_of_ten_thousand_to_one(axes):
    points = np.random.default_rng(0).normal(size=(12, 3))
    vertices, faces = zoo.outward_hull(points / np.linalg.norm(points, axis=1)[:, None] * axes)
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-9 * max(axes)


@pytest.mark.parametrize("height", [1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 2e-6])
def test_a_thin_tetrahedron_is_not_flat(height):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.2, 1.1, 0], [0.9, 1, height]])
    metric = PolyhedralMetric.from_mesh(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    found = embed(metric, method="alexandrov")
    # Lengths hold the square of the height to some roundings.
    assert found.volume == pytest.approx(1.1 * height / 6, rel=1e-9 + 4e-15 / height**2)


def test_the_tetrahedron():
    vertices, faces = zoo.tetrahedron()
    _, solution, _ = solved(*problem(vertices, faces, scrambled=0))
    assert zoo.aligned(placed(solution), vertices) < 1e-12


def test_a_round_body_takes_two_factorizations():
    vertices, faces = zoo.icosphere(3)
    vertices = vertices * [3.0, 2.0, 1.0]
    path, solution, recorder = solved(*problem(vertices, faces))
    assert recorder.factorizations == 2
    assert len(path) < 15
    # The curvatures of the path go down from the deficits' size.
    assert np.linalg.norm(path[-1].curvatures) < 0.05 * np.linalg.norm(path[0].curvatures)
    assert np.abs(solution.polytope.curvatures).max() < 1e-12


def test_the_polish_takes_the_errors_of_the_placement_away():
    vertices, faces = zoo.icosphere(3)
    _, solution, _ = solved(*problem(vertices * [3.0, 2.0, 1.0], faces))
    shaken = placed(solution) + 1e-7 * np.random.default_rng(0).normal(size=vertices.shape)
    once = polished(solution, shaken)
    assert worst_edge(solution, shaken) > 1e-7
    assert worst_edge(solution, once) < 1e-3 * worst_edge(solution, shaken)
    assert polished(solution, once) is once or worst_edge(solution, polished(solution, once)) < 1e-12


def test_newton_gives_up_far_from_a_solution():
    tables, epsilon = problem(*zoo.random_hull(40, 2))
    start = Polytope.over(tables, np.full(40, 50.0))
    with Log().stage("newton") as recorder:
        assert newton(start, epsilon, Analyses.of(tables, recorder.work), recorder) is None


def test_the_pins_see_the_apex_at_right_angles():
    vertices, faces = zoo.icosphere(3)
    tables, _ = problem(vertices, faces, scrambled=0)
    pins = independent_directions(Polytope.over(tables, np.ones(len(vertices))), vertices)
    products = vertices[pins] @ vertices[pins].T
    assert np.abs(products - np.eye(3)).max() < 0.2


def test_a_path_that_ends_within_reach_of_newtons_method(monkeypatch):
    tables, deficits = problem(*zoo.random_hull(60, 3))
    whole = homotopy._path

    def ended(here, deficits, *rest):
        for p in whole(here, deficits, *rest):
            yield p
            if np.abs(p.curvatures).max() <= NEWTON_CURVATURE * deficits.max():
                return

    monkeypatch.setattr(homotopy, "_path", ended)
    with Log().stage("polytope") as recorder:
        *_, last = follow_path(tables, deficits, recorder, near=np.full(60, 1e-9))
    assert isinstance(last, Solution)


def test_triangles_that_did_not_change_are_analyzed_once():
    tables, _ = problem(*zoo.random_hull(60, 3), scrambled=0)
    analyses, p = Analyses.of(tables, Work()), Polytope.over(tables, np.full(60, 50.0))
    first = analyses.solver(p.jacobian())
    assert analyses.solver(p.jacobian()) is first
    flipped = tables.copy()
    assert any(flip(h, flipped.views, 0.0) for h in range(flipped.corners.size))
    assert analyses.solver(Polytope.on(flipped, p.radii).jacobian()) is not first


def test_the_path_says_where_newtons_method_stalls_and_goes_on(monkeypatch):
    monkeypatch.setattr(homotopy, "newton", lambda *_: None)
    tables, deficits = problem(*zoo.random_hull(20, 0))
    with Log().stage("polytope") as recorder:
        path = follow_path(tables, deficits, recorder)
        largest = [np.abs(p.polytope.curvatures).max() for p in path if isinstance(p, Stalled)]
    ladder = len(START_RADII)
    assert len(largest) > ladder
    assert largest[0] <= NEWTON_CURVATURE * deficits.max()
    assert largest[1] <= NEWTON_CURVATURE / 10 * deficits.max()


def test_after_a_step_that_was_too_short_equations_are_solved_more_exactly(monkeypatch):
    monkeypatch.setattr(homotopy, "TOO_SHORT", -1)
    asked, kept, roughly = [], [], homotopy._solved

    def solved(p, inverse, b, residual):
        asked.append(residual)
        return roughly(p, inverse, b, residual)

    monkeypatch.setattr(homotopy, "_solved", solved)
    vertices, _ = zoo.random_hull(60, 3)
    tables, deficits = problem(*zoo.outward_hull(vertices * (30, 1, 1)))
    with Log().stage("polytope") as recorder:
        *_, last = follow_path(tables, deficits, recorder, kept.append)
    assert isinstance(last, Solution)
    assert asked[0] == FORCING
    assert set(asked[1:]) == {EXACT}
    exact = [here for here in kept if here.residual == EXACT]
    assert exact
    assert Waypoint.of_arrays(exact[0].arrays()).residual == EXACT
