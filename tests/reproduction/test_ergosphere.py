"""The ergosphere and its epsilon."""

import numpy as np
import pytest

from isoembed.gallery import Ergosphere
from reproduction import ergosphere


def test_from_which_epsilon_on_the_ergosphere_is_convex():
    epsilon, theta = ergosphere.convex_from()
    assert epsilon == pytest.approx(1.2977301304924984, abs=1e-8)  # a second computation, in long doubles
    u = [[np.sin(theta), 0, np.cos(theta)]]
    assert Ergosphere(epsilon=epsilon).gaussian_curvature(u)[0] == pytest.approx(0, abs=1e-9)
    assert Ergosphere(epsilon=epsilon - 0.01).gaussian_curvature(u)[0] < 0
    assert min(ergosphere.least_under_root()) > 3


def test_an_ergosphere_with_negative_curvature_embeds(monkeypatch):
    monkeypatch.setattr(ergosphere, "MORE", ())
    section = ergosphere.study(vertices=150, epsilons=(0.3, 1.5))
    first, last = section.numbers["cases"]
    assert first["K_least"] < 0 < last["K_least"]
    for case in (first, last):
        assert case["outcomes"]["default"]["residual"] < 1e-6
        assert abs(case["percent_error"]) < 3
