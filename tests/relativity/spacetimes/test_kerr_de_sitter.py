"""Spheres of Kerr's black hole with a cosmological constant: closed forms, limits, refusals."""

from math import pi, sqrt

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.kerr import KerrNewmanHorizon, KerrNewmanSphere
from isoembed.relativity.spacetimes.kerr_de_sitter import KerrDeSitterSphere, horizon_radii
from isoembed.smooth.two_metric import area_density

U, WEIGHTS = gauss_rule(80, 1)
ZOO = [
    KerrDeSitterSphere(3.0, 1.0, 0.5, -3.0),
    KerrDeSitterSphere(7.0, 2.0, -1.1, -0.2),
    KerrDeSitterSphere(4.0, 1.0, 0.9, 0.05),
    KerrDeSitterSphere.horizon(1.0, 0.7, -1.0),
]


def integral(surface, values):
    return float(WEIGHTS * area_density(surface.tensor(U)) @ values)


def test_without_a_cosmological_constant_they_are_those_of_kerr():
    for ours, kerr in (
        (KerrDeSitterSphere(3.0, 1.2, 0.9), KerrNewmanSphere(3.0, 1.2, 0.9)),
        (KerrDeSitterSphere.horizon(1.2, 0.9), KerrNewmanHorizon(1.2, 0.9)),
    ):
        np.testing.assert_allclose(ours.tensor(U), kerr.tensor(U), rtol=1e-13, atol=1e-14)
        np.testing.assert_allclose(ours.mean_curvature(U), kerr.mean_curvature(U), rtol=1e-13)
        np.testing.assert_allclose(ours.normal_momentum(U), kerr.normal_momentum(U), rtol=1e-12, atol=1e-15)
        assert ours.angular_momentum == pytest.approx(kerr.angular_momentum, rel=1e-15)
    assert not ours.data().notes and ours.data().marginal


@pytest.mark.parametrize("constant", [-3.0, -0.01, 0.03])
def test_without_spin_they_are_round(constant):
    sphere = KerrDeSitterSphere(3.0, 1.0, 0.0, constant)
    f = 1.0 - 2.0 / 3.0 - constant * 9.0 / 3.0
    np.testing.assert_allclose(area_density(sphere.tensor(U)), 9.0, rtol=1e-14)
    np.testing.assert_allclose(sphere.mean_curvature(U), 2.0 / 3.0 * sqrt(f), rtol=1e-13)
    assert sphere.angular_momentum == 0.0 and sphere.data().normal_momentum is None


@pytest.mark.parametrize("sphere", ZOO[:3], ids=str)
def test_k_is_the_first_variation_of_area(sphere):
    h = 2e-3
    areas = {
        i: integral(KerrDeSitterSphere(sphere.r + i * h, *list(vars(sphere).values())[1:4]), np.ones(80))
        for i in (-2, -1, 1, 2)
    }
    differences = (8.0 * (areas[1] - areas[-1]) - (areas[2] - areas[-2])) / (12.0 * h)
    r, m, a, lam = sphere.r, sphere.mass, sphere.spin, sphere.cosmological_constant / 3.0
    Sigma = r * r + a * a * U[:, 2] ** 2
    Delta = (r * r + a * a) * (1.0 - lam * r * r) - 2.0 * m * r
    moved = integral(sphere, sphere.mean_curvature(U) * np.sqrt(Sigma / Delta))
    assert moved == pytest.approx(differences, rel=1e-9)


@pytest.mark.parametrize("sphere", ZOO, ids=str)
def test_every_sphere_has_the_angular_momentum(sphere):
    around = np.stack([-U[:, 1], U[:, 0], np.zeros(len(U))], axis=1)
    found = integral(sphere, np.sum(sphere.normal_momentum(U) * around, axis=1)) / (8.0 * pi)
    assert found == pytest.approx(sphere.angular_momentum, rel=1e-12)


def test_horizons():
    for m, a, constant in ((1.0, 0.7, -1.0), (2.0, -1.5, 0.02), (1.0, 0.0, 0.11)):
        sphere = KerrDeSitterSphere.horizon(m, a, constant)
        r, lam = sphere.r, constant / 3.0
        assert (r * r + a * a) * (1.0 - lam * r * r) == pytest.approx(2.0 * m * r, rel=1e-14)
        assert np.all(sphere.mean_curvature(U) == 0.0) and sphere.data().marginal
        area = 4.0 * pi * (r * r + a * a) / (1.0 + lam * a * a)
        assert integral(sphere, np.ones(80)) == pytest.approx(area, rel=1e-13)
    assert horizon_radii(1.0, 1.0, 0.0)[0] == pytest.approx(1.0, abs=1e-7)
    least, most = horizon_radii(1.0, 0.0, 0.1)
    assert 2.0 < least < 3.0 < most < sqrt(30.0)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((3.0, 1.0, 2.0, -3.0), "spin must be below 1, the radius"),
        ((3.0, 1.0, 1.1, 0.0), "there is no horizon for"),
        ((3.0, 1.0, 0.0, 0.2), "there is no horizon for"),
        ((1.0, 1.0, 0.5, -0.3), "at least r_. = 1.47"),
        ((9.0, 1.0, 0.0, 0.1), "and at most the cosmological horizon.s 3.73"),
        ((3.0, -1.0, 0.0, 0.1), "mass must be positive"),
        ((3.0, 1.0, np.nan, 0.1), "spin must be finite"),
    ],
)
def test_refusals(arguments, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        KerrDeSitterSphere(*arguments)
