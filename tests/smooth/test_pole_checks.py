"""Metrics that are no smooth tensors are refused at once, and the sentence says why; others pass."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from isoembed.errors import InvalidMetric
from isoembed.meshing.metric_relaxation import FLIP_ROUNDS, MAX_GEODESICS, MetricMesh
from isoembed.relativity import KerrNewmanErgosphere, KerrNewmanHorizon, KerrSchild, StarSurface
from isoembed.smooth import AngleMetric, GridMetric, embed_smooth, triangulate_metric
from isoembed.smooth.pole_checks import check_rings, check_within

THETA = {
    "cell-centered": lambda n: (np.arange(n) + 0.5) * np.pi / n,
    "with the poles": lambda n: np.linspace(0.0, np.pi, n),
    "Gauss-Legendre": lambda n: np.arccos(np.polynomial.legendre.leggauss(n)[0])[::-1],
}


def linear(A):
    """The components of the ellipsoid A u."""
    G = np.array(A).T @ np.array(A)

    def components(theta, phi):
        s, c, S, C = np.broadcast_arrays(np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi))
        t, p = np.stack([c * C, c * S, -s]), np.stack([-s * S, s * C, 0.0 * s])
        return tuple(np.einsum("i...,ij,j...", a, G, b) for a, b in ((t, t), (t, p), (p, p)))

    return components


def kerr(a):
    r = 1.0 + np.sqrt(1.0 - a**2)

    def components(theta, phi):
        S = r**2 + (a * np.cos(theta)) ** 2 + 0.0 * phi
        return S, 0.0 * S, (r**2 + a**2) ** 2 / S * np.sin(theta) ** 2

    return components


def three_fold(theta, phi):
    """The surface r = 1 + sin^3 theta cos 3 phi / 10, whose q_tp falls fast to the poles."""
    s, c, C, S = np.sin(theta), np.cos(theta), np.cos(3.0 * phi), np.sin(3.0 * phi)
    r, r_t, r_p = 1.0 + 0.1 * s**3 * C, 0.3 * s**2 * c * C, -0.3 * s**3 * S
    return r**2 + r_t**2, r_t * r_p, r**2 * s**2 + r_p**2


TILTED = linear([[1.5, 0.2, -0.3], [0.0, 1.2, 0.4], [0.1, -0.5, 1.0]])
GOOD = {
    "sphere": linear(np.eye(3)),
    "Kerr": kerr(0.6),
    "nearly extreme Kerr": kerr(0.9999),
    "general ellipsoid": TILTED,
    "three-fold": three_fold,
    "squashed": linear(np.diag([1.0, 1.0, 0.01])),
    "needle": linear(np.diag([0.01, 0.01, 1.0])),
    "flat": linear(np.diag([1.0, 0.3, 0.05])),
}
MISTAKES = {  # (what is done to q_tt, q_tp, q_pp; what is said)
    "frame": (
        lambda s, tt, tp, pp: (tt, tp / s, pp / s**2),
        "q_tp and q_pp look like components in an orthonormal frame",
    ),
    "frame, q_pp": (
        lambda s, tt, tp, pp: (tt, tp, pp / s**2),
        "q_pp looks like a component in an orthonormal frame: multiply it by sin^2 theta",
    ),
    "sign": (lambda s, tt, tp, pp: (tt, -tp, pp), "with the other sign it would"),
    "left out": (lambda s, tt, tp, pp: (tt, 0.0 * tp, pp), "it was left out"),
    "exchanged": (lambda s, tt, tp, pp: (pp, tp, tt), "q_tt and q_pp look exchanged"),
    "sin theta": (lambda s, tt, tp, pp: (tt, tp, pp / s), "q_pp falls like sin theta"),
    "cone": (lambda s, tt, tp, pp: (tt, tp, 0.99 * pp), "a cone"),
}
ANYWHERE = ("frame, q_pp", "exchanged", "sin theta", "cone")


def grid(components, n, m, kind="cell-centered", change=lambda *q: q, noise=0.0, dtype=np.float64):
    theta, phi = THETA[kind](n), 2.0 * np.pi / m * np.arange(m) + 0.3 * (m > 1)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    rng = np.random.default_rng(1)
    q = change(*components(t, p))
    return GridMetric(theta, phi, *((v * (1.0 + noise * rng.normal(size=v.shape))).astype(dtype) for v in q))


def spoiled(components, name):
    change = MISTAKES[name][0]
    return lambda theta, phi: change(np.sin(theta), *components(theta, phi))


def refusal(make):
    with pytest.raises(InvalidMetric) as refused:
        make()
    assert str(refused.value).startswith("the metric is not smooth at the poles: ")
    return str(refused.value)


class TestMistakes:
    @pytest.mark.parametrize("kind", ["cell-centered", "Gauss-Legendre"])
    @pytest.mark.parametrize("name", MISTAKES)
    def test_on_grids(self, name, kind):
        said = refusal(lambda: grid(spoiled(TILTED, name), 24, 48, kind))
        assert MISTAKES[name][1] in said

    @pytest.mark.parametrize("name", [name for name in MISTAKES if name != "cone"])
    def test_on_coarse_noisy_grids(self, name):
        said = refusal(lambda: grid(spoiled(TILTED, name), 8, 16, noise=1e-4))
        assert MISTAKES[name][1] in said

    @pytest.mark.parametrize("name", MISTAKES)
    @pytest.mark.parametrize("act", [lambda m: triangulate_metric(m, 100), embed_smooth])
    def test_of_functions(self, name, act):
        said = refusal(lambda: act(AngleMetric(spoiled(TILTED, name))))
        assert MISTAKES[name][1] in said

    @pytest.mark.parametrize("name", ANYWHERE)
    @pytest.mark.parametrize("surface", ["sphere", "Kerr", "nearly extreme Kerr", "needle"])
    def test_of_axisymmetric_metrics(self, name, surface):
        assert MISTAKES[name][1] in refusal(lambda: grid(spoiled(GOOD[surface], name), 32, 1))
        assert MISTAKES[name][1] in refusal(lambda: check_rings(AngleMetric(spoiled(GOOD[surface], name))))

    @pytest.mark.parametrize("name", ["sign", "left out"])
    def test_that_are_small_at_the_poles(self, name):
        assert MISTAKES[name][1] in refusal(lambda: grid(spoiled(three_fold, name), 32, 64))
        assert MISTAKES[name][1] in refusal(lambda: check_rings(AngleMetric(spoiled(three_fold, name))))

    def test_latitude(self):
        def components(theta, phi):
            return kerr(0.6)(0.5 * np.pi - theta, phi)

        for make in (lambda: grid(components, 32, 64), lambda: check_rings(AngleMetric(components))):
            assert "theta counts from the north pole" in refusal(make)

    def test_degrees(self):
        def components(theta, phi):
            return kerr(0.6)(np.radians(theta), phi)

        assert "angles are in radians" in refusal(lambda: check_rings(AngleMetric(components)))
        with pytest.raises(InvalidMetric, match=r"phi = 2 pi, for theta = .*angles are in radians"):
            check_rings(AngleMetric(lambda theta, phi: TILTED(theta, np.radians(phi))))

    def test_the_sentence_has_the_values(self):
        said = refusal(lambda: grid(spoiled(GOOD["sphere"], "cone"), 24, 48))
        assert "they are 1 and 0.99 at theta = " in said and "too sharp for so few nodes" in said
        said = refusal(lambda: check_rings(AngleMetric(spoiled(GOOD["sphere"], "frame, q_pp"))))
        assert "they are 1 and 250000 at theta = 0.002" in said

    def test_a_part_that_does_not_vanish_at_the_pole(self):
        refusal(
            lambda: check_rings(AngleMetric(lambda theta, phi: linear(np.diag([3, 2, 1]))(theta, phi / 2)))
        )


class TestGoodMetrics:
    @pytest.mark.parametrize("surface", GOOD)
    def test_of_functions(self, surface):
        assert check_rings(AngleMetric(GOOD[surface])).conflict < 1e-6

    @pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-2])
    @pytest.mark.parametrize("kind", THETA)
    @pytest.mark.parametrize("surface", ["Kerr", "general ellipsoid", "three-fold"])
    def test_on_noisy_grids(self, surface, kind, noise):
        for n, m in ((6, 12), (12, 24), (33, 64)):
            grid(GOOD[surface], n, m, kind, noise=noise).at_poles()

    @pytest.mark.parametrize("surface", GOOD)
    def test_of_single_precision(self, surface):
        grid(GOOD[surface], 24, 48, dtype=np.float32).at_poles()

    @pytest.mark.parametrize("surface", ["needle", "squashed", "sphere"])
    def test_on_four_nodes(self, surface):
        for kind in THETA:
            grid(GOOD[surface], 5, 8, kind).at_poles()

    @pytest.mark.parametrize("epsilon", [1e-6, 1e-3, 0.1])
    def test_of_ergospheres_with_sharp_tips(self, epsilon):
        for spin in (0.1, 0.99):
            assert check_rings(KerrNewmanErgosphere(epsilon=epsilon, spin=spin)).conflict < 1e-6

    def test_induced_by_a_slice(self):
        surface = StarSurface.from_angles(lambda t, p: 1 + 0.1 * np.sin(t) ** 3 * np.cos(3 * p))
        assert check_rings(surface.metric(KerrSchild(0.3, (0.1, 0.2, 0.0)))).conflict < 1e-6
        assert check_rings(KerrNewmanHorizon(spin=0.9)).conflict < 1e-6

    def test_of_splines_that_are_rough_at_the_poles(self):
        theta = np.linspace(0.0, np.pi, 65)
        tt, _, pp = (CubicSpline(theta, q) for q in kerr(0.6)(theta, 0.0))
        check_rings(AngleMetric(lambda t, p: (tt(t), 0.0 * t, pp(t))))

    def test_of_finite_differences(self):
        """Derivatives of an ellipsoid of second order, one-sided at the first and last node."""
        n, m = 24, 36
        theta, phi = THETA["cell-centered"](n), 2.0 * np.pi / m * np.arange(m)
        t, p = np.meshgrid(theta, phi, indexing="ij")
        X = np.diag([1.5, 1.2, 1.0]) @ np.moveaxis(
            np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]), 0, 1
        )
        along = np.gradient(X, theta, axis=0)
        around = (np.roll(X, -1, axis=2) - np.roll(X, 1, axis=2)) / (4.0 * np.pi / m)
        q = [np.einsum("ncm,ncm->nm", a, b) for a, b in ((along, along), (along, around), (around, around))]
        GridMetric(theta, phi, *q)


def test_what_no_surface_meets_within_the_tolerance_is_refused_before_it_is_tried():
    metric = grid(spoiled(GOOD["sphere"], "cone"), 8, 16)  # a conflict that differences can make
    with pytest.raises(InvalidMetric, match=r"every smooth surface misses such lengths by more than 0\.0001"):
        embed_smooth(metric)
    check_within(metric.at_poles(), 0.01)


def test_the_relaxation_of_a_bad_metric_ends():
    """A tensor that jumps everywhere: no triangles are good, and geodesics are many."""
    calls = []

    def distances(start, end):
        calls.append(len(start))
        return np.random.default_rng(len(calls)).uniform(0.5, 1.5, len(start))

    u = np.random.default_rng(0).normal(size=(60, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    mesh = MetricMesh.hull(u, lambda u: np.tile(np.eye(3), (len(u), 1, 1)), distances)
    mesh.relaxed(None)
    edges = 3 * 60 - 6
    assert sum(calls) < (MAX_GEODESICS + FLIP_ROUNDS + 1) * edges
