"""Stability spectra: closed forms, Kerr by its isolated horizon, finite differences, grids."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eig

from isoembed.errors import InvalidParameter
from isoembed.relativity.horizons import expansion_operator
from isoembed.relativity.horizons.finder import constant_expansion, find_horizon, inner_horizon
from isoembed.relativity.horizons.stability_spectrum import spectrum_lines, stability_spectrum
from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid
from isoembed.relativity.spacetimes.kerr import KerrNewmanHorizon
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import (
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.smooth.harmonics import Harmonics


def pair(d, masses=(0.5, 0.5)):
    return BrillLindquist(masses, ((0.0, 0.0, 0.5 * d), (0.0, 0.0, -0.5 * d)))


def kerr_by_its_horizon(spin, order, degree=40):
    """Eigenvalues of order m times R^2 from ``-Laplacian + 2 s^A D_A + K - s^2`` (s = K(., n), no shear).

    By Galerkin's method for the closed forms of the metric and of s in Boyer-Lindquist coordinates; another
    slice only changes s by a gradient, and the eigenvalues not at all.
    """
    hole, m = KerrNewmanHorizon(1.0, spin), abs(order)
    x, w = legendre.leggauss(2 * degree)
    sin = np.sqrt(1.0 - x * x)
    u, zero = np.stack([sin, 0.0 * x, x], axis=1), 0.0 * x
    q, e_theta = hole.tensor(u), np.stack([x, zero, -sin], axis=1)
    tt, pp = np.einsum("ni,nij,nj->n", e_theta, q, e_theta), q[:, 1, 1]  # along unit vectors
    s = hole.normal_momentum(u)[:, 1]
    P = legendre.legvander(x, degree)
    D = np.stack([legendre.legval(x, legendre.legder(row)) for row in np.eye(degree + 1)], axis=1)
    f = sin[:, None] ** m * P
    slope = -sin[:, None] * sin[:, None] ** m * D + (m * x * sin ** max(m - 1, 0))[:, None] * P  # along theta
    dA = w * np.sqrt(tt * pp)
    around = 1j * order * (sin ** max(m - 1, 0))[:, None] * P  # along phi; only for m > 0
    A = slope.T @ ((dA / tt)[:, None] * slope) + around.conj().T @ ((dA / pp)[:, None] * around)
    A = A + f.T @ ((2.0 * dA * s / pp)[:, None] * around)
    A = A + f.T @ ((dA * (hole.gaussian_curvature(u) - s * s / pp))[:, None] * f)
    values = eig(A, f.T @ (dA[:, None] * f), right=False) * hole.area / (4.0 * np.pi)
    return values[np.argsort(values.real)]


def test_a_round_sphere_at_a_moment_of_time_symmetry():
    spectrum = stability_spectrum(find_horizon(IsotropicSchwarzschild(2.0)), 16)
    exact = np.repeat([1.0, 3.0, 7.0, 13.0], [1, 3, 5, 7])
    assert spectrum.values == pytest.approx(exact, abs=1e-10)
    assert np.all(np.abs(spectrum.values - exact) <= spectrum.errors)
    assert spectrum.orders.tolist()[:4] == [0, 0, 1, -1]
    assert spectrum.areal_radius == pytest.approx(4.0)


def test_a_round_sphere_of_constant_expansion():
    # k - p = 2/r (1 - sqrt(2 M / r)); of the change with r the mode l = 0 is left
    surface = constant_expansion(PainleveGullstrand(1.0), 0.01, StarSurface.sphere((0.0, 0.0, 0.0), 2.1))
    r = surface.surface.mean_radius
    rate = r * r * (-2.0 / r**2 + 3.0 * np.sqrt(2.0) / r**2.5)
    assert stability_spectrum(surface, 4).values == pytest.approx([rate, *[rate + 2.0] * 3], abs=1e-10)


def test_kerr_against_the_operator_of_its_isolated_horizon():
    spectrum = stability_spectrum(find_horizon(KerrSchild(1.0, (0.0, 0.0, 0.9))), 12)
    assert len(spectrum.values) == 13  # rather than half of a pair
    for m in range(-3, 4):
        found = spectrum.values[spectrum.orders == m]
        exact = kerr_by_its_horizon(0.9, m)[: len(found)]
        either = exact if np.abs(found - exact).max() < np.abs(found - exact.conj()).max() else exact.conj()
        assert len(found)
        assert np.all(np.abs(found - either) <= spectrum.errors[spectrum.orders == m])
        assert np.all((np.abs(found.imag) > 0.1) == (m != 0))


def test_the_axis_does_not_matter():
    upright = stability_spectrum(find_horizon(KerrSchild(1.0, (0.0, 0.0, 0.6))), 6)
    tilted = stability_spectrum(find_horizon(KerrSchild(1.0, (0.36, 0.0, 0.48))), 6)
    assert tilted.orders is None
    assert tilted.values == pytest.approx(upright.values, abs=1e-10)


def test_finite_differences_of_the_expansion():
    horizon = find_horizon(pair(0.7))
    spectrum, surface = stability_spectrum(horizon, 8), horizon.surface
    x, w = legendre.leggauss(64)
    u = np.stack([np.sqrt(1.0 - x * x), 0.0 * x, x], axis=1)
    r, slope, _ = surface.harmonics.derivatives(u, surface.coefficients)
    psi = np.sqrt(np.sqrt(horizon.geometry.metric(u * r[:, None])[:, 0, 0]))
    tilt = psi**2 * r / np.sqrt(r**2 + np.sum(slope**2, axis=1))
    Y = Harmonics(30, 0).values(u)
    step = 1e-5
    change = np.empty_like(Y)
    for l in range(31):
        moved = np.zeros(surface.harmonics.size)
        moved[l] = step
        out, into = (
            StarSurface(surface.center, surface.harmonics, surface.coefficients + sign * moved)
            for sign in (1.0, -1.0)
        )
        change[:, l] = (out.expansion(horizon.geometry, u) - into.expansion(horizon.geometry, u)) / (
            2.0 * step
        )
    weighted = (w * r * r * psi**4)[:, None] * Y
    values = np.sort(eig(weighted.T @ change, weighted.T @ (tilt[:, None] * Y), right=False).real)
    found = spectrum.values[spectrum.orders == 0] / spectrum.areal_radius**2
    assert found == pytest.approx(values[: len(found)], abs=1e-6)


def test_the_published_number_of_a_common_horizon():
    # Area and principal eigenvalue, in 1/length^2, of the tutorial of MOTSFinder (Pook-Kolb et al. 2019).
    near = StarSurface.sphere((0.0, 0.0, -0.195), 1.0)
    spectrum = stability_spectrum(horizon := find_horizon(pair(0.65, (0.2, 0.8)), near), 1)
    assert horizon.area == pytest.approx(49.8984892225, abs=1e-9)
    assert spectrum.values[0] / spectrum.areal_radius**2 == pytest.approx(0.18263, abs=5e-6)
    assert spectrum.values[0] == pytest.approx(horizon.stability, abs=1e-10)


def test_an_inner_horizon_that_is_a_mapped_surface():
    inner = inner_horizon(find_horizon(pair(0.7)))
    spectrum = stability_spectrum(inner, 3)
    assert spectrum.values[0] == pytest.approx(inner.stability, abs=1e-9)
    assert spectrum.values.real[1] > 0.0


def test_errors_of_a_slice_on_a_grid():
    n, size, hole = 24, 2.7, PainleveGullstrand(1.0)
    x = np.stack(np.meshgrid(*[np.linspace(-size, size, n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    gamma, K = (
        field(x).reshape(n, n, n, 3, 3).transpose(3, 4, 0, 1, 2)
        for field in (hole.metric, hole.extrinsic_curvature)
    )
    grid = CartesianGrid((-size,) * 3, 2.0 * size / (n - 1), gamma, K)
    spectrum = stability_spectrum(find_horizon(grid, StarSurface.sphere((0.0, 0.0, 0.0), 2.0)), 4)
    off = np.abs(spectrum.values - [1.0, 3.0, 3.0, 3.0])
    assert np.all(off <= spectrum.errors)
    assert np.all(spectrum.errors <= 0.05)


def test_errors_hold_those_of_the_differences_along_the_displacement(monkeypatch):
    horizon = find_horizon(pair(0.5, (0.1, 0.9)), StarSurface.sphere((0.0, 0.0, -0.2), 1.0))
    spectrum = stability_spectrum(horizon, 4)
    step = expansion_operator.STEP
    monkeypatch.setattr(expansion_operator, "STEP", 0.25 * step)
    off = np.abs(spectrum.values - stability_spectrum(horizon, 4).values)
    assert off.max() > 1e-11 and np.all(off <= spectrum.errors) and spectrum.errors.max() < 1e-8


def test_what_is_printed():
    spectrum = stability_spectrum(find_horizon(KerrSchild(1.0, (0.0, 0.0, 0.6))), 2)
    head, first, second, third = spectrum_lines(spectrum.report)
    assert head.endswith("R = 1.897366596:")
    assert first.startswith("  0.844373763698 +- 1e-11, m = 0")
    assert second.startswith("  2.81896914675 + 0.918661043343 i")
    assert third.endswith("m = 1")


def test_refusals():
    horizon = find_horizon(IsotropicSchwarzschild(1.0))
    with pytest.raises(InvalidParameter, match="not a FoundHorizon"):
        stability_spectrum(horizon.surface, 3)
    with pytest.raises(InvalidParameter, match="eigenvalues must be at least 1, not 0"):
        stability_spectrum(horizon, 0)
    with pytest.raises(InvalidParameter, match=r"must be an integer, not 2\.5"):
        stability_spectrum(horizon, 2.5)
