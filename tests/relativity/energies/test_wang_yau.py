"""The Wang-Yau energy: closed forms, Minkowski space, moving holes, other slices, derivatives, refusals."""

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NoMinimum, NotEmbedded
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import (
    AnalyticCallable,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    SurfaceData,
    TimeFunction,
    embed_surface,
    wang_yau,
)
from isoembed.relativity.energies import wang_yau_energy
from isoembed.relativity.energies.time_function import TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_energy import WANG_YAU
from isoembed.relativity.energies.wang_yau_functional import EmbeddedTime, Functional
from isoembed.relativity.spacetimes.boosted import BoostedSchwarzschild
from isoembed.smooth import Harmonics, PulledBack, embed_smooth
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import orthonormal_frame, projected

EAST = np.sqrt(4.0 * np.pi / 3.0)  # times the harmonic of degree 1 is z


def directions(n=30):
    u = np.random.default_rng(5).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def nothing(u):
    return np.zeros((len(u), 3))


def round_sphere(r, mass=1.0):
    """A sphere of this areal radius in the static slice of Schwarzschild's spacetime."""
    f = np.sqrt(1.0 - 2.0 * mass / r)
    metric = PulledBack(lambda u: np.tile(r * np.eye(3), (len(u), 1, 1)))
    return SurfaceData(metric, mean_curvature=lambda u: np.full(len(u), 2.0 * f / r))


@cache
def static():
    """The sphere r = 4 M, and its embedding."""
    data = round_sphere(4.0)
    return data, embed_smooth(data.metric)


@dataclass(frozen=True)
class Map:
    """A map to R^3 in harmonics, coefficients (size, 3)."""

    harmonics: Harmonics
    coefficients: np.ndarray

    def values(self, u):
        return self.harmonics.values(u) @ self.coefficients

    def gradient(self, u):
        return self.harmonics.gradients(u)[1] @ self.coefficients


@dataclass(frozen=True)
class Spacelike:
    """The surface (tau, X) of Minkowski space, tau and X (size, 3) in harmonics, as seen from R^3.

    The unit normal nu of X in R^3 and the unit normal N of the surface in the cylinder above X are the
    frame of its normal bundle: k = -<H, nu>, p = -<H, N>, j = <D nu, N>.
    """

    tau: TimeFunction
    X: Map

    def tensor(self, u):
        dX, g = self.X.gradient(u), self.tau.gradient(u)
        return projected(np.einsum("nic,njc->nij", dX, dX) - g[:, :, None] * g[:, None, :], u)

    def lying(self, u):
        """k, p (n,) and j (n, 3)."""
        e = orthonormal_frame(u, self.tensor(u))
        X = self.X.harmonics.along(u, e)[1] @ self.X.coefficients
        S = self.X.harmonics.second_along(u, e, self.X.coefficients)
        g = self.tau.harmonics.along(u, e)[1] @ self.tau.coefficients
        s = self.tau.harmonics.second_along(u, e, self.tau.coefficients[:, None])[..., 0]
        drift = np.einsum("nabk,nck->nabc", S, X) - s[..., None] * g[:, None, None, :]
        H = np.einsum("naak->nk", S - drift @ X[:, None])
        upward = np.einsum("naa->n", s - np.einsum("nabc,nc->nab", drift, g))
        normals = np.cross(X[:, 0], X[:, 1])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        up = np.linalg.solve(np.einsum("nac,nbc->nab", X, X), g[:, :, None])[:, :, 0]
        W = np.sqrt(1.0 + (g**2).sum(axis=1))
        k = -(H * normals).sum(axis=1)
        p = W * (-upward + np.einsum("nk,na,nak->n", H, up, X))
        h = -np.einsum("nabk,nk->nab", S, normals)
        j = W[:, None] * np.einsum("nab,nb->na", h, up)
        dual = np.linalg.inv(np.concatenate([e, u[:, None]], axis=1))[:, :, :2]
        return k, p, np.einsum("nia,na->ni", dual, j)

    def data(self, sign=1.0):
        return SurfaceData(
            self,
            mean_curvature=lambda u: self.lying(u)[0],
            momentum=lambda u: self.lying(u)[1],
            normal_momentum=lambda u: sign * self.lying(u)[2],
        )


