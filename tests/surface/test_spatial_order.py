"""The order of points: each once, and neighbors near each other in it."""

import numpy as np
import pytest

from isoembed.surface.spatial_order import spatial_order


def mean_step(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).mean()


def test_steps_are_as_short_as_the_points_are_near():
    """On a surface of n points at random: of order n^(-1/2), where a random order has 1."""
    steps = []
    for n in (1000, 16_000):
        points = np.random.default_rng(0).normal(size=(n, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        order = spatial_order(points)
        np.testing.assert_array_equal(np.sort(order), np.arange(n))
        steps.append(mean_step(points[order]))
    assert steps[0] / steps[1] == pytest.approx(4, rel=0.1)
    assert steps[1] < 0.05


def test_each_axis_counts_and_the_longest_sets_the_unit():
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    assert spatial_order(corners[::-1]).tolist() == list(range(8))[::-1]
    line = np.arange(1000)[:, None] * [1e-200, 0, 0] + [5e-200, 0, 0]
    np.testing.assert_array_equal(spatial_order(line), np.arange(1000))


def test_a_single_place_keeps_its_order():
    np.testing.assert_array_equal(spatial_order(np.ones((9, 3))), np.arange(9))
