"""Uniformization of smooth metrics."""

import numpy as np

from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth import Harmonics, PulledBack, gaussian_curvature
from reproduction.baselines.uniformization import uniformized


def test_uniformization_undoes_a_conformal_change():
    # A round sphere, conformally changed by a function that no Moebius map makes.
    def w(u):
        return 0.2 * u[:, 0] * u[:, 1] + 0.1 * u[:, 2] ** 2

    metric = PulledBack(lambda u: np.exp(w(u))[:, None, None] * np.eye(3))
    harmonics = Harmonics(12, 12)
    found = uniformized(metric, harmonics)
    assert found.settled

    class Uniform:
        def tensor(self, u):
            factors = np.exp(2.0 * harmonics.values(u) @ found.factors)
            return factors[:, None, None] * metric.tensor(u)

    u = fibonacci_directions(60)
    K = gaussian_curvature(Uniform(), u)
    np.testing.assert_allclose(K, K.mean(), rtol=1e-5)
    X = harmonics.values(u) @ found.coefficients
    np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1 / np.sqrt(K.mean()), rtol=1e-5)
    assert np.linalg.det(np.linalg.lstsq(u, X, rcond=None)[0]) > 0.0  # not turned inside out
