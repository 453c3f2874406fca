"""Boosted holes: Einstein's constraints, energy and momentum at infinity, K_ij by lapse and shift, units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.schwarzschild import (
    BoostedSchwarzschild,
    BrillLindquist,
    IsotropicSchwarzschild,
    Superposed,
)
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import CallableGeometry, complex_step, stationary_curvature

V = np.array([0.3, -0.4, 0.5])
HOLE = BoostedSchwarzschild(1.3, V, (0.2, 0.1, -0.3))


def outside(n=12, least=2.0, most=6.0):
    """Points between two distances from the origin, some of them on the axes."""
    u = np.concatenate([np.random.default_rng(3).normal(size=(n, 3)), np.eye(3), -np.eye(3)])
    return u / np.linalg.norm(u, axis=1, keepdims=True) * np.linspace(least, most, len(u))[:, None]


def differences(f, x, h=0.02):
    """Derivatives (n, 3, ...) of sixth order."""
    steps = ((1, 45), (2, -9), (3, 1))
    out = [sum(w * (f(x + s * e) - f(x - s * e)) for s, w in steps) / (60 * h) for e in h * np.eye(3)]
    return np.stack(out, axis=1)


def christoffel(geometry, x):
    """Gamma^i_jk (n, 3, 3, 3)."""
    d = geometry.gradient(x)
    low = 0.5 * (np.einsum("njik->nijk", d) + np.einsum("nkij->nijk", d) - d)
    return np.einsum("nil,nljk->nijk", np.linalg.inv(geometry.metric(x)), low)


def constraints(geometry, x):
    """R + K^2 - K_ij K^ij (n,) and D_j (K_i^j - delta_i^j K) (n, 3)."""

    def flux(x):
        mixed = np.linalg.solve(geometry.metric(x), geometry.extrinsic_curvature(x))  # K^j_i
        return mixed - np.trace(mixed, axis1=1, axis2=2)[:, None, None] * np.eye(3)

    inverse, K, G = (
        np.linalg.inv(geometry.metric(x)),
        geometry.extrinsic_curvature(x),
        christoffel(geometry, x),
    )
    d_christoffel = differences(lambda x: christoffel(geometry, x), x)
    ricci = np.einsum("nkkij->nij", d_christoffel) - np.einsum("njkki->nij", d_christoffel)
    ricci += np.einsum("nkkl,nlij->nij", G, G) - np.einsum("nkjl,nlki->nij", G, G)
    mixed = inverse @ K
    trace = np.einsum("nii->n", mixed)
    R = np.einsum("nij,nij->n", inverse, ricci)
    momentum = np.einsum("njji->ni", differences(flux, x))
    momentum += np.einsum("njjk,nki->ni", G, flux(x)) - np.einsum("nkji,njk->ni", G, flux(x))
    return R + trace**2 - np.einsum("nij,nji->n", mixed, mixed), momentum


def at_infinity(geometry, radius):
    """Arnowitt, Deser and Misner's energy and momentum, by integrals over a sphere."""
    n, weights = gauss_rule(16, 32)
    x, dA = radius * n, weights * radius**2
    d, K = geometry.gradient(x), geometry.extrinsic_curvature(x)
    energy = dA @ np.einsum("njij,ni->n", d, n) - dA @ np.einsum("nijj,ni->n", d, n)
    flux = np.einsum("nij,nj->ni", K, n) - np.einsum("njj->n", K)[:, None] * n
    return energy / (16 * np.pi), dA @ flux / (8 * np.pi)


def test_gradient_is_that_of_differences():
    x = outside()
    user = CallableGeometry(HOLE.metric, length=1.0)
    np.testing.assert_allclose(HOLE.gradient(x), user.gradient(x), atol=1e-11)


