"""Starts of embeddings, restored from arrays: what begins from them is the same to the last bit."""

import numpy as np
import pytest

from isoembed.gallery import Ellipsoid
from isoembed.smooth import Harmonics, PulledBack, SphereMap, Start, embed_smooth
from isoembed.smooth.transforms import resized

AXES = (1.3, 1.1, 1.0)
DIFFERENTIAL = np.diag(AXES)
METRIC = PulledBack(lambda u: np.broadcast_to(DIFFERENTIAL, (len(u), 3, 3)))


def restored(start, folder):
    """From a file."""
    np.savez(folder / "start.npz", **start.arrays)
    with np.load(folder / "start.npz") as file:
        return Start.restored(dict(file))


def disturbed(A, degree, seed):
    """Coefficients of a linear map, disturbed, and not in the order of rows in memory."""
    C = resized(SphereMap.linear(A).coefficients, Harmonics(1, 1), Harmonics(degree, degree))
    return np.asfortranarray(C + 1e-3 * np.random.default_rng(seed).normal(size=C.shape))


@pytest.mark.parametrize("own", [False, True], ids=["directions", "coordinates"])
def test_a_restored_start_gives_the_same_bits(own, tmp_path):
    coordinates = SphereMap(Harmonics(2, 2), disturbed(np.eye(3), 2, 0)) if own else None
    start = Start(Harmonics(8, 8), disturbed(DIFFERENTIAL, 8, 1), coordinates)
    again = restored(start, tmp_path)
    first, second = (embed_smooth(METRIC, start=each) for each in (start, again))
    assert abs(first.integrated_mean_curvature / Ellipsoid(AXES).integrated_mean_curvature - 1.0) < 1e-11
    assert first.harmonics == second.harmonics
    np.testing.assert_array_equal(first.coefficients, second.coefficients)
    assert (second.coordinates is not None) == own
    if own:
        np.testing.assert_array_equal(first.coordinates.coefficients, second.coordinates.coefficients)
    assert first.integrated_mean_curvature == second.integrated_mean_curvature
    assert first.residual == second.residual


def test_an_embedding_is_a_start(tmp_path):
    """As it is, or as the arrays that are kept of it."""
    start = Start(Harmonics(8, 8), disturbed(DIFFERENTIAL, 8, 1))
    before = embed_smooth(METRIC, start=start)
    first, second = (
        embed_smooth(METRIC, start=each) for each in (before, restored(Start.of(before), tmp_path))
    )
    np.testing.assert_array_equal(first.coefficients, second.coefficients)
    assert not np.array_equal(first.coefficients, before.coefficients)  # it was one step more