@cache
def minkowski():
    """A surface of Minkowski space, its data, and the embedding of its own metric."""
    harmonics = Harmonics(2, 2)
    u, weights = gauss_rule(6, 12)
    x, y, z = u.T
    X = u * [1.0, 1.2, 0.9] + 0.05 * np.stack([y * z, x**2, x * y], axis=1)
    tau = TimeFunction.of(lambda u: 0.3 * (u[:, 0] * u[:, 1] + 0.5 * u[:, 2] ** 2) + 0.1 * u[:, 0], 2)
    surface = Spacelike(tau, Map(harmonics, harmonics.values(u).T @ (weights[:, None] * X)))
    return surface, surface.data(), embed_smooth(surface)


# Minkowski space


def test_zero_for_surfaces_of_minkowski_space():
    surface, data, embedding = minkowski()
    found = wang_yau(data, surface.tau, embedding=embedding)
    assert abs(found.energy.value) < 1e-12
    assert found.gradient < 1e-12
    assert found.admissible > 0.1
    # Up to a motion the embedding is the surface itself.
    a, b = found.embedding.points(directions()), surface.X.values(directions())
    np.testing.assert_allclose(
        np.linalg.norm(a[:, None] - a, axis=2), np.linalg.norm(b[:, None] - b, axis=2), atol=1e-11
    )
    assert wang_yau(data, embedding=embedding).energy.value > 1e-3


def test_the_sign_of_the_connection_matters():
    surface, _, embedding = minkowski()
    assert wang_yau(surface.data(-1.0), surface.tau, embedding=embedding).energy.value < -1e-3


def test_found_from_zero_up_to_a_boost():
    surface, data, embedding = minkowski()
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(2, 4))
    assert abs(found.energy.value) < 1e-10
    assert found.gradient < 1e-7
    assert not found.notes
    assert found.embeddings <= 15
    u, _ = gauss_rule(10, 20)
    motions = np.column_stack([np.ones(len(u)), surface.tau.values(u), surface.X.values(u)])
    tau = found.tau.values(u)
    by, *_ = np.linalg.lstsq(motions, tau, rcond=None)
    assert np.abs(motions @ by - tau).max() < 1e-5
    # A boost: the row (T0, T) of a Lorentz transformation.
    assert by[1] ** 2 - by[2:] @ by[2:] == pytest.approx(1.0, abs=1e-4)
    assert np.abs(tau).max() > 0.1


def test_norm_and_connection_do_instead_of_a_slice():
    surface, data, embedding = minkowski()

    def norm(u):
        k, p, _ = surface.lying(u)
        return np.sqrt(k**2 - p**2)

    def angle(u):
        k, p, _ = surface.lying(u)
        return np.arctanh(p / k)

    psi = TimeFunction.of(angle, 32)
    bare = SurfaceData(
        surface, mean_curvature=norm, normal_momentum=lambda u: surface.lying(u)[2] - psi.gradient(u)
    )
    tau = TimeFunction(surface.tau.harmonics, 0.7 * surface.tau.coefficients[::-1])
    one, other = (wang_yau(d, tau, embedding=embedding).energy.value for d in (data, bare))
    assert one == pytest.approx(other, rel=1e-9)
    wrong = replace(bare, normal_momentum=None)
    assert wang_yau(wrong, tau, embedding=embedding).energy.value != pytest.approx(one, rel=1e-3)


# Schwarzschild's spheres


def closed_form(r, b):
    """E(b r cos theta) on a sphere of Schwarzschild's spacetime, M = 1."""
    x, weights = np.polynomial.legendre.leggauss(200)
    f, g = np.sqrt(1.0 - 2.0 / r), np.sqrt(1.0 + b * b)
    W = np.sqrt(1.0 + b * b * (1.0 - x * x))
    physical = 2.0 * np.hypot(f * W, b * x) - 2.0 * b * x * np.arcsinh(b * x / (f * W))
    reference = g + np.arcsinh(b) / b if b else 2.0
    return (4.0 * np.pi * r * reference - 2.0 * np.pi * r * weights @ physical) / (8.0 * np.pi)


