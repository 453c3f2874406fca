"""Discretized surfaces: what they know of a slice is not computed again."""

import numpy as np

from isoembed.relativity.horizons.radial_image import discretized
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.smooth.harmonics import Harmonics


def test_errors_of_an_exact_slice_are_zero_without_another_evaluation(monkeypatch):
    harmonics = Harmonics(4, 4)
    f = np.eye(harmonics.size)[0]
    discretization = discretized(IsotropicSchwarzschild(0.1), StarSurface((0.0, 0.0, 0.0), harmonics, f))
    at = discretization.iterate(f)
    monkeypatch.setattr(IsotropicSchwarzschild, "metric", None)
    assert (discretization.expansion_errors(at) == np.zeros(len(discretization.transform.u))).all()
