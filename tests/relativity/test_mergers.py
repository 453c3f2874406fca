"""Horizons without symmetry about z, found and embedded, against numbers of other computations.

Those of two black holes at rest are by shooting (benchmarks/mergers_horizons.py), those of
Kerr by a closed form.
"""

import numpy as np
import pytest

from isoembed import NotEmbedded
from isoembed.relativity import (
    BrillLindquist,
    KerrNewmanHorizon,
    KerrSchild,
    StarSurface,
    embed_surface,
    find_horizon,
)

AXIS = np.array([0.36, 0.48, 0.8]) * np.sin(0.7) + np.array([0.0, 0.0, 1.0]) * np.cos(0.7)
AXIS /= np.linalg.norm(AXIS)
ORIGIN = np.array([0.3, -0.2, 0.1])
PAIRS = {  # masses, distance: irreducible mass, int k0 dA / 8 pi
    "outer, d = 0.5": ((0.5, 0.5), 0.5, 0.998248418037, 2.019209822459),
    "unequal": ((0.2, 0.8), 0.5, 0.999007214153, 2.013827145237),
    "merging": ((0.5, 0.5), 0.765, 0.988481602598, 2.184098577277),
}


def pair(masses, distance):
    return BrillLindquist(masses, [ORIGIN + side * 0.5 * distance * AXIS for side in (1.0, -1.0)])


def kerr(a):
    slice_ = KerrSchild(1.0, a * AXIS)
    return StarSurface.from_radius(slice_.spheroid(slice_.horizon)).data(slice_, marginal=True)


@pytest.mark.parametrize(
    ("name", "accuracy"),
    [
        ("outer, d = 0.5", 1e-11),
        pytest.param("unequal", 1e-11, marks=pytest.mark.slow),
        pytest.param("merging", 1e-8, marks=pytest.mark.slow),
    ],
)
def test_common_horizons_have_the_energies_of_another_computation(name, accuracy):
    masses, distance, irreducible, kly = PAIRS[name]
    found = embed_surface(find_horizon(pair(masses, distance)).data()).energies
    assert found.irreducible_mass.value == pytest.approx(irreducible, rel=2e-12)
    off = abs(found.liu_yau.value - kly)
    assert off <= accuracy * kly
    assert off <= found.liu_yau.error + 1e-12 * kly  # of the digits above


@pytest.mark.slow
def test_a_horizon_that_nearly_has_none_is_embedded():
    energies = embed_surface(kerr(0.86)).energies
    truth = KerrNewmanHorizon(1.0, 0.86).profile().integrated_mean_curvature
    off = abs(energies.integrated_mean_curvature.value - truth)
    assert off <= 1e-9 * truth
    assert off <= energies.integrated_mean_curvature.error


@pytest.mark.slow
@pytest.mark.parametrize("spin", [0.87, 0.9])
def test_beyond_smarrs_limit_no_axis_embeds_a_horizon(spin):
    with pytest.raises(NotEmbedded, match="no surface of revolution has this metric"):
        embed_surface(kerr(spin))
