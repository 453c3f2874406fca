"""Dihedral angles, mean curvature, area and volume: closed forms, Schlaefli's formula, rates, invariances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import dual_areas
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Hyperbolic
from isoembed.surface.curvature import (
    bending_energy,
    dihedral_angles,
    edge_mean_curvature,
    face_mean_curvature,
    integrated_mean_curvature,
    vertex_mean_curvature,
)
from isoembed.surface.measures import area, face_areas, outward, volume
from isoembed.surface.vertex_areas import FARTHEST, vertex_area_changes, vertex_area_rates, vertex_areas

PLATONIC = {
    # body: (mesh, interior dihedral angle, edge length, volume in cubed edges)
    "tetrahedron": (zoo.tetrahedron(), np.arccos(1 / 3), 8**0.5, 1 / 72**0.5),
    "octahedron": (zoo.octahedron(), np.arccos(-1 / 3), 2**0.5, 2**0.5 / 3),
    "icosahedron": (zoo.icosahedron(), np.arccos(-(5**0.5) / 3), 2.0, 5 / 12 * (3 + 5**0.5)),
}


@pytest.mark.parametrize(("mesh", "interior", "size", "cubes"), PLATONIC.values(), ids=PLATONIC.keys())
def test_platonic_bodies_of_triangles(mesh, interior, size, cubes):
    vertices, faces = mesh
    t = Triangulation(faces)
    exterior = np.pi - interior
    assert dihedral_angles(t, vertices) == pytest.approx(exterior, rel=1e-13)
    assert edge_mean_curvature(t, vertices) == pytest.approx(size * exterior / 2, rel=1e-13)
    assert integrated_mean_curvature(t, vertices) == pytest.approx(t.n_edges * size * exterior / 2, rel=1e-13)
    surface = t.n_faces * 3**0.5 / 4 * size**2
    assert area(faces, vertices) == pytest.approx(surface, rel=1e-13)
    assert volume(faces, vertices) == pytest.approx(cubes * size**3, rel=1e-13)
    # H is the same everywhere: the integral over the area.
    mean = t.n_edges * size * exterior / 2 / surface
    assert vertex_mean_curvature(t, vertices) == pytest.approx(mean, rel=1e-13)
    assert face_mean_curvature(t, vertices) == pytest.approx(mean, rel=1e-13)


def test_cube():
    vertices, faces = zoo.cube()
    t = Triangulation(faces)
    angles = np.sort(dihedral_angles(t, vertices))
    assert angles[:6] == pytest.approx(0.0, abs=1e-14)  # the diagonals of the squares
    assert angles[6:] == pytest.approx(np.pi / 2, rel=1e-14)
    assert integrated_mean_curvature(t, vertices) == pytest.approx(3 * np.pi, rel=1e-14)
    assert (area(faces, vertices), volume(faces, vertices)) == pytest.approx((6.0, 1.0), rel=1e-14)


def test_flat_edges_and_right_angles_keep_their_digits():
    t = Triangulation(zoo.TETRAHEDRON)
    for height in (1e-3, 1e-6, 1e-9):  # a low tent: its ridge 0-1 bends by 2 atan(height)
        vertices = np.array([[0.0, -1, height], [0, 1, height], [-1, 0, 0], [1, 0, 0]])
        ridge = np.abs(dihedral_angles(t, vertices)[0])
        assert ridge == pytest.approx(2 * np.arctan(height), rel=1e-12, abs=0)


def test_unit_sphere_converges_to_four_pi_at_second_order():
    errors, sizes = [], []
    for level in (2, 3, 4):
        vertices, faces = zoo.icosphere(level)
        t = Triangulation(faces)
        errors.append(
            [
                4 * np.pi - integrated_mean_curvature(t, vertices),
                4 * np.pi - area(faces, vertices),
                4 / 3 * np.pi - volume(faces, vertices),
                np.average(face_mean_curvature(t, vertices), weights=face_areas(faces, vertices)) - 1,
            ]
        )
        sizes.append(np.linalg.norm(vertices[t.edges[:, 0]] - vertices[t.edges[:, 1]], axis=1).mean())
    rates = np.diff(np.log(errors), axis=0) / np.diff(np.log(sizes))[:, None]
    assert rates == pytest.approx(2.0, abs=0.1)


def test_a_cylinder_has_its_mean_curvature():
    """A prism over an n-gon: int H = h (2 pi) / 2 on the side, (pi / 2) (perimeter) / 2 on each rim."""
    n, h = 40, 3.0
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices, faces = zoo.outward_hull(np.vstack([np.c_[rim, np.zeros(n)], np.c_[rim, np.full(n, h)]]))
    perimeter = 2 * n * np.sin(np.pi / n)
    expected = np.pi * h + 2 * np.pi / 2 * perimeter / 2
    assert integrated_mean_curvature(Triangulation(faces), vertices) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_schlaefli(seed):
    """``sum l dtheta = 0`` however the vertices move; so d(sum l theta) = sum theta dl."""
    _, faces = zoo.random_hull(20, seed)
    rng = np.random.default_rng([seed, 1])
    vertices, velocity = rng.normal(size=(2, 20, 3))  # a crumpled surface: convexity plays no part
    t, step = Triangulation(faces), 1e-6
    i, j = t.edges.T
    lengths = np.linalg.norm(vertices[i] - vertices[j], axis=1)
    ahead = dihedral_angles(t, vertices + step * velocity)
    behind = dihedral_angles(t, vertices - step * velocity)
    rate = np.angle(np.exp(1j * (ahead - behind))) / (2 * step)  # across the cut at pi, too
    assert np.abs(rate).max() > 1
    assert abs((lengths * rate).sum()) < 1e-6 * (lengths * np.abs(rate)).sum()


@given(seed=st.integers(0, 10**6))
def test_two_formulas_for_the_angle(seed):
    vertices, faces = zoo.random_hull(20, seed)
    t = Triangulation(faces)
    a, b = (vertices[end] for end in t.edges.T)
    p, q = (vertices[tip] for tip in zoo.edge_opposites(t).T)
    d = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    u, v = (x - a - ((x - a) * d).sum(axis=1)[:, None] * d for x in (p, q))
    cosine = (u * v).sum(axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    convex = dihedral_angles(t, vertices)
    assert (convex > 0).all()
    assert np.cos(convex) == pytest.approx(-cosine, abs=1e-9)


@given(seed=st.integers(0, 10**6))
def test_rigid_motions_labels_and_orientation(seed):
    _, faces = zoo.random_hull(20, seed)
    vertices = np.random.default_rng([seed, 1]).normal(size=(20, 3))
    t = Triangulation(faces)
    angles, whole = dihedral_angles(t, vertices), volume(faces, vertices)
    away = np.abs(np.abs(angles) - np.pi) > 1e-6

    def same(first, second):
        assert first[away] == pytest.approx(second[away], abs=1e-8)

    same(dihedral_angles(t, vertices @ zoo.rotation(seed).T + [10, 20, -5]), angles)
    same(dihedral_angles(t, vertices * [1, 1, -1]), -angles)
    same(dihedral_angles(Triangulation(faces[:, ::-1]), vertices), -angles)
    points, other, new = zoo.relabeled(vertices, faces, seed)
    s = Triangulation(other)
    same(dihedral_angles(s, points)[s.edge_indices(new[t.edges])], angles)
    assert volume(other, points) == pytest.approx(whole, abs=1e-12)
    assert volume(faces[:, ::-1], vertices) == pytest.approx(-whole, rel=1e-12)
    assert volume(faces, vertices + 100.0) == pytest.approx(whole, rel=1e-9, abs=1e-9)
    assert volume(faces, outward(faces, vertices)) == pytest.approx(abs(whole), rel=1e-12)


@pytest.mark.parametrize("scale", [1e-50, 1e-12, 1e12, 1e50])
def test_scaling(scale):
    vertices, faces = zoo.random_hull(30, 0)
    t = Triangulation(faces)
    for measure, power in [
        (dihedral_angles, 0),
        (edge_mean_curvature, 1),
        (integrated_mean_curvature, 1),
        (vertex_mean_curvature, -1),
        (face_mean_curvature, -1),
    ]:
        assert measure(t, scale * vertices) / scale**power == pytest.approx(measure(t, vertices), rel=1e-9)
    assert area(faces, scale * vertices) / scale**2 == pytest.approx(area(faces, vertices), rel=1e-12)
    assert volume(faces, scale * vertices) / scale**3 == pytest.approx(volume(faces, vertices), rel=1e-12)


def test_a_vertex_without_area_has_no_mean_curvature():
    vertices, faces = (np.array(part) for part in zoo.icosphere(1))
    around = np.unique(faces[(faces == 5).any(axis=1)])
    vertices[around] = vertices[5]
    found = vertex_mean_curvature(Triangulation(faces), vertices)
    assert np.isnan(found[5])
    assert np.isfinite(np.delete(found, around)).all()


def test_the_parts_of_the_mean_curvature_add_up():
    vertices, faces = zoo.random_hull(40, 1)
    t = Triangulation(faces)
    whole = integrated_mean_curvature(t, vertices)
    areas = face_areas(faces, vertices)
    duals = dual_areas(PolyhedralMetric.from_mesh(vertices, faces))
    assert duals.sum() == pytest.approx(areas.sum(), rel=1e-13)
    assert edge_mean_curvature(t, vertices).sum() == pytest.approx(whole, rel=1e-14)
    assert (face_mean_curvature(t, vertices) * areas).sum() == pytest.approx(whole, rel=1e-13)
    assert (vertex_mean_curvature(t, vertices) * duals).sum() == pytest.approx(whole, rel=1e-13)


def on_sphere(vertices):
    return vertices / np.linalg.norm(vertices, axis=1)[:, None]


def test_a_sphere_has_its_mean_curvature_at_every_vertex():
    """Also at the twelve vertices with five neighbors, in hyperbolic space, and of random points."""
    for level, off in ((2, 0.014), (3, 0.004)):
        vertices, faces = zoo.icosphere(level)
        t = Triangulation(faces)
        found = vertex_mean_curvature(t, vertices)
        assert np.abs(found - 1).max() < off
        curved = vertex_mean_curvature(t, np.sinh(1) * vertices, space=Hyperbolic(1.0))
        assert np.abs(curved * np.tanh(1) - 1).max() < 2 * off
    vertices, faces = zoo.random_hull(3000, 1)
    t, vertices = Triangulation(faces), on_sphere(vertices)
    assert np.abs(vertex_mean_curvature(t, vertices) - 1).max() < 0.01  # with thirds of triangles, 8
    assert bending_energy(t, vertices) == pytest.approx(4 * np.pi, rel=1e-3)


def test_an_ellipsoid_has_its_mean_curvature_at_its_vertices():
    surface, errors = Ellipsoid((3, 2, 1)), []
    for n in (400, 1600):
        vertices, faces = triangulate(surface, n)
        exact = surface.mean_curvature(vertices / [3.0, 2.0, 1.0])
        errors.append(
            np.sqrt(np.mean((vertex_mean_curvature(Triangulation(faces), vertices) / exact - 1) ** 2))
        )
    assert errors[1] < 0.02 and errors[1] < errors[0] / 2


def test_shares_of_the_area_are_those_of_the_metric():
    vertices, faces = zoo.icosphere(2)
    metric = PolyhedralMetric.from_mesh(vertices * [2, 1, 1], faces)
    found = vertex_areas(metric.triangulation, vertices * [2, 1, 1])
    assert found == pytest.approx(dual_areas(metric), rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_shares_of_the_area_change_at_their_rates_and_within_their_bounds(seed):
    """Those of a crumpled surface are in all three ranges."""
    _, faces = zoo.random_hull(60, seed)
    rng = np.random.default_rng(seed)
    x, v = rng.normal(size=(2, 60, 3)) * [1, 1, 0.01]
    t, step = Triangulation(faces), 1e-7
    thirds = np.bincount(faces.ravel(), np.repeat(face_areas(faces, x) / 3, 3))
    ratios = vertex_areas(t, x) / thirds
    assert np.isclose(ratios, 1 / FARTHEST).any() and (ratios < FARTHEST * 1.001).all()

    def change(measure, by):
        return measure(x + by * v) - measure(x - by * v)

    def squares(x):
        return ((x[t.edges[:, 0]] - x[t.edges[:, 1]]) ** 2).sum(axis=1)

    def areas(x):
        return face_areas(faces, x)

    rates = vertex_area_rates(t, x, change(areas, step) / (2 * step), change(squares, step) / (2 * step))
    seen = change(lambda x: vertex_areas(t, x), step) / (2 * step)
    assert rates == pytest.approx(seen, abs=1e-4 * np.abs(seen).max())

    for size in (1e-3, 1e-5):
        y = x + size * v
        bound = vertex_area_changes(
            t, x, 1.001 * np.abs(squares(y) - squares(x)), 1.001 * np.abs(areas(y) - areas(x))
        )
        seen = np.abs(vertex_areas(t, y) - vertex_areas(t, x))
        assert (seen <= bound + 1e-12).all()
        assert np.median(seen / bound) > 0.02
