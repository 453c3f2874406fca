"""Surfaces through a given curve: random discs are found, from bumps and on the smoother side, too."""

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric, embed
from isoembed.sheets.boundary_curve import starts
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.alignment import distance


def disc(name, seed):
    """A random disc: vertices and metric."""
    x, faces = discs.random_disc(name, seed)
    return x, PolyhedralMetric.from_mesh(x, faces)


def found(metric, x):
    [loop] = metric.triangulation.boundaries
    return embed(metric, boundary=x[loop])


@pytest.mark.parametrize("seed", [11, 14, 23, 27])
def test_random_discs_are_found(seed):
    """With bending until the end, nearly flat vertices of these are on the wrong side of their neighbors."""
    x, metric = disc("bumpy", seed)
    surface = found(metric, x)
    assert surface.residual < 1e-13
    assert distance(surface.vertices, x) < 1e-11


def test_a_disc_whose_bump_is_a_dent_from_the_harmonic_start():
    x, metric = disc("bumpy", 1)
    surface = found(metric, x)
    assert distance(surface.vertices, x) < 1e-11
    assert surface.stages[-1].factorizations > 150  # one start takes 60


def test_bumps_that_thick_sheets_flatten():
    x, metric = disc("bumpy", 200)
    assert distance(found(metric, x).vertices, x) < 1e-11


def test_a_shallow_vertex_is_reflected_far_from_where_lengths_are_missed():
    x, metric = disc("half", 288)
    surface = found(metric, x)
    assert distance(surface.vertices, x) < 1e-11
    assert surface.stages[-1].factorizations > 100  # without reflections


@pytest.mark.parametrize("seed", [144, 290])
def test_a_vertex_with_three_neighbors_is_on_the_smoother_side(seed):
    """Its mirror image has the same lengths: no residual tells them apart."""
    x, metric = disc("bumpy", seed)
    [v] = np.flatnonzero(~metric.triangulation.boundary_vertices & (metric.triangulation.degrees == 3))
    a, b, c = x[metric.triangulation.adjacency[[v]].indices]
    normal = np.cross(b - a, c - a)
    mirrored = x.copy()
    mirrored[v] -= 2 * (x[v] - a) @ normal / (normal @ normal) * normal
    np.testing.assert_allclose(PolyhedralMetric.from_mesh(mirrored, metric.faces).lengths, metric.lengths)
    assert distance(mirrored, x) > 1e-5
    surface = found(metric, x)
    assert distance(surface.vertices, x) < 1e-11
    apart = np.linalg.norm(mirrored[v] - x[v]) / metric.mean_length
    assert f"; vertex {v}, which has three neighbors, has a mirror image in their plane" in surface.message
    assert f"{apart:.1g} mean edge lengths away" in surface.message


def test_reflections_do_not_fit_errors_of_the_lengths():
    """With more dents lengths are missed less: 7 edges were rough, and a vertex 2e-2 edge lengths away."""
    x, exact = disc("bumpy", 27)
    noise = np.random.default_rng(1).normal(0, 1e-5 * exact.mean_length, len(exact.lengths))
    metric = exact.with_lengths(exact.lengths + noise)
    [loop] = metric.triangulation.boundaries
    for start in (None, x):
        surface = embed(metric, boundary=x[loop], start=start, tolerance=1e-4)
        assert not surface.surface.rough_edges.any()
        assert np.linalg.norm(surface.vertices - x, axis=1).max() < 5e-3 * metric.mean_length


def test_rough_surfaces_through_a_curve_say_so():
    x, exact = disc("bumpy", 27)
    noise = np.random.default_rng(1).normal(0, 3e-4 * exact.mean_length, len(exact.lengths))
    metric = exact.with_lengths(exact.lengths + noise)
    [loop] = metric.triangulation.boundaries
    surface = embed(metric, boundary=x[loop], start=x, tolerance=1e-2)
    rough = surface.surface.rough_edges.sum()
    assert f"; {rough} edges are rough: a vertex may be on the wrong side" in surface.message


@pytest.mark.parametrize("side", [1, -1])
def test_over_a_plane_curve_the_surface_is_on_the_upper_side_or_that_of_the_start(side):
    points, faces = discs.hexagonal(3)
    x = discs.round_cap(points, 1.0) * [1, 1, side]
    metric = PolyhedralMetric.from_mesh(x, faces)
    [loop] = metric.triangulation.boundaries
    surface = embed(metric, boundary=x[loop] + [0, 0, 1])
    assert surface.residual < 1e-13
    assert (surface.vertices[:, 2] - surface.vertices[loop[0], 2]).max() > 0.4
    assert "the mirror image in its plane has the same lengths" in surface.message
    again = embed(metric, boundary=x[loop], start=x)
    np.testing.assert_allclose(again.vertices, x, atol=1e-12)


def test_the_mirror_image_over_a_curve_in_a_plane_that_is_not_horizontal():
    points, faces = discs.hexagonal(2)
    x = discs.round_cap(points, 0.5) @ np.array([[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]])
    metric = PolyhedralMetric.from_mesh(x, faces)
    surface = embed(metric, boundary=x[metric.triangulation.boundaries[0]])
    assert "the mirror image in its plane has the same lengths" in surface.message
    np.testing.assert_allclose(surface.vertices, x, atol=1e-9)


def test_a_flat_surface_has_no_other_mirror_image():
    points, faces = discs.hexagonal(2)
    x = np.column_stack([points[:, :2], np.zeros(len(points))])
    metric = PolyhedralMetric.from_mesh(x, faces)
    surface = embed(metric, boundary=x[metric.triangulation.boundaries[0]])
    assert surface.converged and "mirror" not in surface.message


def test_starts_have_the_boundary_and_differ():
    x, metric = disc("bumpy", 27)
    inside = ~metric.triangulation.boundary_vertices
    boundary = np.where(inside[:, None], 0.0, x)
    all_starts = [start for start, _ in starts(LengthConstraints(metric), boundary, inside)]
    assert len(all_starts) == 7
    for start in all_starts:
        np.testing.assert_array_equal(start[~inside], x[~inside])
    rises = np.array([start - all_starts[0] for start in all_starts[1:]])[:, inside]
    np.testing.assert_allclose(rises[::2], -rises[1::2], atol=1e-15)
    assert np.linalg.matrix_rank(rises[::2].reshape(3, -1)) == 3
