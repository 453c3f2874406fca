"""Convergence of int H dA."""

import numpy as np
import pytest

from isoembed import Paper, PolyhedralMetric
from isoembed.gallery import Drum
from reproduction import mean_curvature
from zoo import icosphere


def test_the_integral_of_h_converges_like_one_over_n():
    found = mean_curvature.convergence(Drum(), (150, 300, 600), Paper())
    assert found.order(found.embedded) == pytest.approx(-1, abs=0.1)
    assert np.allclose(found.embedded, found.exact, atol=1e-6)
    assert (np.abs(found.corrected) < 0.1 * np.abs(found.embedded)).all()
    assert np.all(found.embedded < 0)  # inscribed
    n = found.vertices_for(found.embedded, abs(found.embedded[1]))
    assert n == pytest.approx(300, rel=0.1)


def test_the_cotangent_integral_of_a_sphere():
    errors = []
    for level in (2, 3):
        vertices, faces = icosphere(level)
        found = mean_curvature.cotangent_integral(PolyhedralMetric.from_mesh(vertices, faces), vertices)
        errors.append(1 - found / (4 * np.pi))
    assert 0 < errors[1] < errors[0] < 0.03
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
