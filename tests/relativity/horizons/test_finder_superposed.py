"""Horizons of moving holes without any symmetry."""

import numpy as np
import pytest

from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.finder import find_horizons
from isoembed.relativity.spacetimes.schwarzschild import BoostedSchwarzschild, BrillLindquist, Superposed


@pytest.mark.slow
def test_two_holes_in_motion():
    first = BoostedSchwarzschild(0.5, (0.2, 0.1, 0.0), (2.0, 0.05, 0.0))
    second = BoostedSchwarzschild(0.4, (0.0, 0.1, -0.3), (-2.0, 0.0, 0.1))
    horizons = find_horizons(Superposed((first, second)))
    u, _ = gauss_rule(15, 31)
    assert [np.abs(h.surface.expansion(h.geometry, u)).max() < 1e-11 for h in horizons] == [True, True]
    assert [h.irreducible_mass for h in horizons] == pytest.approx([0.5, 0.4], rel=0.02)


@pytest.mark.slow
def test_three_holes_of_which_two_have_a_common_horizon():
    holes = BrillLindquist((0.3, 0.3, 0.4), ((0.1, 0.0, 0.0), (-0.1, 0.0, 0.0), (0.0, 3.0, 0.0)))
    common, single = find_horizons(holes)
    assert np.linalg.norm(common.surface.center) < 0.1
    assert single.surface.center[1] == pytest.approx(3.0, abs=0.02)
