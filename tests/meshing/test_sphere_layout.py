"""Layouts of triangulations on the unit sphere: no triangle turns over, little is distorted."""

import numpy as np
import pytest

import mapped_shapes
import zoo
from isoembed.meshing.sphere_layout import _Distortion, least_distorted, sphere_layout
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.triangles import Triangles


def distortion(metric):
    return _Distortion(metric.triangulation, Triangles.of(metric.face_lengths))


def outward(metric, u):
    a, b, c = u[metric.faces].transpose(1, 0, 2)
    return np.einsum("fi,fi->f", a, np.cross(b, c))


@pytest.mark.parametrize("shape", ["banana", "bowl", "peanut", "ellipsoid"])
def test_no_triangle_turns_over_and_all_have_room(shape):
    vertices, faces, _ = mapped_shapes.mesh(getattr(mapped_shapes, shape), 800)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    u = sphere_layout(metric)
    np.testing.assert_allclose(np.linalg.norm(u, axis=1), 1.0, rtol=1e-15)
    assert (outward(metric, u) > 0.0).all()
    energy, *_ = distortion(metric).at(u)
    # Four times the area is the least of all; the banana's conformal layout has 8 times as much.
    assert 16 * np.pi * 0.999 < energy < 16 * np.pi * 1.35


def test_the_slope_is_that_of_the_energy():
    vertices, faces = zoo.icosphere(1)
    energy = distortion(PolyhedralMetric.from_mesh(mapped_shapes.ellipsoid(vertices), faces))
    rng = np.random.default_rng(0)
    u, v = vertices + 0.05 * rng.normal(size=vertices.shape), rng.normal(size=vertices.shape)
    u /= np.linalg.norm(u, axis=1, keepdims=True)

    def moved(t):
        w = u + t * v
        return energy.at(w / np.linalg.norm(w, axis=1, keepdims=True))[0]

    expected = (8 * (moved(1e-4) - moved(-1e-4)) - moved(2e-4) + moved(-2e-4)) / 12e-4
    assert np.sum(energy.at(u)[1] * v) == pytest.approx(expected, rel=1e-7, abs=1e-8 * energy.at(u)[0])


def test_a_round_sphere_stays_one():
    vertices, faces = zoo.icosphere(2)
    metric = PolyhedralMetric.from_mesh(1e-40 * vertices, faces)
    u = sphere_layout(metric)
    chords = np.linalg.norm(u[metric.edges[:, 0]] - u[metric.edges[:, 1]], axis=1)
    np.testing.assert_allclose(chords, 1e40 * metric.lengths, rtol=1e-2)


def test_what_is_turned_over_is_left_alone():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    np.testing.assert_array_equal(least_distorted(metric, -vertices), -vertices)
