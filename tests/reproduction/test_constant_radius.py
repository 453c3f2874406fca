"""Surfaces of constant radius in Kerr spacetime."""

import numpy as np
import pytest

from isoembed.relativity import KerrNewmanSphere
from reproduction import constant_radius
from sections import check_section


@pytest.mark.parametrize(("a", "r"), [(0.3, 2.0), (1.0, 2.0), (1.0, 1.2), (0.9, 1.5)])
def test_the_curvature_of_the_poles_in_closed_form(a, r):
    found = KerrNewmanSphere(r, spin=a).gaussian_curvature(np.array([[0.0, 0.0, 1.0]]))
    assert found == pytest.approx(constant_radius.pole_curvature(a, r), abs=1e-13)


def test_surfaces_embed_from_the_root_of_the_cubic_on():
    r = constant_radius.first_radius(0.95)
    assert r == pytest.approx(1.5853152443718086, abs=1e-12)
    assert KerrNewmanSphere(r + 1e-4, spin=0.95).profile().embeds
    assert not KerrNewmanSphere(r - 1e-4, spin=0.95).profile().embeds


def test_the_squared_norm_of_spheres_in_schwarzschild():
    r = 1.5
    found = constant_radius.squared_norm(0.0, r, np.linspace(-1, 1, 5))
    assert found == pytest.approx(np.full(5, 4 / r**2 * (1 - 2 / r)), rel=1e-14)


@pytest.mark.slow
def test_the_section(monkeypatch):
    monkeypatch.setattr(constant_radius, "WITHIN", ((0.0, 1.5), (0.6, 1.4)))
    section = constant_radius.study(spins=3, vertices=150, radii=(2.0, 5.0))
    check_section(section)
    numbers = section.numbers
    assert all(one["embeds"] for one in numbers["outside"])
    assert min(one["curvature"] for one in numbers["outside"]) == pytest.approx(4 * 8 / 125)
    assert all(one["certified"] for one in numbers["polyhedra"])
    assert all(one["refused"] and one["off"] < 1e-11 for one in numbers["within"])
    assert numbers["within"][0]["hawking"] == pytest.approx(1, abs=1e-12)  # the mass, in Schwarzschild
    for one in numbers["energies"]:
        assert one["wang_yau"] == pytest.approx(one["brown_york"], abs=1e-12)
        assert one["second"] > 0