@pytest.mark.parametrize(
    ("r", "b", "expected"),
    [
        (4.0, 0.0, 1.171572875254),
        (4.0, 0.5, 1.327628657545),
        (4.0, 1.0, 1.711712605346),
        (4.0, 2.0, 2.755494723472),
        (1000.0, 1.0, 1.415039452595),
    ],
)
def test_spheres_in_closed_form(r, b, expected):
    found = wang_yau(round_sphere(r), lambda u: b * r * u[:, 2]).energy
    assert closed_form(r, b) == pytest.approx(expected, rel=1e-12 * r)
    assert found.value == pytest.approx(closed_form(r, b), rel=1e-11 * r)
    assert abs(found.value - closed_form(r, b)) <= 3.0 * found.error + 1e-15 * r


def test_second_variation_of_spheres():
    data, embedding = static()
    X, tau, r, f = Harmonics(16, 16), Harmonics(4, 4), 4.0, np.sqrt(0.5)
    functional = Functional.of(data, embedding, TimeFunction.zero(), X, tau)
    start = resized(embedding.coefficients, embedding.harmonics, X)
    hessian = EmbeddedTime(functional, np.zeros(24), start).hessian
    l = tau.labels[0][1:]
    expected = l * (l + 1) * (1.0 - 2.0 * f + l * (l + 1) / (2.0 * f)) / (8.0 * np.pi * r)
    np.testing.assert_allclose(hessian, np.diag(expected), atol=1e-12 * expected.max())
    table = [0.5 * (0.05 * r) ** 2 * expected[l == degree][0] for degree in (1, 2, 3, 4)]
    np.testing.assert_allclose(table, [0.00039789, 0.00456985, 0.01926826, 0.05462167], atol=5e-9)
    found = wang_yau(data, "optimal", embedding=embedding)
    assert found.least_second_derivative == pytest.approx(expected.min(), rel=1e-10)
    assert found.energy.value == pytest.approx(4.0 * (1.0 - f), rel=1e-13)
    assert not found.notes


def test_one_sphere_in_two_slices():
    data, embedding = static()
    falling = StarSurface.sphere((0, 0, 0), 4.0).data(PainleveGullstrand(1.0))
    waving = TimeFunction.of(lambda u: 2.0 * u[:, 2] + 0.5 * u[:, 0] * u[:, 1], 2)
    for tau in (waving, None):
        one, other = (wang_yau(d, tau, embedding=embedding).energy.value for d in (data, falling))
        assert one == pytest.approx(other, rel=1e-13)


def test_constant_density_star():
    rho, ratios = 0.01, []
    kappa = 8.0 * np.pi * rho / 3.0

    def gamma(x):
        stretch = kappa / (1.0 - kappa * np.einsum("ni,ni->n", x, x))
        return np.eye(3) + stretch[:, None, None] * x[:, :, None] * x[:, None, :]

    star = AnalyticCallable(gamma)
    for r in (2.0, 0.1):
        found = wang_yau(StarSurface.sphere((0, 0, 0), r).data(star)).energy.value
        assert found == pytest.approx(r * (1.0 - np.sqrt(1.0 - kappa * r**2)), abs=1e-14 * r)
        ratios.append(found / (4.0 * np.pi * rho * r**3 / 3.0) - 1.0)
    # Small spheres: the energy density times the volume, and next kappa r^2 / 4 of it.
    np.testing.assert_allclose(ratios[1], 0.25 * kappa * 0.1**2, rtol=1e-3)


# Holes that move, and Kerr's


@pytest.mark.parametrize(
    ("R", "resting", "least"),
    [(10.0, 1.21576, 1.04726), (100.0, 1.24423, 1.00473), (1000.0, 1.24939, 1.00047)],
)
def test_moving_hole(R, resting, least):
    # Of energy 1.25 M; the least is that which it has at rest.
    data = StarSurface.sphere((0, 0, 0), R).data(BoostedSchwarzschild(1.0, (0.0, 0.0, 0.6)))
    embedding = embed_smooth(data.metric)
    still = wang_yau(data, embedding=embedding)
    assert still.energy.value == pytest.approx(resting, abs=6e-6)
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(2, 4))
    assert found.energy.value == pytest.approx(least, abs=6e-6)
    assert found.energy.error < 1e-3
    assert found.least_second_derivative > 0.0
    # Far from the hole: the time of the hole, W (t - v z), less that on the slice.
    assert found.tau.coefficients[1] / (R * EAST) == pytest.approx(-0.75, abs=1.0 / R)


