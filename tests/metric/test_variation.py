"""Derivatives of deficits, areas and lengths: central differences, homogeneity, needles, any scale."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import smooth_bodies
import zoo
from curved import body
from isoembed.metric.conformal import rescaled
from isoembed.metric.curvature import area, deficits, dual_areas
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.variation import (
    area_derivative,
    deficit_derivative,
    dual_area_derivative,
    length_derivative,
)


def central_differences(f, x):
    """d f / d x, one column an entry of x."""
    columns = []
    for k in range(len(x)):
        h = np.zeros_like(x)
        h[k] = 1e-5 * x[k]
        columns.append((f(x + h) - f(x - h)) / (2 * h[k]))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize(
    "mesh", [zoo.tetrahedron(), zoo.cube(), zoo.random_hull(12, 0), zoo.random_hull(20, 3)]
)
def test_derivatives_by_length_are_central_differences(mesh):
    metric = PolyhedralMetric.from_mesh(*mesh)
    for function, derivative in (
        (deficits, deficit_derivative(metric).toarray()),
        (dual_areas, dual_area_derivative(metric).toarray()),
        (area, area_derivative(metric)),
    ):

        def of_lengths(lengths, function=function):
            return function(metric.with_lengths(lengths))

        differences = central_differences(of_lengths, metric.lengths)
        assert np.abs(differences - derivative).max() < 1e-6 * np.abs(derivative).max()


def test_the_derivative_by_conformal_factors_is_a_central_difference():
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(15, 2))
    u = np.random.default_rng(0).uniform(0.05, 0.1, 15)
    differences = central_differences(lambda w: rescaled(metric, w).lengths, u)
    assert np.abs(differences - length_derivative(metric, u).toarray()).max() < 1e-9


@given(st.integers(0, 10**6), st.integers(4, 30))
def test_euler_and_schlaefli_sums(seed, n):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(n, seed))
    l, size = metric.lengths, area(metric)
    by_length = deficit_derivative(metric)
    # Deficits are of degree 0, areas of degree 2; all deficits sum to 4 pi, all dual areas to the area.
    scale = abs(by_length) @ l
    assert np.abs(by_length @ l / scale).max() < 1e-11
    assert np.abs(by_length.sum(axis=0) / abs(by_length).sum(axis=0)).max() < 1e-11
    duals = dual_area_derivative(metric)
    assert np.abs(duals @ l - 2 * dual_areas(metric)).max() < 1e-9 * (abs(duals) @ l).max()
    assert np.abs(duals.sum(axis=0) - area_derivative(metric)).max() < 1e-9 * abs(duals).max()
    assert area_derivative(metric) @ l == pytest.approx(2 * size, rel=1e-11)


@given(st.floats(1e-8, 1.0))
def test_needles(b):
    # A bipyramid over a triangle with sides b; legs of length 1: apex angles 2 asin(b / 2).
    faces = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]]
    edges = [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [2, 3], [0, 4], [1, 4], [2, 4]]
    metric = PolyhedralMetric(faces, [b] * 3 + [1.0] * 6, edges)
    slope = 1 / np.sqrt(1 - b**2 / 4)
    apex = dict(zip(map(tuple, metric.edges.tolist()), deficit_derivative(metric).toarray()[3], strict=True))
    for base in ((0, 1), (0, 2), (1, 2)):
        assert apex[base] == pytest.approx(-slope, rel=1e-14, abs=0)
    for k in range(3):
        assert apex[k, 3] == pytest.approx(b * slope, rel=0, abs=1e-15)  # a roundoff of the largest entry
        assert apex[k, 4] == 0


@pytest.mark.parametrize("scale", [1e-150, 1e-30, 1e12, 1e100])
def test_any_unit(scale):
    metric = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid())
    scaled = metric.with_lengths(scale * metric.lengths)
    deficit = deficit_derivative(scaled)
    assert abs(deficit * scale - deficit_derivative(metric)).max() < 1e-12
    assert abs(dual_area_derivative(scaled) / scale - dual_area_derivative(metric)).max() < 1e-12
    assert area_derivative(scaled) / scale == pytest.approx(area_derivative(metric), rel=1e-10, abs=1e-14)


@pytest.mark.parametrize("k", [-1.0, 0.7])
def test_derivatives_in_curved_spaces(k):
    x, faces, _ = body(20, 3, k, 1.8)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=k)
    for function, derivative in (
        (deficits, deficit_derivative(metric).toarray()),
        (area, area_derivative(metric)),
    ):
        differences = central_differences(lambda l, f=function: f(metric.with_lengths(l)), metric.lengths)
        assert np.abs(differences - derivative).max() < 1e-6 * np.abs(derivative).max()