def test_extrinsic_curvature_from_lapse_and_shift():
    x, W2, v2 = outside(), 1.0 / (1.0 - V @ V), V @ V

    def rest(x):
        d = x - np.array(HOLE.position)
        rho = np.sqrt(np.einsum("ni,ni->n", d, d) + W2 * (d @ V) ** 2)
        A, N = (1 + HOLE.mass / (2 * rho)) ** 4, (2 * rho - HOLE.mass) / (2 * rho + HOLE.mass)
        return A, N

    def shift(x):
        A, N = rest(x)
        return -W2 * (A - N**2)[:, None] * V

    A, N = rest(x)
    lapse = N * np.sqrt(A / (A + W2 * (A - N**2) * v2))
    gradient = HOLE.gradient(x)
    K = stationary_curvature(gradient, HOLE.metric(x), lapse, shift(x), complex_step(shift, x))
    K += np.einsum("k,nkij->nij", V, gradient) / (2 * lapse[:, None, None])  # d_t = -v . d
    np.testing.assert_allclose(HOLE.extrinsic_curvature(x), K, atol=1e-14)


def test_constraints_hold():
    hamiltonian, momentum = constraints(HOLE, outside())
    assert np.abs(hamiltonian).max() < 1e-8
    assert np.abs(momentum).max() < 1e-8


@pytest.mark.parametrize("broken", [-1.0, 1.1])
def test_constraints_see_a_wrong_extrinsic_curvature(broken):
    class Wrong(BoostedSchwarzschild):
        def extrinsic_curvature(self, x):
            """Reversed in the part that is not even in v, or too large."""
            return super().extrinsic_curvature(x) * np.where(x[:, 2] > 0, broken, 1.0)[:, None, None]

    hamiltonian, momentum = constraints(Wrong(1.3, V), np.array([[2.0, 1.0, 0.01]]))
    assert np.abs(momentum).max() > 1e-3
    assert abs(hamiltonian[0]) > 1e-3 or broken == -1.0


def test_energy_and_momentum_at_infinity():
    hole = BoostedSchwarzschild(1.3, V)
    W = hole.lorentz_factor
    assert pytest.approx(1 / np.sqrt(1 - V @ V), rel=1e-15) == W
    errors = []
    for radius in (1e3, 1e4):
        energy, momentum = at_infinity(hole, radius)
        errors.append([abs(energy - W * 1.3), np.abs(momentum - W * 1.3 * V).max()])
    assert np.all(np.array(errors[0]) < 0.02)
    np.testing.assert_allclose(np.array(errors[0]) / errors[1], 10.0, rtol=0.02)


def test_at_rest_it_is_isotropic():
    x, rest = outside(), BoostedSchwarzschild(1.3, (0, 0, 0))
    np.testing.assert_allclose(rest.metric(x), IsotropicSchwarzschild(1.3).metric(x), rtol=1e-15)
    assert rest.time_symmetric and not HOLE.time_symmetric
    assert not rest.extrinsic_curvature(x).any()


def test_regular_on_the_throat():
    hole = BoostedSchwarzschild(1.0, (0.6, 0, 0))
    directions = outside() / np.linalg.norm(outside(), axis=1, keepdims=True)
    K = [
        hole.extrinsic_curvature(directions * hole.spheroid(r)(directions)[:, None])
        for r in (0.499, 0.5, 0.501)
    ]
    np.testing.assert_allclose(K[1], 0.5 * (K[0] + K[2]), atol=1e-3 * np.abs(K[1]).max())


def test_spheroid_is_round_for_the_hole():
    # psi and N are constant there: an ellipsoid's metric, and its area is known.
    hole, R = BoostedSchwarzschild(1.0, (0, 0, 0.6)), 3.0
    surface = StarSurface.from_radius(hole.spheroid(R))
    A, N = (1 + 0.5 / R) ** 4, (R - 0.5) / (R + 0.5)
    a, c = np.sqrt(A) * R, np.sqrt(A + 1.5625 * 0.36 * (A - N**2)) * R * 0.8
    e = np.sqrt(1 - (c / a) ** 2)
    u, weights = gauss_rule(40, 80)
    x = surface.points(u)
    np.testing.assert_allclose(hole.metric(x)[:, 0, 0], A, rtol=1e-13)
    np.testing.assert_allclose(x[:, 0] ** 2 + x[:, 1] ** 2 + (x[:, 2] / 0.8) ** 2, R**2, rtol=1e-13)
    q = surface.metric(hole).tensor(u)
    area = weights @ np.sqrt(0.5 * (np.trace(q, axis1=1, axis2=2) ** 2 - np.einsum("nij,nji->n", q, q)))
    assert area == pytest.approx(2 * np.pi * (a**2 + c**2 * np.arctanh(e) / e), rel=1e-12)