@pytest.mark.parametrize("a", [0.5, 0.8])
def test_kerr(a):
    data = KerrNewmanSphere(3.0, 1.0, a).data()
    surface = embed_surface(data)
    found = wang_yau(data, "optimal", embedding=surface.embedding, degrees=(2, 4))
    assert found.gradient < 1e-10
    assert found.least_second_derivative > 1e-3
    np.testing.assert_allclose(found.tau.coefficients, 0.0, atol=1e-9)
    assert found.energy.value == pytest.approx(surface.energies.brown_york.value, rel=1e-11)
    assert found.energy.value == pytest.approx(surface.energies.liu_yau.value, rel=1e-11)


def test_kerr_in_two_slices():
    # r = const is one surface in both, turned about the axis; p and the connection differ.
    hole, r, a = KerrSchild(1.0, (0, 0, 0.5)), 4.0, 0.5
    R = hole.spheroid(r)

    def tau(z, x):
        return 1.5 * z + 0.8 * x + 0.3 * z**2

    one = wang_yau(KerrNewmanSphere(r, 1.0, a).data(), TimeFunction.of(lambda u: tau(u[:, 2], u[:, 0]), 2))
    data = StarSurface.from_radius(R).data(hole)
    same = TimeFunction.of(lambda u: tau(R(u) * u[:, 2] / r, R(u) * u[:, 0] / np.hypot(r, a)), 12)
    other = wang_yau(data, same)
    assert one.energy.value == pytest.approx(other.energy.value, rel=1e-12)
    wrong = wang_yau(replace(data, normal_momentum=nothing), same)
    assert wrong.energy.value != pytest.approx(one.energy.value, rel=1e-6)


# Derivatives and invariances


def test_derivatives_are_those_of_differences():
    _, data, embedding = minkowski()
    X, tau = Harmonics(16, 16), Harmonics(3, 3)
    functional = Functional.of(data, embedding, TimeFunction.zero(), X, tau)
    rng = np.random.default_rng(2)
    t, v, h = 0.05 * rng.normal(size=tau.size - 1), rng.normal(size=tau.size - 1), 1e-4
    here = functional.embedded(t, resized(embedding.coefficients, embedding.harmonics, X))
    ahead, behind = (functional.embedded(t + s * h * v, here.X) for s in (1, -1))
    assert (ahead.energy - behind.energy) / (2 * h) == pytest.approx(here.gradient @ v, rel=1e-5)
    change = (ahead.gradient - behind.gradient) / (2 * h)
    expected = here.hessian @ v
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_array_equal(here.hessian, here.hessian.T)


@cache
def tilted(unit):
    """The least energy of a hole that moves in no special direction."""
    hole = BoostedSchwarzschild(unit, (0.0, 0.36, 0.48))
    return wang_yau(StarSurface.sphere((0, 0, 0), 10.0 * unit).data(hole), "optimal", degrees=(1,))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_are_free(unit):
    one, other = tilted(1.0), tilted(unit)
    assert other.energy.value == pytest.approx(unit * one.energy.value, rel=1e-12)
    assert other.embeddings == one.embeddings
    assert other.admissible * unit**2 == pytest.approx(one.admissible, rel=1e-6)
    np.testing.assert_allclose(other.tau.coefficients / unit, one.tau.coefficients, atol=1e-5)


def test_rotations_are_free():
    surface, data, embedding = minkowski()
    Q, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    Q *= np.linalg.det(Q)

    class Turned:
        def tensor(self, u):
            return Q @ surface.tensor(u @ Q) @ Q.T

    turned = SurfaceData(
        Turned(),
        mean_curvature=lambda u: data.mean_curvature(u @ Q),
        momentum=lambda u: data.momentum(u @ Q),
        normal_momentum=lambda u: data.normal_momentum(u @ Q) @ Q.T,
    )
    tau = TimeFunction.of(lambda u: 0.2 * u[:, 0] * u[:, 2] - 0.1 * u[:, 1], 2)
    one = wang_yau(data, tau, embedding=embedding)
    other = wang_yau(turned, TimeFunction.of(lambda u: tau.values(u @ Q), 2))
    assert other.energy.value == pytest.approx(one.energy.value, rel=1e-8)


def test_a_constant_has_no_consequences():
    data, embedding = static()
    one, other = (
        wang_yau(data, lambda u, c=c: 2.0 * u[:, 2] + c, embedding=embedding).energy.value
        for c in (0.0, 50.0)
    )
    assert one == pytest.approx(other, rel=1e-13)


