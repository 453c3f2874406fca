"""Intrinsic Delaunay flips: the criterion, the same metric, planar Delaunay, Ptolemy's flips."""

import numpy as np
import pytest
import scipy.spatial
from hypothesis import given
from hypothesis import strategies as st

import smooth_bodies
import zoo
from curved import body
from isoembed.metric.curvature import area, corner_angles, deficits
from isoembed.metric.delaunay import delaunay, ideal_delaunay
from isoembed.metric.inspection import inspect
from isoembed.metric.polyhedral import PolyhedralMetric


def angle_sums(metric):
    """Sum of the two angles across each edge."""
    across = np.roll(metric.triangulation.face_edges, -1, axis=1)
    return np.bincount(across.ravel(), corner_angles(metric).ravel())


def flippable(triangulation):
    """Edges whose flip would join two vertices that are not joined yet."""
    left, right = zoo.edge_opposites(triangulation).T
    return triangulation.adjacency.toarray()[left, right] == 0


def edge_set(metric):
    return {tuple(edge) for edge in metric.edges.tolist()}


@given(st.integers(0, 10**6), st.integers(4, 60))
def test_flips_reach_delaunay_and_keep_the_metric(seed, n):
    vertices, faces = zoo.random_hull(n, seed)
    metric = PolyhedralMetric.from_mesh(vertices * [1, 1, 4], faces)
    flipped = delaunay(metric)
    assert (angle_sums(flipped)[flippable(flipped.triangulation)] < np.pi + 1e-4).all()
    assert deficits(flipped) == pytest.approx(deficits(metric), abs=1e-7)
    assert area(flipped) == pytest.approx(area(metric), rel=1e-10)
    assert delaunay(flipped).edges.tolist() == flipped.edges.tolist()


def test_there_is_something_to_flip_above():
    vertices, faces = zoo.random_hull(60, 0)
    metric = PolyhedralMetric.from_mesh(vertices * [1, 1, 4], faces)
    assert len(edge_set(delaunay(metric)) - edge_set(metric)) > 20


@pytest.mark.parametrize(
    "mesh", [zoo.tetrahedron(), zoo.octahedron(), zoo.icosphere(1), zoo.cube(), smooth_bodies.ellipsoid()]
)
def test_nothing_to_flip_returns_the_metric_itself(mesh):
    metric = PolyhedralMetric.from_mesh(*mesh)  # in the cube, the squares' corners lie on circles
    assert delaunay(metric) is metric


def flat_topped_cone(points, faces, rim):
    """A planar triangulation, closed by a cone to an apex far below: (vertices, faces)."""
    apex = len(points)
    wall = [[apex, b, a] for a, b in zip(rim, np.roll(rim, -1), strict=True)]
    vertices = np.vstack([np.column_stack([points, np.zeros(apex)]), [0, 0, -20.0]])
    return vertices, np.vstack([faces, wall])


@pytest.mark.parametrize("seed", range(5))
def test_a_flat_region_becomes_the_planar_delaunay_triangulation(seed):
    rng = np.random.default_rng(seed)
    angle = np.append(2 * np.pi * np.arange(16) / 16, rng.uniform(0, 2 * np.pi, 60))
    radius = np.append(np.ones(16), 0.75 * np.sqrt(rng.uniform(size=60)))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])

    def oriented(simplices):
        a, b, c = (points[simplices[:, k]] for k in range(3))
        (x, y), (z, w) = (b - a).T, (c - a).T
        return np.where((x * w - y * z > 0)[:, None], simplices, simplices[:, ::-1])

    sheared = scipy.spatial.Delaunay(points * [1.0, 0.2])  # a poor triangulation of the same disk
    metric = PolyhedralMetric.from_mesh(*flat_topped_cone(points, oriented(sheared.simplices), np.arange(16)))
    flipped = delaunay(metric)
    assert edge_set(flipped) != edge_set(metric)
    best = PolyhedralMetric.from_mesh(
        *flat_topped_cone(points, oriented(scipy.spatial.Delaunay(points).simplices), np.arange(16))
    )
    assert edge_set(flipped) == edge_set(best)
    assert flipped.lengths == pytest.approx(best.lengths, rel=1e-10)


