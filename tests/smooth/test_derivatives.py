"""Derivatives of smooth embeddings by their metrics: closed forms, differences, and the transpose."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from isoembed import Spherical
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth import Harmonics, MetricDerivatives, PulledBack, SmoothEmbedding, embed_smooth
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import TwoMetric

U = fibonacci_directions(60)
SPREAD = np.array([[1.0, 0.1, 0.0], [-0.1, 1.05, 0.1], [0.0, 0.05, 0.95]])


def ellipsoid(*axes):
    """The metric of the map u -> (a x, b y, c z)."""
    A = np.diag(axes)
    return PulledBack(lambda u: A @ (np.eye(3) - u[:, :, None] * u[:, None, :]))


@dataclass(frozen=True)
class Changed:
    """A metric and a part of a change, which is given by a function."""

    metric: TwoMetric
    part: float

    def tensor(self, u):
        return self.metric.tensor(u) + self.part * bump(u)


def bump(u):
    """A change of a metric that has no symmetry."""
    slope = np.array([0.3, -0.5, 0.8]) - (u @ [0.3, -0.5, 0.8])[:, None] * u
    return (1 + u[:, 0] * u[:, 1])[:, None, None] * slope[:, :, None] * slope[:, None, :]


def exact(metric, A, degree=1):
    """The embedding u -> A u."""
    harmonics = Harmonics(degree, degree)
    C = np.vstack([np.zeros(3), np.linalg.inv(Harmonics(1, 1).values(np.eye(3))[:, 1:]) @ A.T])
    return SmoothEmbedding(metric, harmonics, resized(C, Harmonics(1, 1), harmonics), 1e-4, np.inf)


@cache
def bodies():
    axes = (1.2, 1.0, 0.9)
    return {
        "revolution": embed_smooth(ellipsoid(1.0, 1.0, 1.2)),
        "mapped": replace(
            exact(metric_in(ellipsoid(*axes), SphereMap.linear(np.linalg.inv(SPREAD))), np.diag(axes)),
            coordinates=SphereMap.linear(SPREAD),
        ),
    }


def distances(x):
    i, j = np.triu_indices(len(x), 1)
    return np.linalg.norm(x[i] - x[j], axis=1)


def distance_rates(x, v):
    i, j = np.triu_indices(len(x), 1)
    return np.einsum("ni,ni->n", x[i] - x[j], v[i] - v[j]) / distances(x)


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_a_round_sphere_moves_along_its_normals(degree):
    # To first order r = 1 + f has the metric (1 + 2 f) g.
    surface, harmonics = exact(ellipsoid(1, 1, 1), np.eye(3), 6), Harmonics(6, 6)
    found = MetricDerivatives.of(surface)
    k = int(np.argmax(harmonics.labels[0] == degree))
    f = harmonics.values(found.directions)[:, k]
    d = found.jvp(2 * f[:, None, None] * surface.metric.tensor(found.directions))
    assert np.allclose(found.velocities(U, d), harmonics.values(U)[:, k, None] * U, atol=1e-12)


def test_growing_axes_of_ellipsoids_of_revolution():
    a, c, h = 1.0, 1.5, 1e-4
    found = MetricDerivatives.of(exact(ellipsoid(a, a, c), np.diag([a, a, c])), 12)
    for axes in ((1.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        up, down = (
            ellipsoid(*(np.array([a, a, c]) + s * h * np.array(axes))).tensor(found.directions)
            for s in (1, -1)
        )
        changes = (up - down) / (2 * h)
        rates = distance_rates(U * [a, a, c], found.velocities(U, found.jvp(changes)))
        assert np.allclose(rates, distance_rates(U * [a, a, c], U * axes), atol=1e-9)
        grown = 4 / 3 * np.pi * (2 * a * c * axes[0] + a * a * axes[2])
        assert np.isclose(np.sum(found.volume * changes), grown, rtol=1e-9)
        # int H dA = 2 pi (c + a^2 arcosh(c / a) / (c^2 - a^2)^(1/2)), by Cauchy's formula.
        whole = [
            2 * np.pi * (z + x * x * np.arccosh(z / x) / np.sqrt(z * z - x * x))
            for x, z in ((a + s * h * axes[0], c + s * h * axes[2]) for s in (1, -1))
        ]
        slope = (whole[0] - whole[1]) / (2 * h)
        assert np.isclose(np.sum(found.integrated_mean_curvature * changes), slope, rtol=1e-5)


@pytest.mark.parametrize("name", ["revolution", "mapped"])
def test_central_differences(name):
    surface, h = bodies()[name], 1e-3
    found = MetricDerivatives.of(surface, 20)
    changes = bump(found.directions)
    sides = [embed_smooth(Changed(surface.metric, s * h), start=surface, accuracy=1e-14) for s in (1, -1)]
    slope = (distances(sides[0].points(U)) - distances(sides[1].points(U))) / (2 * h)
    rates = distance_rates(surface.points(U), found.velocities(U, found.jvp(changes)))
    assert np.abs(rates - slope).max() < 1e-5 * np.abs(slope).max()
    for quantity in ("area", "volume", "integrated_mean_curvature"):
        above, below = (getattr(side, quantity) for side in sides)
        rate = np.sum(getattr(found, quantity) * changes)
        assert np.isclose(rate, (above - below) / (2 * h), rtol=2e-6)


def test_the_transpose():
    surface = bodies()["mapped"]
    found = MetricDerivatives.of(surface)
    g = np.random.default_rng(0).normal(size=(found.harmonics.size, 3)) / found.harmonics.size
    changes = bump(found.directions)
    assert np.isclose(np.sum(g[1:] * found.jvp(changes)[1:]), np.sum(found.vjp(g) * changes), rtol=1e-9)


def test_units():
    small, large = (
        MetricDerivatives.of(
            exact(ellipsoid(*(s * np.array([1.0, 1.1, 1.2]))), s * np.diag([1, 1.1, 1.2]), 8)
        )
        for s in (1.0, 2.0**40)
    )
    changes = bump(small.directions)
    assert np.allclose(large.jvp(changes * 2.0**80), small.jvp(changes) * 2.0**40, rtol=1e-9)
    assert np.allclose(large.volume, small.volume * 2.0**40, rtol=1e-9)


def test_refusals():
    surface = exact(ellipsoid(1, 1, 1), np.eye(3), 3)
    found = MetricDerivatives.of(surface)
    with pytest.raises(InvalidParameter, match=r"the changes have the shape \(2,\), not \(\d+, 3, 3\)"):
        found.jvp(np.ones(2))
    with pytest.raises(InvalidParameter, match="the change at direction 0 is not finite"):
        found.jvp(np.full((len(found.directions), 3, 3), np.nan))
    Y = Harmonics(30, 30).values(found.directions)[:, -1]
    with pytest.raises(InvalidParameter, match=r"degree 16 leave \d\.\de[+-]\d+ of the change"):
        found.jvp(Y[:, None, None] * surface.metric.tensor(found.directions))
    with pytest.raises(InvalidParameter, match="is not one of 289 finite triples"):
        found.vjp(np.ones(3))
    with pytest.raises(InvalidParameter, match="misses its metric by"):
        MetricDerivatives.of(exact(ellipsoid(1, 1, 2), np.eye(3)))
    with pytest.raises(InvalidParameter, match="in harmonics of degree 40, and the maximum is 36"):
        MetricDerivatives.of(exact(ellipsoid(1, 1, 1), np.eye(3), 40))
    round_sphere = embed_smooth(ellipsoid(0.5, 0.5, 0.5), space=Spherical(0.1))
    with pytest.raises(InvalidParameter, match=r"surfaces in R\^3, not in Spherical"):
        MetricDerivatives.of(round_sphere)
