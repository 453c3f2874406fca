"""The Wang-Yau energy of spheres about holes that move: that of the hole at rest, in any unit."""

from functools import cache

import numpy as np
import pytest

from isoembed.relativity import BoostedSchwarzschild, StarSurface, wang_yau
from isoembed.relativity.energies import wang_yau_search
from isoembed.smooth import embed_smooth

EAST = np.sqrt(4.0 * np.pi / 3.0)  # times the harmonic of degree 1 is z


@pytest.fixture(autouse=True)
def few_harmonics(monkeypatch):
    """Fewer harmonics of X than by default, which are enough here."""
    monkeypatch.setattr(wang_yau_search, "DEGREES", (12, 12))


@pytest.mark.parametrize(
    ("R", "resting", "least"),
    [
        (10.0, 1.21576, 1.04726),
        pytest.param(100.0, 1.24423, 1.00473, marks=pytest.mark.slow),
        pytest.param(1000.0, 1.24939, 1.00047, marks=pytest.mark.slow),
    ],
)
def test_moving_hole(R, resting, least):
    # Of energy 1.25 M; the least is that which it has at rest.
    data = StarSurface.sphere((0, 0, 0), R).data(BoostedSchwarzschild(1.0, (0.0, 0.0, 0.6)))
    embedding = embed_smooth(data.metric, vertices=100)
    still = wang_yau(data, embedding=embedding)
    assert still.energy.value == pytest.approx(resting, abs=6e-6)
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(2, 4))
    assert found.energy.value == pytest.approx(least, abs=6e-6)
    assert found.energy.error < 1e-3
    assert found.least_second_derivative > 0.0
    # Far from the hole: the time of the hole, W (t - v z), less that on the slice.
    assert found.tau.coefficients[1] / (R * EAST) == pytest.approx(-0.75, abs=1.0 / R)


@cache
def tilted(unit):
    """The least energy of a hole that moves in no special direction."""
    hole = BoostedSchwarzschild(unit, (0.0, 0.36, 0.48))
    data = StarSurface.sphere((0, 0, 0), 10.0 * unit).data(hole)
    embedding = embed_smooth(data.metric, vertices=100)
    return wang_yau(data, "optimal", embedding=embedding, degrees=(1,))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
@pytest.mark.slow
def test_units_are_free(unit):
    one, other = tilted(1.0), tilted(unit)
    assert other.energy.value == pytest.approx(unit * one.energy.value, rel=1e-12)
    assert abs(other.embeddings - one.embeddings) <= 3  # where rounding ends the search
    assert other.admissible * unit**2 == pytest.approx(one.admissible, rel=1e-6)
    np.testing.assert_allclose(other.tau.coefficients / unit, one.tau.coefficients, atol=1e-5)
