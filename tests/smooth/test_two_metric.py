"""Smooth metrics as tensors on the tangent planes: from components in angles, and induced by maps."""

import math

import numpy as np
import pytest

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity import SurfaceData, embed_surface
from isoembed.smooth import (
    AxisymmetricEmbedding,
    axis_of_symmetry,
    embed_smooth,
    gaussian_curvature,
    least_hyperbolic,
    triangulate_metric,
)
from isoembed.smooth.two_metric import AngleMetric, PulledBack, area_density, orthonormal_frame

A = np.array([[2.0, 0.3, -0.2], [0.0, 1.5, 0.4], [0.1, 0.0, 1.0]])
"""Takes the unit sphere to an ellipsoid that is aligned with nothing."""

LINEAR = PulledBack(lambda u: np.broadcast_to(A, (len(u), 3, 3)))


def components(theta, phi):
    """The same metric in angles."""
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    along = A @ np.stack([ct * cp, ct * sp, -st])
    around = A @ np.stack([-st * sp, st * cp, np.zeros_like(st)])
    return (along * along).sum(axis=0), (along * around).sum(axis=0), (around * around).sum(axis=0)


def directions(n=40):
    u = np.random.default_rng(2).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1)[:, None]


def near_poles():
    s = np.array([0.0, 1e-12, 1e-6, 0.9e-3, 1.1e-3, 0.02])
    phi = np.linspace(0.0, 6.0, len(s))
    north = np.stack([s * np.cos(phi), s * np.sin(phi), np.sqrt(1.0 - s**2)], axis=1)
    return np.concatenate([north, -north])


def test_angles_and_map_give_the_same_tensor():
    u = directions()
    np.testing.assert_allclose(AngleMetric(components).tensor(u), LINEAR.tensor(u), atol=1e-13)


def test_the_poles_are_points_like_others():
    u = near_poles()
    np.testing.assert_allclose(AngleMetric(components).tensor(u), LINEAR.tensor(u), atol=1e-9)
    at_pole = AngleMetric(components).tensor(u[[0, 6]])
    np.testing.assert_allclose(at_pole, LINEAR.tensor(u[[0, 6]]), atol=1e-12)


def test_the_function_is_not_called_at_the_poles():
    def wary(theta, phi):
        assert np.sin(theta).min() > 0.5e-3
        return components(theta, phi)

    AngleMetric(wary).tensor(near_poles())


def test_tensors_are_symmetric_and_tangent():
    u = directions()
    q = LINEAR.tensor(u)
    np.testing.assert_array_equal(q, q.transpose(0, 2, 1))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", q, u), 0.0, atol=1e-14)


def test_an_ambient_metric_counts():
    gamma = np.diag([1.0, 4.0, 9.0])
    metric = PulledBack(
        lambda u: np.broadcast_to(A, (len(u), 3, 3)), lambda u: np.broadcast_to(gamma, (len(u), 3, 3))
    )
    stretched = PulledBack(lambda u: np.broadcast_to(np.diag([1.0, 2.0, 3.0]) @ A, (len(u), 3, 3)))
    np.testing.assert_allclose(metric.tensor(directions()), stretched.tensor(directions()), rtol=1e-13)


def test_frames_are_orthonormal_and_look_outward():
    u = np.concatenate([directions(), near_poles()])
    q = LINEAR.tensor(u)
    e = orthonormal_frame(u, q)
    np.testing.assert_allclose(
        e @ q @ e.transpose(0, 2, 1), np.broadcast_to(np.eye(2), (len(u), 2, 2)), atol=1e-13
    )
    across = np.cross(e[:, 0], e[:, 1])
    np.testing.assert_allclose(across, u / area_density(q)[:, None], atol=1e-13)


def test_the_area_is_that_of_the_ellipsoid():
    from isoembed.gallery import Ellipsoid

    u, w = gauss_rule(40, 80)
    exact = Ellipsoid(tuple(np.linalg.svd(A, compute_uv=False))).area
    assert w @ area_density(LINEAR.tensor(u)) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(
    ("function", "kind", "said"),
    [
        (lambda t, p: np.array([[t, t], [t, t]]), InvalidMetric, r"returns a ndarray of shape \(2, 2, \d+\)"),
        (
            lambda t, p: (1.0, np.sin(t) ** 2),
            InvalidMetric,
            "returns a tuple of length 2, not the three q_tt",
        ),
        (
            lambda t, p: (1, 0, np.ones(5)),
            InvalidMetric,
            r"q_pp has the shape \(5,\) for theta and phi of shape \(",
        ),
        (lambda t, p: 1.0, InvalidMetric, "returns a float, not the three q_tt, q_tp and q_pp"),
        (lambda t, p: (1, 0, math.sin(t) ** 2), InvalidParameter, "TypeError: .* np.sin instead of math.sin"),
        (lambda t, p: (1, 0, 1j * np.sin(t)), InvalidParameter, "has complex values, not real numbers"),
        (
            lambda t, p: (1, 0, np.where(t > 1.5, np.nan, np.sin(t) ** 2)),
            InvalidMetric,
            r"q_pp is nan at theta = 1\.5708, phi = ",
        ),
    ],
)
def test_functions_that_give_no_components(function, kind, said):
    for use in (embed_smooth, lambda metric: metric.tensor(fibonacci_directions(40))):
        with pytest.raises(kind, match=said.replace(r"1\.5708", r"1\.\d+")):
            use(AngleMetric(function))


