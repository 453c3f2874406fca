"""Orientation of embedded surfaces of a slice: onto their coordinates there."""

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity import KerrSchild, StarSurface, embed_surface, wang_yau
from isoembed.smooth.two_metric import area_density
from isoembed.surface.measures import face_areas

U = fibonacci_directions(200)
SPINS = [
    0.3 * np.array([np.sin(0.5) * np.cos(t), np.sin(0.5) * np.sin(t), np.cos(0.5)]) for t in (0, 0.2, 0.4)
]
"""Of a hole that precesses."""


def horizon(spin):
    slice_ = KerrSchild(1.0, spin)
    return StarSurface.from_radius(slice_.spheroid(slice_.horizon)).data(slice_, marginal=True)


def rotation(before, after):
    """That of the plane of two vectors of one length which takes one to the other."""
    a, b = (v / np.linalg.norm(v) for v in (before, after))
    c = np.cross(a, b)
    W = np.array([[0.0, -c[2], c[1]], [c[2], 0.0, -c[0]], [-c[1], c[0], 0.0]])
    return np.eye(3) + W + W @ W / (1.0 + a @ b)


def short_axis(surface):
    """Of least moment."""
    u, weights = gauss_rule(32, 64)
    X = surface.embedding.points(u)
    return np.linalg.eigh((X.T * weights * area_density(surface.data.metric.tensor(u))) @ X)[1][:, 0]


@pytest.fixture(scope="module")
def sequence():
    found = [embed_surface(horizon(SPINS[0]), vertices=100)]
    for spin in SPINS[1:]:
        found.append(embed_surface(horizon(spin), start=found[-1]))
    return found


def test_the_short_axis_of_a_horizon_is_that_of_its_spin(sequence):
    for spin, surface in zip(SPINS, sequence, strict=True):
        assert np.linalg.norm(np.cross(short_axis(surface), spin / np.linalg.norm(spin))) < 1e-10


def test_the_horizon_of_a_precessing_hole_turns_with_it(sequence):
    first = sequence[0].embedding
    for spin, surface in zip(SPINS, sequence, strict=True):
        Q = rotation(SPINS[0], spin)
        assert np.abs(surface.embedding.points(U) - first.points(U @ Q) @ Q.T).max() < 1e-7


def test_the_density_of_the_angular_momentum(sequence):
    for spin, surface in zip(SPINS, sequence, strict=True):
        np.testing.assert_allclose(surface.spin.axis, spin / 0.3, atol=1e-8)
    tables = sequence[-1].mesh(1000)
    faces, density = tables["faces"], tables["angular_momentum_density"]
    areas = face_areas(faces, tables["vertices"])
    assert areas @ density[faces].mean(axis=1) == pytest.approx(0.3, rel=1e-2)
    assert density.min() > -1e-12  # nothing turns the other way


def test_a_surface_is_turned_onto_its_points_in_the_slice_not_onto_directions():
    slice_ = KerrSchild(1.0, SPINS[0])
    surface = StarSurface.from_radius(
        lambda u: 4.0 + 0.2 * u[:, 0] * u[:, 1] ** 2 + 0.3 * u[:, 2], (0.1, 0.0, 0.2)
    )
    data = surface.data(slice_)
    assert np.abs(data.shape(U) - surface.points(U)).max() == 0.0
    found = embed_surface(data, vertices=100).embedding
    u, weights = gauss_rule(32, 64)
    areas = weights * area_density(data.metric.tensor(u))
    moment = (found.points(u).T * areas) @ (surface.points(u) - areas @ surface.points(u) / areas.sum())
    assert np.abs(moment - moment.T).max() < 1e-12 * np.abs(moment).max()  # no rotation brings them nearer


def test_the_surface_of_a_time_function_is_turned_like_that_of_none():
    slice_ = KerrSchild(1.0, (0.0, 0.0, 0.3))
    data = StarSurface.from_radius(slice_.spheroid(6.0)).data(slice_)
    surface = embed_surface(data, vertices=100)
    tau = wang_yau(data, lambda u: 0.4 * u[:, 2], embedding=surface.embedding).embedding
    X = tau.points(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
    assert np.abs(X[0, :2]).max() < 1e-8 and X[0, 2] > 5.0
    assert abs(X[1, 1]) < 1e-8 and X[1, 0] > 5.0
