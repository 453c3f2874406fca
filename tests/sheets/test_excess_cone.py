"""A cone with too much angle against the elastic curve on the sphere that it is the cone over."""

import numpy as np
import pytest

from excess_cone import cone_metric, elastic_curve
from isoembed import embed


@pytest.mark.parametrize("waves", [2, 3, 4])
def test_elastic_curves_of_small_surplus(waves):
    """A circle with waves of small height: int k^2 ds is 2 (n^2 - 1) times the surplus."""
    assert elastic_curve(1e-3, waves)[0] == pytest.approx(2 * (waves**2 - 1) * 1e-3, rel=2e-3)


def test_the_energy_grows_with_the_logarithm_of_the_radius():
    energies, [height, angle] = [], elastic_curve(1.0)
    for rings in (6, 12):
        metric, start = cone_metric(rings, 1.0)
        found = embed(metric, boundary="free", start=start)
        assert found.residual < 1e-13 and found.imbalance < 1e-8
        energies.append(found.second_form_energy)
    assert (energies[1] - energies[0]) / np.log(2) == pytest.approx(height, rel=0.05)
    rim = found.vertices[metric.triangulation.boundaries[0]] - found.vertices[0]
    axis = np.cross(rim, np.roll(rim, -1, axis=0)).sum(axis=0)
    heights = np.arcsin(rim @ axis / np.linalg.norm(axis))
    assert heights.max() == pytest.approx(angle, abs=np.radians(0.3))
    assert heights.min() == pytest.approx(-angle, abs=np.radians(0.3))
