"""Derivatives of volumes and integrals in hyperbolic and spherical space, against differences."""

import numpy as np
import pytest

import isoembed
from curved import body
from isoembed import Embedding, PolyhedralMetric
from isoembed.relativity import mesh_deviation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface import curvature, measures
from isoembed.surface.derivatives import volume_gradient
from isoembed.surface.rigidity import LengthSystem

SPACES = ((-1.0, 3.0), (-1.0, 0.3), (1.0, 1.5), (1e-9, 1.0))


def surface(k, size):
    """A body with 20 vertices, found in its space."""
    x, faces, _ = body(20, 4, k, size)
    metric = PolyhedralMetric(faces, Space(k).distances(*x[edges(faces)]), edges(faces).T, curvature=k)
    return Embedding(metric, x, method="given", tolerance=1e-9)


def edges(faces):
    """Their ends, (2, E)."""
    return np.unique(
        np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])), axis=0
    ).T


@pytest.mark.parametrize(("k", "size"), SPACES)
def test_volume_by_vertices(k, size):
    x, faces, _ = body(20, 4, k, size)
    found, space = surface(k, size), Space(k)
    gradient = volume_gradient(found.triangulation, x, space)
    rng = np.random.default_rng(0)
    for _ in range(4):
        v = rng.standard_normal(x.shape)
        h = 1e-5 * size
        higher, lower = (measures.volume(faces, x + s * h * v, space) for s in (1, -1))
        assert np.isclose(np.sum(gradient * v), (higher - lower) / (2 * h), rtol=1e-7, atol=1e-8)


def test_nearly_flat_space():
    x, _, _ = body(20, 4, 1e-9, 1.0)
    t = surface(1e-9, 1.0).triangulation
    assert np.allclose(
        volume_gradient(t, x, Space(1e-9)), volume_gradient(t, x, EUCLIDEAN), rtol=1e-7, atol=1e-9
    )


@pytest.mark.parametrize(("k", "size"), SPACES)
def test_one_wrong_length(k, size):
    """Each integral changes as Newton's method on the lengths finds it."""
    found, space, h = surface(k, size), Space(k), 1e-6 * size
    system, lengths = LengthSystem(found.triangulation, space=space), found.metric.lengths

    def measured(changed):
        x = found.vertices
        for _ in range(4):
            missed = measures.edge_lengths(found.metric.edges, x, space) - changed
            x = x - system.step(x, changed, missed)
        return np.array(
            [
                measures.area(found.faces, x, space),
                measures.volume(found.faces, x, space),
                curvature.integrated_mean_curvature(found.triangulation, x, space),
            ]
        )

    for e in (0, 7):
        one = np.eye(len(lengths))[e]
        difference = (measured(lengths + h * one) - measured(lengths - h * one)) / (2 * h)
        sigma = isoembed.Sensitivity(found).integral_deviation(one)
        bars = [sigma.area, sigma.volume, sigma.integrated_mean_curvature]
        assert np.allclose(bars, np.abs(difference), rtol=1e-4, atol=1e-6)


def test_energies_in_hyperbolic_space():
    found = surface(-1.0, 0.3)
    sigma = mesh_deviation(found, 1e-6, lengths="chord")
    assert 0 < sigma["area"] < 1e-4 and 0 < sigma["integrated_mean_curvature"] < 1e-4
