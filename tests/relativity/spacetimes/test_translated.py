"""Slices that are moved."""

import numpy as np
import pytest

from isoembed import InvalidParameter
from isoembed.relativity import (
    BoostedSchwarzschild,
    CallableGeometry,
    CartesianGrid,
    IsotropicSchwarzschild,
    StarSurface,
    Translated,
)

CENTER = (0.3, -1.0, 2.0)


def test_a_hole_elsewhere_is_one_that_was_put_there():
    velocity = (0.1, 0.2, -0.3)
    moved = Translated(BoostedSchwarzschild(1.0, velocity), CENTER)
    there = BoostedSchwarzschild(1.0, velocity, CENTER)
    x = np.random.default_rng(1).normal(size=(50, 3)) + 3.0
    assert not moved.time_symmetric and Translated(IsotropicSchwarzschild(1.0), CENTER).time_symmetric
    for field in ("metric", "gradient", "extrinsic_curvature"):
        np.testing.assert_allclose(getattr(moved, field)(x), getattr(there, field)(x), rtol=1e-12, atol=1e-15)


def test_errors_move_along():
    slice_ = CallableGeometry(IsotropicSchwarzschild(1.0).metric, length=8.0)
    u = np.random.default_rng(1).normal(size=(20, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    sphere, moved = StarSurface.sphere((0.0, 0.0, 0.0), 2.0), StarSurface.sphere(CENTER, 2.0)
    expected = slice_.error(lambda slice_: sphere.mean_curvature(slice_, u)[None])
    found = Translated(slice_, CENTER).error(lambda slice_: moved.mean_curvature(slice_, u)[None])
    assert np.abs(expected).max() > 1e-9
    np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_noise_moves_along():
    edge = np.stack(np.meshgrid(*[np.arange(12.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    gamma = np.eye(3) + 1e-3 * np.random.default_rng(0).normal(size=(len(edge), 1, 1)) * np.eye(3)
    grid = CartesianGrid((0.0, 0.0, 0.0), 1.0, np.moveaxis(gamma.reshape(12, 12, 12, 3, 3), (3, 4), (0, 1)))
    x = np.random.default_rng(1).uniform(4.0, 7.0, size=(20, 3))
    expected = [slice_.metric(x) for slice_ in grid.deviating(x)]
    found = [slice_.metric(x + CENTER) for slice_ in Translated(grid, CENTER).deviating(x + CENTER)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert 1e-4 < np.std(np.array(expected) - grid.metric(x)) < 1e-2
    assert not list(Translated(IsotropicSchwarzschild(1.0), CENTER).deviating(x))


def test_a_center_must_be_three_numbers():
    with pytest.raises(InvalidParameter, match="the center must be three finite numbers"):
        Translated(IsotropicSchwarzschild(1.0), (0.0, np.nan, 0.0))