@pytest.mark.parametrize(
    "use",
    [
        embed_smooth,
        axis_of_symmetry,
        least_hyperbolic,
        AxisymmetricEmbedding.of,
        SurfaceData,
        lambda metric: triangulate_metric(metric, 100),
        lambda metric: triangulate_metric(metric, 100, zone=(0, 1)),
        lambda metric: gaussian_curvature(metric, np.eye(3)),
    ],
)
def test_functions_are_no_metrics(use):
    with pytest.raises(InvalidMetric, match=r"the metric is a function, .* AngleMetric makes one"):
        use(lambda theta, phi: (1.0, 0.0, np.sin(theta) ** 2))


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            lambda tt, tp, pp: (tt, 10.0 * tt, pp),
            "q_tt, q_tp, q_pp = 2.3754, 23.754, 0.306841 at theta = 0.3",
        ),
        (lambda tt, tp, pp: (tt, tp, np.nan * pp), "nan at theta = 0.3, phi = 2.5"),
        (lambda tt, tp, pp: (-tt, tp, pp), "not a positive definite metric"),
    ],
)
def test_what_is_no_metric_is_refused_with_its_place(spoil, said):
    metric = AngleMetric(lambda theta, phi: spoil(*components(theta, phi)))
    u = np.array([[np.sin(0.3) * np.cos(2.5), np.sin(0.3) * np.sin(2.5), np.cos(0.3)]])
    with pytest.raises(InvalidMetric, match=said):
        metric.tensor(u)


class Given:
    """A metric by a function of directions."""

    def __init__(self, tensor):
        self.tensor = tensor


@pytest.mark.parametrize(
    "use",
    [
        embed_smooth,
        least_hyperbolic,
        lambda metric: embed_surface(SurfaceData(metric)),
        lambda metric: triangulate_metric(metric, 100),
        lambda metric: triangulate_metric(metric, 100, zone=(0, 1)),
        lambda metric: gaussian_curvature(metric, np.eye(3)),
    ],
)
@pytest.mark.parametrize(
    ("tensor", "said"),
    [
        (lambda u: (1 + 0.2 * u[:, 2])[:, None, None] ** 2 * np.eye(3), "P q P with P = I - u u"),
        (lambda u: np.tile(np.eye(2), (len(u), 1, 1)), r"2, 2\) for u of shape \(\d+, 3\), not"),
        (lambda u: np.eye(3), r"the shape \(3, 3\)"),
        (lambda u: None, r"the shape \(\)"),
    ],
    ids=["not tangent", "two components", "one matrix", "nothing"],
)
def test_tensors_act_on_tangent_vectors_in_space(use, tensor, said):
    # A conformal factor times the unit matrix is not a metric: its determinant is not that of the surface.
    with pytest.raises(InvalidMetric, match=said):
        use(Given(tensor))


@pytest.mark.parametrize(
    ("metric", "said"),
    [
        (
            PulledBack(lambda u: 2 * u),
            r"the differential has the shape \((\d+), 3\) for u of shape \(\1, 3\), not",
        ),
        (PulledBack(lambda u: A), r"the differential has the shape \(3, 3\)"),
        (PulledBack(LINEAR.differential, lambda u: np.eye(3)), r"the ambient metric has the shape \(3, 3\)"),
    ],
    ids=["the map", "one matrix", "one ambient"],
)
def test_shapes_of_differentials(metric, said):
    with pytest.raises(InvalidMetric, match=said):
        embed_smooth(metric)


def test_advice_for_tensors_that_are_not_tangent():
    def tensor(u):
        P = np.eye(3) - u[:, :, None] * u[:, None, :]
        return P @ ((1 + 0.2 * u[:, 2])[:, None, None] ** 2 * np.eye(3)) @ P

    area = 4 * np.pi * (1 + 0.2**2 / 3)
    assert abs(embed_smooth(Given(tensor)).area / area - 1) < 1e-12
