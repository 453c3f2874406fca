"""Axes of symmetry of metrics, wherever they point."""

import numpy as np
import pytest

from isoembed.errors import InvalidMetric
from isoembed.relativity import (
    BrillLindquist,
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrSchild,
    StarSurface,
    embed_surface,
    find_horizon,
)
from isoembed.smooth import AxisymmetricEmbedding, PulledBack
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.symmetry import axis_of_symmetry

AXES = [(0.0, 0.6, 0.8), (1.0, 2.0, -3.0), (1.0, 0.0, 0.0), (1e-3, 0.0, -1.0)]


class Turned:
    def __init__(self, metric, Q, unit=1.0):
        self.metric, self.Q, self.unit = metric, Q, unit

    def tensor(self, u):
        return self.unit**2 * (self.Q @ self.metric.tensor(u @ self.Q) @ self.Q.T)


class Deformed:
    def __init__(self, metric, size):
        self.metric, self.size = metric, size

    def tensor(self, u):
        factor = 1.0 + self.size * (u[:, 0] ** 3 - 3.0 * u[:, 0] * u[:, 1] ** 2)
        return factor[:, None, None] * self.metric.tensor(u)


def frame(axis):
    """A rotation that takes z to an axis, and turns about it."""
    z = np.array(axis) / np.linalg.norm(axis)
    x = np.cross(z, [0.3, -0.8, 0.4])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def linear(*axes):
    return PulledBack(lambda u: np.broadcast_to(np.diag(axes), (len(u), 3, 3)))


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(
    "metric", [KerrNewmanHorizon(1.0, 0.3), KerrNewmanHorizon(1.0, 0.9), KerrNewmanErgosphere(0.3)]
)
def test_a_turned_axis_is_found(metric, axis):
    R = axis_of_symmetry(Turned(metric, frame(axis), 1e6))
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
    assert np.linalg.norm(np.cross(R[:, 2], axis)) <= 2e-13 * np.linalg.norm(axis)
    assert np.linalg.det(R) > 0.0 and R[2, 2] >= 0.0


def test_z_stays_z():
    for metric in (linear(1.0, 1.0, 1.0), linear(2.0, 2.0, 1.0), KerrNewmanHorizon(1.0, 0.5)):
        np.testing.assert_array_equal(axis_of_symmetry(metric), np.eye(3))


@pytest.mark.parametrize("metric", [linear(3.0, 2.0, 1.0), linear(1.0, 2.0, 2.0 + 1e-9)])
def test_there_is_none(metric):
    assert axis_of_symmetry(metric) is None


def test_two_invariants_alone_do_not_make_an_axis():
    """The Hopf field twists a sphere's eigendirections so that the density and the trace are symmetric."""

    class Twisted:
        def tensor(self, u):
            x, y, z = u.T
            e = np.stack([-z, np.zeros_like(z), x], axis=1)  # about y
            f = np.cross(u, e)
            angle = 2.0 * np.arctan2(x, z)  # not symmetric about y
            g = np.cos(angle)[:, None] * e + np.sin(angle)[:, None] * f
            return (
                np.eye(3)
                - u[:, :, None] * u[:, None, :]
                + 0.3 * g[:, :, None] * g[:, None, :] * (1.0 + y[:, None, None])
            )

    assert axis_of_symmetry(Twisted()) is None


def test_what_is_no_metric_is_refused():
    with pytest.raises(InvalidMetric, match="not finite at theta"):
        axis_of_symmetry(Turned(linear(1.0, 2.0, 3.0), np.diag([1.0, 1.0, np.nan])))


@pytest.mark.parametrize("a", [0.86, 0.867])
def test_tilted_horizons_of_a_slice_are_decided_exactly(a):
    slice_ = KerrSchild(1.0, (0.0, a * np.sin(0.7), a * np.cos(0.7)))
    metric = StarSurface.from_radius(slice_.spheroid(slice_.horizon)).metric(slice_)
    R = axis_of_symmetry(metric)
    profile = AxisymmetricEmbedding.of(metric_in(metric, SphereMap.linear(R)))
    exact = AxisymmetricEmbedding.of(KerrNewmanHorizon(1.0, a))
    assert profile.embeds == exact.embeds == (a < np.sqrt(3.0) / 2.0)
    if exact.embeds:
        assert abs(profile.integrated_mean_curvature / exact.integrated_mean_curvature - 1.0) < 1e-13


def test_a_tilted_horizon_is_a_surface_of_revolution_to_the_rounding_of_its_harmonics():
    """Two holes shortly before K < 0 at the waist; tilted, the metric is symmetric to 2.4e-12 only."""
    curvatures = []
    for R in (np.eye(3), frame((0.36, -0.53, 0.76))):
        found = find_horizon(BrillLindquist((0.5, 0.5), [tuple(0.314 * R[:, 2]), tuple(-0.314 * R[:, 2])]))
        embedding = embed_surface(found.data()).embedding
        assert embedding.harmonics.order < embedding.harmonics.degree
        curvatures.append(embedding.gaussian_curvature(R[:, :1].T)[0])
    assert abs(curvatures[1] - curvatures[0]) < 1e-12


def test_a_metric_that_deviates_by_more_than_rounding_has_no_axis():
    def bumpy(size):
        return Deformed(linear(2.0, 2.0, 1.0), size)

    assert axis_of_symmetry(bumpy(1e-12)) is not None
    assert axis_of_symmetry(bumpy(1e-10)) is None
