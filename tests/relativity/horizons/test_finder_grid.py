"""Horizons in slices on Cartesian grids: rates of convergence, and errors that hold."""

import numpy as np
import pytest

from gridded import sampled
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.finder import find_horizon
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.star_surface import StarSurface

KERR = KerrSchild(1.0, (0.2, 0.3, 0.3))
EXACT = StarSurface.from_radius(KERR.spheroid(KERR.horizon))


@pytest.mark.slow
def test_kerr_on_three_grids():
    u, _ = gauss_rule(12, 24)
    errors = []
    for n in (24, 36, 54):
        horizon = find_horizon(sampled(KERR, n, 3.0))
        off = np.linalg.norm(horizon.surface.points(u) - EXACT.points(u), axis=1)
        error = abs(horizon.irreducible_mass - np.sqrt(0.5 * KERR.horizon))
        errors.append([off.max(), error])
        assert np.sqrt(np.mean(off**2)) < horizon.surface.misfit
        assert error < horizon.data().lengths_error.mean
    rates = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(1.5)
    assert rates.min() > 5.0
