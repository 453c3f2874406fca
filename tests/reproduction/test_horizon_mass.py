"""The mass of Kerr horizons in hyperbolic space: printed numbers, and numbers of other computations."""

import pytest

from reproduction import horizon_mass
from sections import check_section


@pytest.mark.parametrize(
    ("spin", "mass"),
    [  # quadratures of the closed form
        (0.0, 2.0),
        (horizon_mass.LIMIT, 1.7656917209184877),
        (0.9, 1.8343379378),
        (0.95, 1.9343168808),
        (0.99, 2.0102107853),
        (1.0, 2.019656395202),
    ],
)
def test_masses(spin, mass):
    assert horizon_mass.Horizon(spin).mass == pytest.approx(mass, abs=1e-10)
    if spin >= horizon_mass.LIMIT:
        assert horizon_mass.mass_by_quadrature(spin) == pytest.approx(mass, abs=1e-10)


def test_the_greatest_mass():
    peak = horizon_mass.greatest()
    assert peak.spin == pytest.approx(0.99906997, abs=1e-7)
    assert peak.mass == pytest.approx(2.0222306427, abs=1e-10)


def test_polyhedra_in_hyperbolic_space_have_the_mass_to_second_order_and_better():
    horizon = horizon_mass.Horizon(0.9)
    (rough, near), (fine, nearer) = (horizon.by_lengths(n) for n in (300, 1200))
    assert (horizon.mass - rough) / (horizon.mass - fine) == pytest.approx(4, rel=0.25)
    assert abs(near - horizon.mass) < 0.2 * abs(rough - horizon.mass)
    assert abs(nearer - horizon.mass) < 0.1 * abs(fine - horizon.mass)


def test_the_cone_of_the_strut_is_refused_by_its_angle():
    found = horizon_mass.static_pair(1.0)
    assert found["angle"] == pytest.approx(1.8, rel=1e-14)
    assert f"q_tt sin^2(theta) / q_pp = {1 / 1.8**2:.9g} there, not 1" in found["refusal"]
    assert horizon_mass.static_pair(1e4)["angle"] == pytest.approx(1, abs=1e-6)


@pytest.mark.slow
def test_the_section(monkeypatch):
    # Harmonics take long, and have tests of their own (relativity/energies/test_embedded_in_space.py).
    monkeypatch.setattr(horizon_mass.Horizon, "by_harmonics", lambda self: self.mass)
    section = horizon_mass.study(spins=(0.95,), charged=2, vertices=200)
    check_section(section)
    assert all(one["agrees"] is not False for one in section.numbers["published"])
    for one in section.numbers["published"]:
        assert one["ours"] == pytest.approx(one["second"], abs=5 * one["error"])
    assert section.numbers["charged"]["embedded"] == 4
