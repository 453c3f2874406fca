"""Which three radii are pinned."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import orthogonal_procrustes

import zoo
from isoembed import GluedMetric, PolyhedralMetric, embed
from isoembed.alexandrov.pins import independent_directions, rough_directions
from isoembed.alexandrov.polytope import Polytope
from isoembed.linalg import dissect


def polytope(vertices, faces):
    """The body as a polytope around the mean of its vertices, and their directions from there."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    x = vertices - vertices.mean(axis=0)
    radii = np.linalg.norm(x, axis=1)
    return Polytope.over(GluedMetric.of(metric).half_edges(), radii), x / radii[:, None]


def bipyramid(n, up, down):
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return zoo.outward_hull(np.vstack([ring, [[0, 0, up], [0, 0, -down]]]))


@pytest.mark.parametrize("axes", [(1, 1, 1), (10, 1, 1), (1, 1, 0.01)])
def test_without_curvature_the_directions_are_those_of_the_body(axes):
    points = np.random.default_rng(0).normal(size=(50, 3))
    p, expected = polytope(*zoo.outward_hull(points / np.linalg.norm(points, axis=1, keepdims=True) * axes))
    found = rough_directions(p, dissect(p.jacobian()))
    rotation, _ = orthogonal_procrustes(found, expected)
    assert np.abs(found @ rotation - expected).max() < 1e-9
    assert np.linalg.det(rotation) > 0


@pytest.mark.parametrize(("up", "down"), [(7, 0.001), (5, 5), (9.5, 0.5)])
def test_pins_of_a_hexagonal_bipyramid_are_not_coplanar(up, down):
    p, directions = polytope(*bipyramid(6, up, down))
    pins = independent_directions(p, rough_directions(p, dissect(p.jacobian())))
    assert abs(np.linalg.det(directions[pins])) > 0.3


@pytest.mark.parametrize("axes", [(3, 2, 1), (10, 1, 1), (1, 1, 0.05)])
def test_pins_of_large_bodies_are_not_coplanar(axes):
    points = np.random.default_rng(0).normal(size=(3000, 3))
    p, directions = polytope(*zoo.outward_hull(points / np.linalg.norm(points, axis=1, keepdims=True) * axes))
    pins = independent_directions(p, rough_directions(p, dissect(p.jacobian())))
    assert abs(np.linalg.det(directions[pins])) > 0.1


@pytest.mark.parametrize("height", [0.1, 0.01])
def test_bipyramids_over_polygons_of_many_sides_take_few_factorizations(height):
    vertices, faces = bipyramid(1200, height, height)
    p, directions = polytope(vertices, faces)
    pins = independent_directions(p, rough_directions(p, dissect(p.jacobian())))
    assert abs(np.linalg.det(directions[pins])) > 0.9
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert found.converged
    assert sum(stage.factorizations for stage in found.stages) < 30  # with coplanar pins 120


@pytest.mark.parametrize("n", [5, 6, 7])
@pytest.mark.parametrize("up", [1, 7, 50])
@pytest.mark.parametrize("down", [0.001, 0.7, 5])
def test_bipyramids_are_found(n, up, down):
    vertices, faces = bipyramid(n, up, down)
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-9 * up


@pytest.mark.parametrize("roll", range(3))
@pytest.mark.parametrize(("n", "height", "roof"), [(3, 3.92, 0.02), (6, 3.38, 0.01), (6, 49.0, 0.1)])
def test_prisms_with_a_low_roof_are_found(n, height, roof, roll):
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    points = np.vstack([ring, ring + np.array([0, 0, height]), [[0, 0, height + roof]]])
    vertices, faces = zoo.outward_hull(np.roll(points, roll, axis=0))
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-9 * height


def test_a_vertex_at_the_mean_has_no_direction_and_is_no_pin():
    points = np.random.default_rng(0).normal(size=(1200, 3))
    p, _ = polytope(*zoo.outward_hull(points / np.linalg.norm(points, axis=1, keepdims=True)))
    dissection = dissect(p.jacobian())
    position = dissection.position - dissection.position.mean(axis=0)
    position[5] = 0.0
    position[6] -= position.sum(axis=0)
    directions = rough_directions(p, replace(dissection, position=position))
    assert np.isfinite(directions).all()
    pins = independent_directions(p, directions)
    assert np.linalg.norm(directions[pins], axis=1) == pytest.approx(np.ones(3))
