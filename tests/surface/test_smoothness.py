"""What tells a smooth surface from others with the same lengths: closed forms, rates, and such neighbors."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad

import isoembed
import smooth_bodies
import zoo
from isoembed.aim.anneal import anneal
from isoembed.cli.summary import summary
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.report import report
from isoembed.gallery import Ergosphere, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.curvature import bending_energy
from isoembed.surface.measures import vertex_normals
from isoembed.surface.rigidity import LengthSystem, edge_rows
from isoembed.surface.smoothness import (
    QuinticResiduals,
    fine_roughness,
    fit_residuals,
    offsets,
    rough_edges,
    roughness,
)

AXES = (1.5, 1.2, 1.0)


def realization(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return Embedding(metric, vertices, method="test", tolerance=1e-10)


def measured(vertices, faces):
    t = Triangulation(faces)
    out = offsets(t, vertices)
    return roughness(t, vertices, out), rough_edges(t, vertices, out)


def dumbbell(level=3):
    """A body with a waist, where its Gaussian curvature is negative."""
    u, faces = zoo.icosphere(level)
    waist = 1 - 0.3 * np.exp(-3 * u[:, 2] ** 2)
    return np.column_stack([u[:, 0] * waist, u[:, 1] * waist, 1.6 * u[:, 2]]), faces


def turned_over(vertices, faces, which):
    """Another surface with the same lengths, near the one whose vertices `which` are mirrored in their rings.

    None if Newton's method does not find one.
    """
    t = Triangulation(faces)
    a, b = t.edges.T
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    start = vertices.copy()
    start[which] = 2 * (t.adjacency @ vertices)[which] / t.degrees[which, None] - vertices[which]
    size = lengths.mean()
    found = anneal(
        LengthSystem(t), start / size, lengths / size, smooth_bodies.recorder(), residual_tolerance=1e-12
    )
    apart = found.converged and zoo.aligned(size * found.vertices, vertices) > 1e-3 * size
    return size * found.vertices if apart else None


@cache
def neighbors(name):
    """A smooth surface, and what one to three vertices turned over make of it: mesh, list of vertices."""
    vertices, faces = {"ellipsoid": smooth_bodies.ellipsoid(800), "dumbbell": dumbbell()}[name]
    rng = np.random.default_rng(1)
    draws = [rng.choice(len(vertices), 1 + k % 3, replace=False) for k in range(12)]
    found = [turned_over(vertices, faces, which) for which in draws]
    return vertices, faces, [other for other in found if other is not None]


@pytest.mark.parametrize("name", ["ellipsoid", "dumbbell"])
def test_the_smooth_surface_is_told_from_its_neighbors(name):
    vertices, faces, others = neighbors(name)
    assert len(others) >= 4
    here = realization(vertices, faces)
    assert not here.surface.rough_edges.any()
    for other in others:
        there = Embedding(here.metric, other, method="test", tolerance=1e-10)
        assert there.converged
        assert there.surface.rough_edges.sum() >= 3
        assert there.surface.roughness > here.surface.roughness
        assert there.surface.bending_energy > here.surface.bending_energy


def test_rough_edges_are_about_the_vertex_that_is_turned_over():
    vertices, faces = zoo.icosphere(3)
    t = Triangulation(faces)
    other = turned_over(vertices, faces, [100])
    rough = measured(other, faces)[1]
    at = (t.edges == 100).any(axis=1)
    assert rough[at].all()
    near = t.adjacency.toarray()[100] > 0
    assert near[t.edges[rough & ~at]].any(axis=1).all()


def test_smooth_surfaces_of_either_curvature_have_no_rough_edges():
    for vertices, faces in (smooth_bodies.ellipsoid(), smooth_bodies.drum(), dumbbell(2), dumbbell(4)):
        assert not measured(vertices, faces)[1].any()


@given(seed=st.integers(0, 10**6))
def test_convex_bodies_have_no_rough_edges_however_coarse(seed):
    assert not measured(*zoo.random_hull(12, seed))[1].any()


def test_offsets_shrink_with_the_fourth_power_of_the_edge_length():
    sizes = []
    for level in (3, 4, 5):
        u, faces = zoo.icosphere(level)
        sizes.append(np.sqrt((offsets(Triangulation(faces), u * AXES) ** 2).sum(axis=1).mean()))
    assert np.log2(sizes[0] / sizes[1]) == pytest.approx(4, abs=0.1)
    assert np.log2(sizes[1] / sizes[2]) == pytest.approx(4, abs=0.1)


def test_blocks_of_vertices_are_measured_like_all_at_once(monkeypatch):
    vertices, faces = dumbbell(2)
    t = Triangulation(faces)
    whole = offsets(t, vertices), fine_roughness(t, vertices), fit_residuals(t, vertices).toarray()
    monkeypatch.setattr("isoembed.surface.smoothness.CHUNK", 37)
    parts = offsets(t, vertices), fine_roughness(t, vertices), fit_residuals(t, vertices).toarray()
    assert parts[0] == pytest.approx(whole[0], abs=1e-15)
    assert parts[1] == pytest.approx(whole[1], rel=1e-9)
    assert parts[2] == pytest.approx(whole[2], abs=1e-13)
    normals = vertex_normals(faces, vertices)
    heights = np.einsum("ij,ij->i", whole[2] @ vertices, normals)  # the matrix and what goes without it
    assert whole[0] == pytest.approx(heights[:, None] * normals, abs=1e-14)
    quintics = fit_residuals(t, vertices, 5)
    twice = np.linalg.norm(quintics @ (quintics @ vertices), axis=1)
    lengths = np.linalg.norm(vertices[t.edges[:, 0]] - vertices[t.edges[:, 1]], axis=1)
    about = np.bincount(t.edges.ravel(), np.repeat(lengths, 2)) / t.degrees
    assert whole[1] == pytest.approx(np.mean((twice / about) ** (2 / 3)) ** 1.5, rel=1e-9)


def test_an_offset_is_the_height_of_a_vertex_lifted_from_a_plane():
    """On a fine box: the fit to flat neighbors is flat, so that all of the lift is left."""
    vertices, faces = zoo.cube()
    for _ in range(4):
        vertices, faces = zoo.subdivided(vertices, faces)
    middle = int(np.argmin(np.linalg.norm(vertices - [1, 0.5, 0.5], axis=1)))
    assert vertices[middle] == pytest.approx([1, 0.5, 0.5])
    lifted = vertices.copy()
    lifted[middle, 0] += 0.01
    out = offsets(Triangulation(faces), lifted)
    assert out[middle] == pytest.approx([0.01, 0, 0], abs=1e-3 * 0.01)


def test_roughness_of_one_offset():
    vertices, faces = zoo.icosahedron()  # all edges 2
    out = np.zeros_like(vertices)
    out[3] = [0, 0, 0.5]
    assert roughness(Triangulation(faces), vertices, out) == pytest.approx(0.5 / 2 / 12**0.5, rel=1e-14)


def willmore(a, b, c):
    """Integral of H^2 over an ellipsoid, by quadrature over the angles."""

    def integrand(phi, theta):
        x, y, z = a * np.sin(theta) * np.cos(phi), b * np.sin(theta) * np.sin(phi), c * np.cos(theta)
        h = np.sqrt(x**2 / a**4 + y**2 / b**4 + z**2 / c**4)
        H = (a**2 + b**2 + c**2 - x**2 - y**2 - z**2) / (2 * (a * b * c) ** 2 * h**3)
        return 8 * H**2 * a * b * c * np.sin(theta) * h

    return dblquad(integrand, 0, np.pi / 2, 0, np.pi / 2)[0]


@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), AXES, (3.0, 2.0, 1.0)])
def test_bending_energy_converges_at_second_order(axes):
    errors = []
    for level in (3, 4):
        u, faces = zoo.icosphere(level)
        errors.append(bending_energy(Triangulation(faces), u * axes) - willmore(*axes))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.15)
    assert abs(errors[1]) < 2e-3 * willmore(*axes)


def test_bending_energy_of_a_sphere():
    assert willmore(1, 1, 1) == pytest.approx(4 * np.pi, rel=1e-10)
    vertices, faces = zoo.icosahedron()
    # The same everywhere: (int H)^2 / area, with int H = 1/2 sum l theta and faces of area sqrt 3.
    whole = 30 * 2 * (np.pi - np.arccos(-(5**0.5) / 3)) / 2
    assert bending_energy(Triangulation(faces), vertices) == pytest.approx(
        whole**2 / (20 * 3**0.5), rel=1e-13
    )


def dense_smallest(vertices, faces):
    t = Triangulation(faces)
    a, b = t.edges.T
    rows = edge_rows(t, vertices, np.linalg.norm(vertices[a] - vertices[b], axis=1))
    J = np.zeros((t.n_edges, len(vertices), 3))
    J[np.arange(t.n_edges), a], J[np.arange(t.n_edges), b] = rows, -rows
    return np.linalg.svd(J.reshape(t.n_edges, -1), compute_uv=False)[-1]


@pytest.mark.parametrize(
    "mesh", [zoo.tetrahedron(), zoo.octahedron(), zoo.icosphere(2), smooth_bodies.ellipsoid(), dumbbell(2)]
)
def test_smallest_singular_value_is_that_of_the_dense_matrix(mesh):
    assert isoembed.Sensitivity(realization(*mesh)).smallest_singular_value == pytest.approx(
        dense_smallest(*mesh), rel=1e-3
    )


def test_a_singular_value_near_zero_keeps_its_digits():
    """A vertex 1e-5 above the plane of its ring can nearly move."""
    vertices, faces = zoo.octahedron()
    top = int(np.argmax(vertices[:, 2]))
    low = vertices.copy()
    low[top, 2] = 1e-5
    found = isoembed.Sensitivity(realization(low, faces)).smallest_singular_value
    assert 1e-6 < found < 1e-4
    assert found == pytest.approx(dense_smallest(low, faces), rel=1e-6)


def test_a_surface_that_flexes_has_no_smallest_singular_value():
    vertices, faces = zoo.subdivided(*zoo.subdivided(*zoo.cube()))  # vertices within faces move freely
    assert isoembed.Sensitivity(realization(vertices, faces)).smallest_singular_value == 0.0


@pytest.mark.parametrize("scale", [1e-100, 1e-12, 1e12, 1e100])
def test_no_measure_depends_on_the_unit(scale):
    vertices, faces = zoo.icosphere(2)
    vertices = vertices * AXES
    vertices[30] *= 0.9
    unit, scaled = (
        isoembed.report(realization(size * vertices, faces))["smoothness"] for size in (1.0, scale)
    )
    assert scaled["rough_edges"] == unit["rough_edges"] > 0
    assert scaled == pytest.approx(unit, rel=1e-5)


@given(seed=st.integers(0, 10**6))
def test_no_measure_depends_on_position_labels_or_handedness(seed):
    vertices, faces = zoo.icosphere(1)
    vertices = vertices * AXES + 0.05 * np.random.default_rng(seed).normal(size=vertices.shape)
    points, other, _ = zoo.relabeled(vertices @ zoo.rotation(seed).T + [4, -5, 6], faces, seed)
    here = isoembed.report(realization(vertices, faces))["smoothness"]
    assert isoembed.report(realization(points, other))["smoothness"] == pytest.approx(here, rel=1e-3)
    assert isoembed.report(realization(points * [1, -1, 1], other))["smoothness"] == pytest.approx(
        here, rel=1e-3
    )


def test_normals_are_outward_units():
    vertices, faces = zoo.icosphere(3)
    normals = vertex_normals(faces, vertices)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1, rel=1e-14)
    assert np.einsum("ij,ij->i", normals, vertices) == pytest.approx(1, abs=1e-3)
    assert vertex_normals(faces, 1e-120 * vertices) == pytest.approx(normals, abs=1e-14)


def collapsed(name):
    """Realizations that are none: what is asked of them, and the vertices."""
    vertices, faces = zoo.icosphere(2)
    t, points = Triangulation(faces), vertices.copy()
    star = np.flatnonzero(t.adjacency.toarray()[40])
    if name == "a point":
        points[:] = 1.0
    elif name == "a line":
        points[:, 1:] = 0.0
    elif name == "a plane":
        points[:, 2] = 0.0
    elif name == "an edge":
        points[t.edges[7, 0]] = points[t.edges[7, 1]]
    elif name == "a star":
        points[star] = points[40]
    elif name == "nearly a star":
        points[star] = points[40] + 1e-160 * (points[star] - points[40])
    elif name == "two far apart":
        points[1] = points[0]
    return PolyhedralMetric.from_mesh(vertices, faces), points


@pytest.mark.parametrize(
    "name", ["a point", "a line", "a plane", "an edge", "a star", "nearly a star", "two far apart"]
)
def test_degenerate_surfaces_are_measured_too(name):
    metric, points = collapsed(name)
    report = isoembed.report(Embedding(metric, points, method="test", tolerance=1e-10))["smoothness"]
    for key, value in report.items():
        assert value is not None, key
        assert value >= 0, key
    flexible = name != "two far apart"
    assert (report["smallest_singular_value"] == 0.0) == flexible
    if name in ("a point", "a line", "a plane"):
        assert (report["roughness"], report["rough_edges"]) == (0.0, 0)


def test_a_doubly_covered_polygon_is_smooth_and_flexible():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    report = isoembed.report(realization(square, zoo.TETRAHEDRON))["smoothness"]
    assert report["smallest_singular_value"] == report["roughness"] == report["rough_edges"] == 0
    # Each corner holds int H = pi / 2, on an area of 1/2.
    assert report["bending_energy"] == pytest.approx(2 * np.pi**2, rel=1e-12)


def test_reports_of_large_surfaces_do_without_a_factorization(monkeypatch):
    surface = realization(*zoo.icosphere(2))
    monkeypatch.setattr("isoembed.embedding.report.MAX_REPORTED_ENTRIES", 1000)
    assert isoembed.report(surface)["smoothness"]["smallest_singular_value"] is None
    assert isoembed.Sensitivity(surface).smallest_singular_value > 0
    assert "smallest singular value not computed" in summary(surface, report(surface))


def test_the_summary_says_what_the_report_says():
    vertices, faces = zoo.icosphere(2)
    vertices[30] *= 0.9
    surface = realization(vertices, faces)
    assert (
        f"{surface.surface.rough_edges.sum()} edges bent against their neighborhood, "
        f"roughness {surface.surface.roughness:.4g}, bending energy {surface.surface.bending_energy:.4g}\n"
    ) in summary(surface, report(surface))
    assert (
        f"smallest singular value {isoembed.Sensitivity(surface).smallest_singular_value:.4g}\n"
        in summary(surface, report(surface))
    )


@pytest.mark.parametrize("seed", range(4))
def test_fine_roughness_does_not_depend_on_the_orientation(seed):
    vertices, faces = irregular_ergosphere()
    t = Triangulation(faces)
    turned = fine_roughness(t, vertices @ zoo.rotation(seed))
    assert turned == pytest.approx(fine_roughness(t, vertices), rel=1e-8)


def test_quintic_residuals_are_those_of_the_matrix():
    vertices, faces = irregular_ergosphere()
    t, v = Triangulation(faces), np.random.default_rng(0).normal(size=vertices.shape)
    quintics, R = QuinticResiduals.of(t, vertices), fit_residuals(t, vertices, 5).toarray()
    R /= np.linalg.norm(R, axis=1)[:, None]
    np.testing.assert_allclose(quintics.pull(v), R.T @ R.T @ R @ R @ v, atol=1e-8)
    assert quintics.roughness(vertices) == pytest.approx(fine_roughness(t, vertices), rel=1e-6)


@cache
def irregular_ergosphere():
    return triangulate(Ergosphere(epsilon=0.02), 1000, irregular=1)