# What is said


def test_inadmissible_time_functions():
    data, embedding = static()

    def saddle(c):
        return TimeFunction.of(lambda u: c * u[:, 0] * u[:, 1], 2)

    with pytest.raises(
        NotEmbedded, match=r"is not embedded beyond 0.\d+ times the given tau: there K \+ det"
    ):
        wang_yau(data, saddle(4.8), embedding=embedding)
    # Just beyond: K < 0 at a few points, and X still follows.
    beyond = wang_yau(data, saddle(4.22), embedding=embedding)
    assert beyond.admissible < 0.0
    assert len(beyond.notes) == 1 and "tau is not admissible: K + det D^2 tau / W^2 is -" in beyond.notes[0]
    assert not wang_yau(data, saddle(2.0), embedding=embedding).notes


def test_refuses_data():
    data, embedding = static()
    k = data.mean_curvature(directions(1))[0]
    with pytest.raises(InvalidParameter, match="needs the mean curvature k of the surface"):
        wang_yau(replace(data, mean_curvature=None), embedding=embedding)
    large = replace(data, momentum=lambda u: -0.37 * u[:, 2])
    with pytest.raises(InvalidParameter, match=r"needs the normal_momentum K\(., n\), too"):
        wang_yau(large, embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"^k = 0.3536 does not exceed \|p\| = 0.36\d* at theta = 3\."):
        wang_yau(replace(large, normal_momentum=nothing), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"k = -0.3536 does not exceed .* spacelike, outward"):
        wang_yau(replace(data, mean_curvature=lambda u: np.full(len(u), -k)), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"k = nan does not exceed"):
        wang_yau(replace(data, mean_curvature=lambda u: np.full(len(u), np.nan)), embedding=embedding)
    horizon = KerrNewmanHorizon(1.0, 0.5).data()
    with pytest.raises(InvalidParameter, match="the mean curvature vector of a horizon has no norm"):
        wang_yau(horizon)


@pytest.mark.parametrize("tau", [3, "best", ("optimal",)])
def test_refuses_what_is_no_time_function(tau):
    data, embedding = static()
    with pytest.raises(InvalidParameter, match='not a TimeFunction, an array, a function, "optimal" or None'):
        wang_yau(data, tau, embedding=embedding)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda u: u, r"tau at \d+ directions has the shape \(\d+, 3\)"),
        (lambda u: 1.0, r"tau at \d+ directions has the shape \(\)"),
        (lambda u: np.where(u[:, 2] > 0.9, np.nan, 1.0), r"tau is nan at u = \[.*, 0.9"),
        (lambda u: np.abs(u[:, 2]), r"tau is missed by 0.0\d+ by harmonics up to degree 16"),
    ],
)
def test_refuses_functions_without_values(function, message):
    with pytest.raises(InvalidParameter, match=message):
        TimeFunction.of(function)


def test_refuses_what_does_not_embed():
    with pytest.raises(NotEmbedded, match="no surface of revolution has this metric"):
        wang_yau(KerrNewmanSphere(1.5, 1.0, 0.95).data(), "optimal")


def test_report_is_plain():
    data, embedding = static()
    found = wang_yau(data, lambda u: 2.0 * u[:, 2], embedding=embedding)
    report = json.loads(json.dumps(found.report, allow_nan=False))
    assert report["wang_yau"] == found.energy.value
    assert report["error"] == found.energy.error < 1e-9
    assert report["least_second_derivative"] is None
    assert report["embeddings"] == found.embeddings >= 2
    largest = max(report["tau"], key=lambda term: abs(term["coefficient"]))
    assert (largest["degree"], largest["order"]) == (1, 0)
    assert largest["coefficient"] == pytest.approx(2.0 * EAST, rel=1e-13)
    assert len(report["tau"]) == found.tau.harmonics.size - 1


