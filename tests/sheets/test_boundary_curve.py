"""Surfaces through a given curve: random discs are found, from bumps and on the smoother side, too."""

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric, embed
from isoembed.sheets.boundary_curve import starts
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.alignment import distance


def bumpy(seed):
    """A random graph with curvature of both signs: vertices and metric."""
    rng = np.random.default_rng(seed)
    points, faces = discs.irregular(int(rng.integers(60, 250)), seed)
    x, y = points.T
    a, b, c, d = rng.uniform([1.5, 1.2, 0.15, -0.2], [2.5, 2.2, 0.3, 0.2])
    vertices = np.column_stack([points, c * np.sin(a * x + 0.3) * np.cos(b * y) + d * x * y])
    return vertices, PolyhedralMetric.from_mesh(vertices, faces)


def found(metric, x):
    [loop] = metric.triangulation.boundaries
    return embed(metric, boundary=x[loop])


@pytest.mark.parametrize("seed", [11, 14, 23, 27])
def test_random_discs_are_found(seed):
    """With bending until the end, nearly flat vertices of these are on the wrong side of their neighbors."""
    x, metric = bumpy(seed)
    surface = found(metric, x)
    assert surface.residual < 1e-13
    assert distance(surface.vertices, x) < 1e-11


def test_a_disc_whose_bump_is_a_dent_from_the_harmonic_start():
    x, metric = bumpy(1)
    surface = found(metric, x)
    assert distance(surface.vertices, x) < 1e-11
    assert surface.stages[-1].factorizations > 150  # one start takes 60


def test_a_vertex_with_three_neighbors_is_on_the_smoother_side():
    """Its mirror image has the same lengths: no residual tells them apart."""
    x, metric = bumpy(290)
    [v] = np.flatnonzero(~metric.triangulation.boundary_vertices & (metric.triangulation.degrees == 3))
    a, b, c = x[metric.triangulation.adjacency[[v]].indices]
    normal = np.cross(b - a, c - a)
    mirrored = x.copy()
    mirrored[v] -= 2 * (x[v] - a) @ normal / (normal @ normal) * normal
    np.testing.assert_allclose(PolyhedralMetric.from_mesh(mirrored, metric.faces).lengths, metric.lengths)
    assert distance(mirrored, x) > 1e-4
    assert distance(found(metric, x).vertices, x) < 1e-11


def test_starts_have_the_boundary_and_differ():
    x, metric = bumpy(27)
    inside = ~metric.triangulation.boundary_vertices
    boundary = np.where(inside[:, None], 0.0, x)
    all_starts = [start for start, _ in starts(LengthConstraints(metric), boundary, inside)]
    assert len(all_starts) == 7
    for start in all_starts:
        np.testing.assert_array_equal(start[~inside], x[~inside])
    rises = np.array([start - all_starts[0] for start in all_starts[1:]])[:, inside]
    np.testing.assert_allclose(rises[::2], -rises[1::2], atol=1e-15)
    assert np.linalg.matrix_rank(rises[::2].reshape(3, -1)) == 3
