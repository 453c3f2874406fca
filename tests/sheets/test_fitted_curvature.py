"""Derivatives of the mean curvature of local fits and of its integral."""

import numpy as np

import discs
from isoembed import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.fitted_curvature import FittedCurvatureRates, fitted_mean_curvature

POINTS, FACES = discs.irregular(50)
DOME = discs.round_cap(POINTS, 1.0) * [1.0, 1.2, 1.1]
METRIC = PolyhedralMetric.from_mesh(DOME, FACES).normalized
X = DOME / PolyhedralMetric.from_mesh(DOME, FACES).unit


def curvature(lengths, x):
    energy = BendingEnergy(METRIC.with_lengths(lengths))
    H = fitted_mean_curvature(energy, METRIC.faces, x)
    return H, energy.areas @ H


def test_derivatives_by_lengths_and_vertices():
    rng, h = np.random.default_rng(3), 1e-6
    v, dl = rng.normal(size=X.shape), rng.normal(size=len(METRIC.lengths))
    found = FittedCurvatureRates.of(METRIC, X)
    by_lengths, by_vertices = found.integral_gradients()
    for changes, velocity in ((dl, 0 * v), (0 * dl, v), (dl, v)):
        (ahead, whole), (behind, less) = (
            curvature(METRIC.lengths + step * changes, X + step * velocity) for step in (h, -h)
        )
        expected = (ahead - behind) / (2 * h)
        np.testing.assert_allclose(
            found.rates(changes, velocity), expected, atol=1e-7 * np.abs(expected).max()
        )
        change = by_lengths @ changes + np.sum(by_vertices * velocity)
        np.testing.assert_allclose(change, (whole - less) / (2 * h), rtol=1e-7)
