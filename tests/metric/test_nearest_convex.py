"""Nearest lengths without negative deficits, against a general minimizer and conformal changes."""

import numpy as np
import pytest
from scipy.optimize import minimize

import sharp_bodies
import zoo
from isoembed import InvalidMetric, PolyhedralMetric
from isoembed.metric.nearest_convex import nearest_convex
from isoembed.metric.repair import repaired
from isoembed.metric.variation import deficit_derivative


def noisy(vertices, faces, error, seed=0):
    exact = PolyhedralMetric.from_mesh(vertices, faces)
    noise = np.random.default_rng(seed).standard_normal(len(exact.lengths))
    return exact.with_lengths(exact.lengths + error * exact.mean_length * noise)


def test_the_sum_of_squares_is_the_least():
    metric = noisy(*zoo.subdivided(*zoo.tetrahedron()), 0.01)
    errors = np.random.default_rng(1).uniform(0.5, 2.0, len(metric.lengths))
    assert metric.deficits.min() < -0.01
    found = nearest_convex(metric, errors, np.zeros(len(metric.deficits), dtype=bool), 0.1)
    best = minimize(
        lambda d: d @ d,
        np.zeros(len(errors)),
        jac=lambda d: 2 * d,
        constraints={
            "type": "ineq",
            "fun": lambda d: metric.with_lengths(metric.lengths + errors * d).deficits,
            "jac": lambda d: (
                deficit_derivative(metric.with_lengths(metric.lengths + errors * d)).toarray() * errors
            ),
        },
        method="SLSQP",
        options={"ftol": 1e-14},
    )
    assert found.deficits.min() > -1e-10
    assert np.sum(((found.lengths - metric.lengths) / errors) ** 2) == pytest.approx(best.fun, rel=1e-3)


def test_flat_vertices_of_a_rod():
    vertices, faces = sharp_bodies.BODIES["rod 4 x 20"](0)
    metric = noisy(vertices, faces, 1e-3)
    flat = np.arange(len(vertices)) % len(vertices) >= 4
    flat[-4:] = False
    errors = np.full(len(metric.lengths), 1e-3 * metric.mean_length)
    found = nearest_convex(metric, errors, flat, 0.1)
    assert np.abs(found.deficits[flat]).max() < 1e-10
    squares = np.sum(((found.lengths - metric.lengths) / errors) ** 2)
    assert squares < 1.5 * flat.sum()  # as many conditions have a chi-square of about their number
    conformal = repaired(metric, 1.0, flat=flat)[0]
    assert squares < 0.7 * np.sum(((conformal.lengths - metric.lengths) / errors) ** 2)


def test_a_convex_metric_remains():
    metric = PolyhedralMetric.from_mesh(*zoo.icosahedron())
    errors = np.ones(len(metric.lengths))
    assert nearest_convex(metric, errors, np.zeros(12, dtype=bool), 0.1) is metric


def test_lengths_far_from_convex_are_refused():
    metric = PolyhedralMetric.from_mesh(*sharp_bodies.BODIES["notched prism"](0))
    with pytest.raises(InvalidMetric):
        nearest_convex(metric, np.ones(len(metric.lengths)), np.zeros(len(metric.deficits), dtype=bool), 0.1)
