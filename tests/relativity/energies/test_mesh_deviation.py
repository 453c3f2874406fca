"""Standard deviations of energies, against energies of surfaces whose lengths have random errors."""

import numpy as np
import pytest

from isoembed import Embedding
from isoembed.errors import InvalidParameter
from isoembed.gallery import Ellipsoid
from isoembed.relativity import mesh_deviation, mesh_energies
from isoembed.surface.rigidity import LengthSystem
from noisy import realized, surface

NAMES = ("area", "integrated_mean_curvature", "irreducible_mass", "hawking", "brown_york", "liu_yau")


@pytest.mark.slow
def test_a_hundred_noises():
    found, s, k = surface(Ellipsoid((1.5, 1.2, 1.0)), 100), 1e-7, np.full(100, 1.4)
    sigma = mesh_deviation(found, s, k, lengths="chord")
    assert sigma["christodoulou_mass"] is None and "notes" not in sigma
    rng, system = np.random.default_rng(1), LengthSystem(found.triangulation)
    exact, changes = mesh_energies(found, k, lengths="chord").report, []
    for _ in range(100):
        lengths = found.metric.lengths + s * rng.standard_normal(len(found.metric.lengths))
        noisy = Embedding(
            found.metric.with_lengths(lengths),
            realized(found, system, lengths),
            method="given",
            tolerance=1e-10,
        )
        other = mesh_energies(noisy, k, lengths="chord").report
        changes.append([other[name] - exact[name] for name in NAMES])
    spread = np.sqrt(np.mean(np.square(changes), axis=0))
    assert np.allclose(spread, [sigma[name] for name in NAMES], rtol=0.4)


def test_twice_the_errors():
    found = surface(Ellipsoid((1.5, 1.2, 1.0)), 60)
    one, two = (mesh_deviation(found, s) for s in (1e-5, 2e-5))
    assert one["hawking"] is None
    for name in ("area", "integrated_mean_curvature", "irreducible_mass"):
        assert np.isclose(two[name], 2 * one[name], rtol=1e-3)
    assert set(mesh_deviation(found, 0.0).values()) == {0.0, None}
    with pytest.raises(InvalidParameter, match=r"the error of edge 0 is -1\.0"):
        mesh_deviation(found, -1)