def test_a_flip_that_would_double_an_edge_is_left_alone():
    # A thin rhombus 0 1 2 3 laid double: above it is cut along the long diagonal, below along the short one.
    points = np.array([[-2.0, 0], [0, -0.5], [2, 0], [0, 0.5]])
    metric = PolyhedralMetric.from_mesh(points, [[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]])
    flipped = delaunay(metric)
    assert edge_set(flipped) == edge_set(metric)
    assert flipped.lengths == pytest.approx(metric.lengths)


@pytest.mark.parametrize("scale", [1e-150, 1e12, 1e150])
def test_any_unit(scale):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(40, 7))
    flipped, scaled = delaunay(metric), delaunay(metric.with_lengths(scale * metric.lengths))
    assert edge_set(flipped) == edge_set(scaled) != edge_set(metric)
    assert scaled.lengths / scale == pytest.approx(flipped.lengths, rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_ideal_flips_of_points_on_a_sphere_find_their_hull(seed):
    # Chords of a sphere obey Ptolemy's relation on every circle, and only the hull of points on the sphere is
    # ideal Delaunay, whatever the conformal factors.
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3))
    points, faces = zoo.outward_hull(points / np.linalg.norm(points, axis=1)[:, None])
    hull = PolyhedralMetric.from_mesh(points, faces)
    u = rng.uniform(-1, 1, len(points))
    a, b = hull.edges.T
    triangulation, lengths = ideal_delaunay(hull.triangulation, hull.lengths * np.exp((u[a] + u[b]) / 2), -1)
    assert {tuple(e) for e in triangulation.edges.tolist()} != edge_set(hull)
    a, b = triangulation.edges.T
    back, lengths = ideal_delaunay(triangulation, lengths * np.exp(-(u[a] + u[b]) / 2), -1)
    assert {tuple(e) for e in back.edges.tolist()} == edge_set(hull)
    assert lengths == pytest.approx(hull.lengths, rel=1e-10)


def test_ideal_flips_mend_broken_triangles_and_leave_a_star_alone():
    metric = PolyhedralMetric.from_mesh(*zoo.icosphere(2))
    u = np.random.default_rng(0).uniform(-0.8, 0.8, 162)
    a, b = metric.edges.T
    before = metric.lengths * np.exp((u[a] + u[b]) / 2)
    fixed = int(np.argmin(metric.triangulation.degrees))
    before[metric.edges[:, 0] == fixed] *= 0.1  # as if its star were broken

    def broken(triangulation, lengths):
        away = (triangulation.faces != fixed).all(axis=1)
        sides = np.sort(lengths[triangulation.face_edges][away], axis=1)
        return int((sides[:, 0] + sides[:, 1] <= sides[:, 2]).sum())

    def star(triangulation, lengths):
        at = (triangulation.edges == fixed).any(axis=1)
        return triangulation.edges[at].tolist(), lengths[at].tolist()

    assert broken(metric.triangulation, before) > 0
    triangulation, lengths = ideal_delaunay(metric.triangulation, before, fixed)
    assert broken(triangulation, lengths) == 0
    assert star(triangulation, lengths) == star(metric.triangulation, before)


@pytest.mark.parametrize("k", [-1.0, 0.7])
@pytest.mark.parametrize("seed", range(4))
def test_flips_in_curved_spaces(k, seed):
    x, faces, _ = body(60, seed, k, 2.4, aspect=4.0)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=k)
    flipped = delaunay(metric)
    assert inspect(metric).report["delaunay"]["violations"] > 10
    not_delaunay = triangles_not_delaunay(flipped)
    assert not (not_delaunay & flippable(flipped.triangulation)).any()
    assert deficits(flipped) == pytest.approx(deficits(metric), abs=1e-9)
    assert area(flipped) == pytest.approx(area(metric), rel=1e-10)


def triangles_not_delaunay(metric):
    """Edges across which the angles sum to more than the other four beside them."""
    angles = corner_angles(metric)
    balance = 2 * angles - angles.sum(axis=1, keepdims=True)
    across = np.roll(metric.triangulation.face_edges, -1, axis=1)
    return np.bincount(across.ravel(), balance.ravel()) > 1e-6
