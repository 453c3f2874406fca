"""The cotangent Laplacian: of finite elements, and the derivative of the deficits by conformal factors."""

import numpy as np
import pytest

import zoo
from curved import body
from isoembed.metric.conformal import equivalent
from isoembed.metric.curvature import area
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian, deficit_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric


def glued(vertices, faces):
    return GluedMetric.of(PolyhedralMetric.from_mesh(vertices, faces))


def test_it_is_symmetric_and_kills_constants():
    K = cotangent_laplacian(glued(*zoo.random_hull(40, 0)))
    assert np.abs(K - K.T).max() < 1e-13 * np.abs(K).max()
    assert np.abs(K @ np.ones(40)).max() < 1e-12 * np.abs(K).max()


def test_the_energy_of_the_coordinates_is_twice_the_area():
    vertices, faces = zoo.icosphere(2)
    energy = np.sum(vertices * (cotangent_laplacian(glued(vertices, faces)) @ vertices))
    assert energy == pytest.approx(2 * area(PolyhedralMetric.from_mesh(vertices, faces)), rel=1e-13)


def test_it_is_the_derivative_of_the_deficits():
    metric = glued(*zoo.random_hull(30, 1))
    K = cotangent_laplacian(metric)
    u = np.random.default_rng(0).normal(size=30)
    h = 1e-6
    change = (equivalent(metric, h * u).deficits - equivalent(metric, -h * u).deficits) / (2 * h)
    assert change == pytest.approx(K @ u, abs=1e-7 * np.abs(K @ u).max())


def test_weights_are_raised_edge_by_edge():
    metric = glued(*zoo.random_hull(40, 2))
    K, raised = cotangent_laplacian(metric).toarray(), cotangent_laplacian(metric, least=0.3).toarray()
    joined = ~np.eye(40, dtype=bool) & (K != 0)
    assert (-K[joined]).min() < 0.3 < (-K[joined]).max()
    assert -raised[joined] == pytest.approx(np.maximum(-K[joined], 0.3), rel=1e-12)
    assert np.abs(raised.sum(axis=1)).max() < 1e-11


@pytest.mark.parametrize("k", [-1.0, 0.7])
def test_the_derivative_of_the_deficits_in_curved_spaces(k):
    x, faces, _ = body(30, 1, k, 2.0)
    metric = GluedMetric.of(PolyhedralMetric.from_mesh(x, faces, curvature=k))
    H = deficit_laplacian(metric)
    u = np.random.default_rng(0).normal(size=30)
    h = 1e-6
    change = (equivalent(metric, h * u).deficits - equivalent(metric, -h * u).deficits) / (2 * h)
    assert change == pytest.approx(H @ u, abs=1e-7 * np.abs(H @ u).max())
    assert np.abs(H - H.T).max() < 1e-13 * np.abs(H).max()


def test_in_the_plane_both_laplacians_are_one():
    metric = glued(*zoo.random_hull(40, 0))
    assert (cotangent_laplacian(metric) != deficit_laplacian(metric)).nnz == 0
