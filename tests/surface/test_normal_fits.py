"""Many fits at a time: the weights of one fit after the other, and what is left to it."""

import numpy as np
import pytest

from isoembed.surface.fit_loops import fewest, fit_constants
from isoembed.surface.normal_fits import MAX_POINTS, SIDE_BY_SIDE, normal_weights


def weights(charts, degree):
    """Weights and whether they are done, for a list of charts; those of one fit after the other."""
    indptr = np.concatenate([[0], np.cumsum([len(chart) for chart in charts])])
    points = np.concatenate(charts)
    found, expected = np.full(len(points), np.nan), np.empty(len(points))
    done = normal_weights(indptr, points, degree, found)
    fit_constants(np.arange(len(charts)), indptr, points, degree, expected)
    return done, np.repeat(done, np.diff(indptr)), found, expected


def rings(count, seed):
    """Points around the origin that a fit can be trusted with: a sunflower, shaken."""
    rng = np.random.default_rng(seed)
    k = np.arange(count) + 1
    angle, radius = k * np.pi * (3 - 5**0.5), 3 * np.sqrt(k / count)
    spiral = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return spiral + 0.1 * rng.normal(size=spiral.shape)


@pytest.mark.parametrize(("degree", "least"), [(1, 6), (2, 9), (3, 13), (4, 18), (5, 24)])
def test_weights_are_those_of_one_fit_after_the_other(degree, least):
    charts = [rings(least + 10 + seed % 20, seed) for seed in range(2 * SIDE_BY_SIDE + 5)]
    done, _, found, expected = weights(charts, degree)
    assert done.all()
    assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("degree", [3, 5])
def test_what_the_normal_equations_might_spoil_is_left(degree):
    rng = np.random.default_rng(0)
    good = [rings(40, seed) for seed in range(7)]
    angle = rng.uniform(0, 2 * np.pi, 40)
    circle = np.column_stack([1 + np.cos(angle), np.sin(angle)])  # through the origin
    bad = {
        "too few": rings(fewest(degree) - 1, 1),
        "none": np.empty((0, 2)),
        "too many": rings(MAX_POINTS + 1, 2),
        "on a line": rng.normal(size=(40, 1)) * [[0.6, 0.8]],
        "nearly on a line": rings(40, 3) @ [[0.6, 0.8], [1e-4 * 0.8, -1e-4 * 0.6]],
        "stretched": rings(40, 6) @ [[0.6, 0.8], [-0.12, 0.09]],
        "on a circle": circle,
        "on one side": 0.3 * rings(40, 4) + [3, 0],
        "in a point": np.zeros((40, 2)),
        "far": 1e150 * rings(40, 5),
    }
    assert len(bad) <= 2 * len(good)
    charts = [chart for pair in zip(good, bad.values(), strict=False) for chart in pair]
    charts += list(bad.values())[len(good) :]
    done, of_points, found, expected = weights(charts, degree)
    good_ones = np.zeros(len(charts), dtype=bool)
    good_ones[0 : 2 * len(good) : 2] = True
    np.testing.assert_array_equal(done, good_ones)
    assert found[of_points] == pytest.approx(expected[of_points], abs=1e-12)
    assert np.isnan(found[~of_points]).all()


def test_a_constant_that_is_nearly_linear_is_left():
    """Far to one side of the origin, a plane through the points says little about it."""
    charts = [rings(40, 0) + np.array([x, 0.0]) for x in (0, 5, 15, 5)]
    done, of_points, found, expected = weights(charts, 1)
    assert done.tolist() == [True, True, False, True]
    assert found[of_points] == pytest.approx(expected[of_points], abs=1e-12)
