"""Derivatives of the mean curvature of local fits and of its integral."""

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric, Sensitivity, embed
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.fitted_curvature import FittedCurvatureRates


def test_derivatives_for_velocities_of_the_vertices():
    points, faces = discs.irregular(50)
    x = discs.round_cap(points, 1.0) * [1.0, 1.2, 1.1]
    energy = BendingEnergy(PolyhedralMetric.from_mesh(x, faces))
    found = FittedCurvatureRates(energy.metric.triangulation, x, energy)
    v, h = np.random.default_rng(3).normal(size=x.shape), 1e-6
    ahead, behind = (energy.mean_curvature(x + step * v) for step in (h, -h))
    expected = (ahead - behind) / (2 * h)
    np.testing.assert_allclose(found.rates(v), expected, atol=1e-7 * np.abs(expected).max())
    np.testing.assert_allclose(np.sum(found.integral_gradient() * v), energy.areas @ expected, rtol=1e-7)


def test_deviations_are_those_of_surfaces_with_other_lengths():
    """Apart from the changes of the fits at fixed vertices. 1/2 sum l theta deviates half as much."""
    points, faces = discs.irregular(24)
    metric = PolyhedralMetric.from_mesh(discs.round_cap(points, 0.8), faces)
    surface, h = embed(metric, boundary="plane"), 1e-5
    values, curvatures = [], []
    for e in range(len(metric.lengths)):
        for step in (h, -h):
            changed = embed(
                metric.with_lengths(metric.lengths + step * (np.arange(len(metric.lengths)) == e)),
                boundary="plane",
            )
            values.append(changed.integrated_mean_curvature)
            curvatures.append(changed.mean_curvature)
    rates = (np.array(values[::2]) - values[1::2]) / (2 * h)
    found = Sensitivity(surface).deviation(1.0)
    assert found.integrated_mean_curvature == pytest.approx(np.linalg.norm(rates), rel=0.03)
    rates = (np.array(curvatures[::2]) - curvatures[1::2]) / (2 * h)
    np.testing.assert_allclose(found.mean_curvature, np.linalg.norm(rates, axis=0), rtol=0.1)
