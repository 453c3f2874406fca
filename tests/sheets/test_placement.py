"""Standard position of sheets and tori: numbers of vertices and rounding do not turn or mirror them."""

import numpy as np
import pytest

import discs
import zoo
from isoembed import PolyhedralMetric, embed
from isoembed.surface.alignment import aligned
from isoembed.surface.measures import face_normals
from isoembed.surface.placement import standard_sheet

POINTS, FACES = discs.irregular(80)
X, Y = POINTS.T
DOME = discs.round_cap(POINTS, 1.0) * [1.0, 1.2, 1.1]
WAVE = np.column_stack([X, Y, 0.5 * (X**2 - Y**2) + 0.1 * X**3])
SURFACES = {"dome": (DOME, FACES), "saddle": (WAVE, FACES), "torus": discs.torus(12, 8, 0.1)}


def renumbered(x, faces, seed):
    rng = np.random.default_rng(seed)
    new = rng.permutation(len(x))
    moved = np.empty_like(x)
    moved[new] = x
    return moved, np.roll(new[rng.permutation(faces)], rng.integers(3), axis=1), new


@pytest.mark.parametrize("name", SURFACES)
def test_a_free_surface_has_the_same_coordinates_with_other_numbers(name):
    x, faces = SURFACES[name]
    expected = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free").vertices
    moved, triangles, new = renumbered(x, faces, 1)
    found = embed(PolyhedralMetric.from_mesh(moved, triangles), boundary="free").vertices
    np.testing.assert_allclose(found[new], expected, rtol=0, atol=1e-10 * np.ptp(expected))


@pytest.mark.parametrize("condition", ["plane", "heights"])
def test_over_a_plane_only_the_horizontal_position_is_standard(condition):
    x, faces = discs.round_cap(POINTS, 1.0), FACES
    moved, triangles, new = renumbered(x, faces, 2)
    found = []
    for vertices, own in ((x, faces), (moved, triangles)):
        metric = PolyhedralMetric.from_mesh(vertices, own)
        [loop] = metric.triangulation.boundaries
        heights = 0.05 * vertices[loop, 0] ** 2
        surface = embed(metric, boundary="plane" if condition == "plane" else heights)
        z = surface.vertices[loop, 2]
        np.testing.assert_allclose(np.ptp(z - heights * (condition == "heights")), 0.0, atol=1e-12)
        np.testing.assert_allclose(surface.vertices[loop, :2].mean(axis=0), 0.0, atol=1e-12)
        found.append(surface.vertices)
    np.testing.assert_allclose(found[1][new], found[0], rtol=0, atol=1e-10)


def test_domes_bulge_upward_and_triangles_are_counterclockwise_from_above():
    metric = PolyhedralMetric.from_mesh(DOME, FACES)
    x = embed(metric, boundary="free").vertices
    rim = metric.triangulation.boundary_vertices
    assert x[~rim, 2].mean() > x[rim, 2].max()
    assert face_normals(metric.faces, x)[:, 2].min() > 0
    y = embed(PolyhedralMetric.from_mesh(DOME, FACES[:, ::-1]), boundary="free").vertices
    np.testing.assert_allclose(y, x * [1.0, -1.0, 1.0], rtol=0, atol=1e-10)


def test_of_mirror_images_without_mean_curvature_one_is_standard():
    """A catenoid: int H dA is zero, and no side is above."""
    x, faces = discs.band(12, 6, lambda t: (np.cosh(1.5 * t - 0.75), 1.5 * t))
    x[:, 0] *= 1.1
    t = PolyhedralMetric.from_mesh(x, faces).triangulation
    standard = standard_sheet(t, x)
    np.testing.assert_allclose(standard_sheet(t, standard), standard, rtol=0, atol=1e-12)
    mirrored = standard_sheet(t, x * [1.0, 1.0, -1.0] @ zoo.rotation(1) + 3.0)
    np.testing.assert_allclose(mirrored, standard, rtol=0, atol=1e-12)


def test_a_start_leaves_the_surface_where_it_is():
    metric = PolyhedralMetric.from_mesh(DOME, FACES)
    x = embed(metric, boundary="free").vertices @ zoo.rotation(2) + 3.0
    found = embed(metric, boundary="free", start=x).vertices
    np.testing.assert_allclose(aligned(found, x), found, rtol=0, atol=1e-12)
    assert np.linalg.norm(found - x, axis=1).max() < 0.1