@given(exponent=st.integers(-150, 150))
def test_units_are_free(exponent):
    unit, x = 10.0**exponent, outside(3)
    other = BoostedSchwarzschild(1.3 * unit, V, np.array(HOLE.position) * unit)
    np.testing.assert_allclose(other.metric(unit * x), HOLE.metric(x), atol=1e-14)
    np.testing.assert_allclose(other.gradient(unit * x) * unit, HOLE.gradient(x), atol=1e-14)
    np.testing.assert_allclose(
        other.extrinsic_curvature(unit * x) * unit, HOLE.extrinsic_curvature(x), atol=1e-14
    )


def test_superposed_far_apart_and_at_rest():
    x = outside()
    alone = Superposed([HOLE])
    np.testing.assert_allclose(alone.metric(x), HOLE.metric(x), rtol=1e-14)
    np.testing.assert_array_equal(alone.extrinsic_curvature(x), HOLE.extrinsic_curvature(x))
    far = Superposed([HOLE, BoostedSchwarzschild(1.0, (0, 0, -0.5), (0, 0, 1e9))])
    np.testing.assert_allclose(far.metric(x), HOLE.metric(x), atol=1e-8)
    assert not far.time_symmetric
    resting = Superposed(
        [BoostedSchwarzschild(m, (0, 0, 0), (0, 0, z)) for m, z in ((1.0, 3.0), (0.5, -3.0))]
    )
    assert resting.time_symmetric
    exact = BrillLindquist([1.0, 0.5], [(0, 0, 3.0), (0, 0, -3.0)])
    y = 1e4 * x
    np.testing.assert_allclose(resting.metric(y), exact.metric(y), atol=1e-7)


def test_superposed_momenta_add_and_constraints_are_violated():
    pair = Superposed(
        [BoostedSchwarzschild(m, (0, 0, v), (0, 0, z)) for m, v, z in ((1, -0.4, 3), (0.5, 0.3, -3))]
    )
    W = [1 / np.sqrt(1 - v * v) for v in (0.4, 0.3)]
    energy, momentum = at_infinity(pair, 1e6)
    assert energy == pytest.approx(W[0] + 0.5 * W[1], rel=1e-4)
    np.testing.assert_allclose(momentum, [0, 0, -0.4 * W[0] + 0.15 * W[1]], atol=1e-4)
    x = outside(4, 8.0, 9.0)
    worst = [np.abs(constraints(pair, s * x)[0]).max() for s in (1.0, 8.0)]
    assert 1e-7 < worst[0] < 1e-2
    assert worst[0] / worst[1] > 8.0**3.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1.0, (0, 0.8, 0.6)), "the speed must be less than that of light, 1, not 1"),
        ((1.0, (0, 3.0, 4.0)), "the speed must be less than that of light, 1, not 5"),
        ((1.0, (0, 0.8)), "the velocity must be three finite numbers"),
        ((1.0, (0, 0, 0), (0, np.nan, 0)), "the position must be three finite numbers"),
        ((-1.0, (0, 0, 0)), "the mass must be positive, not -1"),
    ],
)
def test_refuses_what_is_no_hole(arguments, message):
    with pytest.raises(InvalidParameter, match=message):
        BoostedSchwarzschild(*arguments)


def test_refuses_punctures_radii_and_nothing():
    with pytest.raises(InvalidParameter, match=r"point 1, \(0.2, 0.1, -0.3\), is a puncture"):
        HOLE.metric(np.array([[1.0, 1, 1], HOLE.position]))
    with pytest.raises(InvalidParameter, match="the radius must be positive, not 0"):
        HOLE.spheroid(0)
    with pytest.raises(InvalidParameter, match="there are no holes to superpose"):
        Superposed([])