def test_time_functions():
    tau, u = TimeFunction.of(lambda u: 2.0 * u[:, 2] + u[:, 0] * u[:, 1] + 7.0, 3), directions()
    np.testing.assert_allclose(tau.values(u), 2.0 * u[:, 2] + u[:, 0] * u[:, 1] + 7.0, atol=1e-13)
    slope = np.stack([u[:, 1], u[:, 0], np.full(len(u), 2.0)], axis=1)
    slope -= np.einsum("ni,ni->n", slope, u)[:, None] * u
    np.testing.assert_allclose(tau.gradient(u), slope, atol=1e-13)
    metric = static()[0].metric
    raised = TimeRaisedMetric(metric, tau).tensor(u)
    np.testing.assert_allclose(raised, metric.tensor(u) + np.einsum("ni,nj->nij", slope, slope), atol=1e-12)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", raised, u), 0.0, atol=1e-12)


def test_the_embedding_lies_in_minkowski_space():
    surface, data, embedding = minkowski()
    found = wang_yau(data, lambda u: 0.2 * u[:, 2] + 0.1 * u[:, 0] * u[:, 2], embedding=embedding)
    u = directions()
    dX = found.embedding.harmonics.gradients(u)[1] @ found.embedding.coefficients
    slope = found.tau.gradient(u)
    induced = np.einsum("nic,njc->nij", dX, dX) - slope[:, :, None] * slope[:, None, :]
    np.testing.assert_allclose(induced, surface.tensor(u), atol=1e-6)


def test_an_array_holds_coefficients():
    data, embedding = static()
    tau = TimeFunction.of(lambda u: 2.0 * u[:, 2], 2)
    one, other = (wang_yau(data, t, embedding=embedding) for t in (tau, tau.coefficients))
    assert one.energy == other.energy
    with pytest.raises(InvalidParameter, match=r"have the shape \(5,\), not \(\(L \+ 1\)\^2,\)"):
        wang_yau(data, np.zeros(5), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"9 harmonics take as many coefficients, not \(4,\)"):
        TimeFunction(Harmonics(2, 2), np.zeros(4))


@pytest.mark.parametrize("degrees", [(), (0,), (2, -1)])
def test_degrees_that_are_none(degrees):
    data, embedding = static()
    with pytest.raises(InvalidParameter, match=r"the degrees of tau are .*: there must be some"):
        wang_yau(data, "optimal", embedding=embedding, degrees=degrees)


def test_one_degree_has_an_error_too():
    data, embedding = static()
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(1,))
    assert np.isfinite(found.energy.error)
    json.dumps(found.report, allow_nan=False)


def test_a_surface_that_only_embeds_with_time():
    """r = 1.5 of spin .95, below the radius from which it embeds in R^3 (Miller, Ray, Wang & Yau 2018)."""
    data = KerrNewmanSphere(1.5, 1.0, 0.95).data()
    for tau in (None, "optimal"):
        with pytest.raises(NotEmbedded, match="no surface of revolution"):
            wang_yau(data, tau)
    found = wang_yau(data, lambda u: 1.2 * u[:, 2])
    assert found.admissible > 0.0 and found.energy.error < 1e-6
    assert found.embedding.least_curvature > 0.0


def test_the_energy_does_not_depend_on_where_the_path_begins():
    data = KerrNewmanSphere(3.0, 1.0, 0.8).data()
    tau = TimeFunction.of(lambda u: 1.5 * u[:, 2] + 0.4 * u[:, 0] * u[:, 2], 2)
    one = wang_yau(data, tau)
    raised = embed_smooth(TimeRaisedMetric(data.metric, tau))
    functional = Functional.of(data, raised, tau, raised.harmonics, tau.harmonics)
    other = EmbeddedTime(functional, tau.coefficients[1:], raised.coefficients).energy
    assert other == pytest.approx(one.energy.value, rel=1e-9)


def test_a_search_that_ends_too_early_is_no_minimum(monkeypatch):
    _, data, embedding = minkowski()
    monkeypatch.setattr(wang_yau_energy, "WANG_YAU", replace(WANG_YAU, steps=1))
    with pytest.raises(NoMinimum, match=r"the search ended at E = .* was to gain"):
        wang_yau(data, "optimal", embedding=embedding, degrees=(2,))


def test_a_degree_that_does_not_resolve_the_surface(monkeypatch):
    monkeypatch.setattr(wang_yau_energy, "WANG_YAU", replace(WANG_YAU, least_degree=4, highest_degree=4))
    with pytest.raises(NotEmbedded, match="by harmonics up to degree 4"):
        wang_yau(KerrNewmanSphere(1.7, 1.0, 0.95).data())
