"""Multipoles (l, m): conformal metrics that are known, Kerr in closed form, and other coordinates."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import quad

from isoembed.errors import InvalidParameter
from isoembed.relativity.horizons.conformal_multipoles import conformal_multipoles, multipole_lines
from isoembed.relativity.horizons.finder import find_horizon
from isoembed.relativity.spacetimes.kerr import KerrNewmanHorizon
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import BrillLindquist
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_map import SphereMap

FOUR = Harmonics(4, 4)


@dataclass
class Conformal:
    """The metric exp(2 sigma) times that of a sphere of radius 3."""

    sigma: np.ndarray

    def tensor(self, u):
        scale = 9.0 * np.exp(2.0 * FOUR.values(u) @ self.sigma)
        return scale[:, None, None] * (np.eye(3) - u[:, :, None] * u[:, None, :])


def even(seed):
    """Coefficients of the degrees 2 and 4: the metric has no area dipole in its own directions."""
    c = np.random.default_rng(seed).normal(size=FOUR.size) * 0.05
    return np.where(np.isin(FOUR.labels[0], [2, 4]), c, 0.0)


def moments(c):
    """``l (l + 1) / 2`` times the complex moments of a function, [l, m]."""
    table = np.zeros((5, 5), dtype=complex)
    for value, l, m in zip(c, *FOUR.labels, strict=True):
        phase = 1.0 if m == 0 else (-1.0) ** m / np.sqrt(2.0)
        table[l, abs(m)] += 0.5 * l * (l + 1) * phase * value * (1j if m < 0 else 1.0)
    return table


def powers(estimates):
    return np.array([e.value for e in estimates]), np.array([e.error for e in estimates])


def kerr_by_its_conformal_angle(spin, order):
    """I_l0 by quadrature: ``d Theta / sin Theta = sqrt(q_tt / q_pp) d theta`` on the conformal sphere."""
    hole = KerrNewmanHorizon(1.0, spin)
    area = hole.radius**2 + spin**2

    def rate(t):
        return (hole.radius**2 + (spin * np.cos(t)) ** 2) / (area * np.sin(t)) - 1.0 / np.sin(t)

    x, w = legendre.leggauss(60)
    theta = np.arccos(x)
    u = np.stack([np.sin(theta), 0.0 * x, x], axis=1)
    away = [quad(rate, 0.5 * np.pi, t, epsabs=1e-13)[0] + np.log(np.tan(0.5 * t)) for t in theta]
    P = legendre.legvander(-np.tanh(away), order)
    return (
        area * np.sqrt(np.pi * (2 * np.arange(order + 1) + 1)) / 2.0 * ((w * hole.gaussian_curvature(u)) @ P)
    )


@pytest.mark.parametrize("spin", [0.5, 0.95])
def test_kerr(spin):
    found = conformal_multipoles(KerrNewmanHorizon(1.0, spin).data())
    off = np.abs(found.shape[:, 0] - kerr_by_its_conformal_angle(spin, 8))
    assert np.all(off <= found.shape_errors) and found.shape_errors.max() < 1e-10
    for table, parity in ((found.shape, 1), (found.rotation, 0)):
        assert np.abs(table[:, 1:]).max() < 1e-12
        assert np.abs(table[parity::2]).max() < 1e-12


def test_a_conformal_metric_in_other_directions():
    sigma, chi = even(0), even(1)

    def momentum(u):  # its curl is -Laplacian chi
        return np.cross(FOUR.derivatives(u, chi)[1], u)

    own = SurfaceData(Conformal(sigma), normal_momentum=momentum, shape=lambda u: u)
    distorted = own.in_coordinates(
        SphereMap.linear(np.array([[1.05, 0.05, 0.0], [0.0, 1.0, 0.03], [0.03, 0.0, 0.97]]))
    )
    found = conformal_multipoles(distorted, 4)
    exact = moments(sigma)
    exact[0, 0] = np.sqrt(np.pi)
    assert np.all(np.abs(found.shape - exact).max(axis=1) <= found.shape_errors)
    assert np.all(np.abs(found.rotation - moments(chi)).max(axis=1) <= found.rotation_errors)
    assert max(found.shape_errors.max(), found.rotation_errors.max()) < 1e-7
    power, errors = powers(found.shape_power)
    squares = np.bincount(FOUR.labels[0], (0.5 * FOUR.labels[0] * (FOUR.labels[0] + 1) * sigma) ** 2)
    assert np.all(np.abs(power - squares)[1:] <= errors[1:])
    plain = conformal_multipoles(SurfaceData(own.metric), 4)
    assert plain.rotation is None and plain.rotation_power is None and plain.report["L"] is None
    assert powers(plain.shape_power)[0] == pytest.approx(power, abs=1e-9)  # turned otherwise


def test_a_tilted_horizon():
    upright = conformal_multipoles(KerrNewmanHorizon(1.0, 0.6).data())
    tilted = conformal_multipoles(find_horizon(KerrSchild(1.0, (0.36, 0.0, 0.48))).data())
    for name in ("shape_power", "rotation_power"):
        (exact, _), (found, errors) = powers(getattr(upright, name)), powers(getattr(tilted, name))
        assert np.all(np.abs(found - exact) <= errors + 1e-14)
    assert np.abs(tilted.shape[2, 1:3]).min() > 0.1
    # L_1m is a vector along the spin: (Re, Im of -sqrt(2) L_11, L_10).
    L = tilted.rotation[1]
    vector = np.array([-np.sqrt(2.0) * L[1].real, -np.sqrt(2.0) * L[1].imag, L[0].real])
    assert vector / np.linalg.norm(vector) == pytest.approx([0.6, 0.0, 0.8], abs=1e-10)


@pytest.mark.slow
def test_a_common_horizon_of_three_holes_about_two_centers():
    holes = BrillLindquist((0.5, 0.3, 0.4), ((0.05, 0.1, 0.1), (-0.1, 0.15, 0.0), (0.1, -0.05, -0.2)))
    horizon = find_horizon(holes, StarSurface.sphere((0.0, 0.0, 0.0), 0.6))
    found = conformal_multipoles(horizon.data(), 4)
    center = np.array(horizon.surface.center) + np.array([0.03, -0.02, 0.02])

    def radius(u):  # where rays from the other center meet the surface
        t = np.full(len(u), horizon.surface.mean_radius)
        for _ in range(60):
            w = center + t[:, None] * u - horizon.surface.center
            size = np.linalg.norm(w, axis=1)
            t = t - (size - horizon.surface.radius(w / size[:, None]))
        return t

    moved = StarSurface.from_radius(radius, center)
    other = conformal_multipoles(moved.data(holes, marginal=True), 4)
    assert np.abs(found.shape[2:4, 1:]).max() > 0.01
    assert np.all(np.abs(found.shape - other.shape).max(axis=1) <= found.shape_errors + other.shape_errors)
    assert max(found.shape_errors.max(), other.shape_errors.max()) < 1e-8


def test_errors_of_a_coarse_grid():
    exact = conformal_multipoles(KerrNewmanHorizon(1.0, 0.9).data(), 4)
    grid = SurfaceData(GridMetric.sampled(KerrNewmanHorizon(1.0, 0.9), 12, 1), marginal=True)
    found = conformal_multipoles(grid, 4)
    off = np.abs(found.shape - exact.shape).max(axis=1)
    assert np.all(off <= found.shape_errors) and off.max() > 1e-12
    assert found.shape[0, 0] == pytest.approx(np.sqrt(np.pi), rel=1e-14)


def test_the_report():
    report = conformal_multipoles(KerrNewmanHorizon(1.0, 0.6).data(), 3).report
    assert [len(row) for row in report["I"]] == [1, 2, 3, 4]
    assert report["I"][0][0] == pytest.approx([np.sqrt(np.pi), 0.0])
    assert report["L_power"][1] == pytest.approx(report["L"][1][0][0] ** 2)
    assert len(report["errors"]["I"]) == 4
    shape, rotation = multipole_lines(report)
    assert shape.startswith("sum over m of |I_lm|^2 for l = 1: ") and ", 2: 0.245432692" in shape
    assert rotation.startswith("sum over m of |L_lm|^2 for l = 1: 0.95662408")


@pytest.mark.parametrize(
    ("n", "sentence"), [(0, "must be at least 1, not 0"), (21, "must be at most 20, not 21")]
)
def test_refusals(n, sentence):
    with pytest.raises(InvalidParameter, match=f"the highest degree of multipoles {sentence}"):
        conformal_multipoles(KerrNewmanHorizon().data(), n)
