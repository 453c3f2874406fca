"""The pose of a surface: pictures can be repeated, however the surface was turned and rounded."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import zoo
from isoembed.gallery import Ellipsoid, KerrHorizon, triangulate
from isoembed.plot.view import Pose, View

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
BODIES = {
    "octahedron": lambda: OCTAHEDRON,
    "disk": lambda: OCTAHEDRON * [1, 1, 0.5],
    "rod": lambda: OCTAHEDRON * [1, 1, 2],
    "sphere": lambda: zoo.icosphere(2)[0],
    "ellipsoid": lambda: zoo.icosphere(2)[0] * [1, 3, 2],
    "flat": lambda: OCTAHEDRON * [1, 2, 0],
    "horizon": lambda: triangulate(KerrHorizon(), 100)[0],
    "irregular": lambda: triangulate(Ellipsoid((3, 2, 1)), 100, irregular=1)[0],
}


@pytest.mark.parametrize("name", BODIES)
def test_a_body_has_one_pose(name):
    vertices = BODIES[name]()
    posed = Pose.of(vertices).put(vertices)
    extents = np.ptp(posed, axis=0)
    assert np.linalg.det(Pose.of(vertices).axes) == pytest.approx(1)
    if name not in ("octahedron", "sphere", "horizon"):
        assert extents[0] >= (1 - 1e-9) * extents[1] >= (1 - 1e-6) * extents[2]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        turned = Rotation.random(random_state=seed).apply(vertices) * 7 + rng.normal(size=3)
        turned *= 1 + 1e-13 * rng.normal(size=turned.shape)
        np.testing.assert_allclose(Pose.of(turned).put(turned), posed, atol=1e-9)


def cap():
    """The part of a sphere above z = .5, and its faces."""
    vertices, faces = zoo.icosphere(3)
    above = faces[(vertices[faces][:, :, 2] > 0.5).all(axis=1)]
    used, faces = np.unique(above, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


@pytest.mark.parametrize("seed", range(4))
def test_the_outer_side_of_a_cap_is_up(seed):
    vertices, faces = cap()
    vertices = Rotation.random(random_state=seed).apply(vertices)
    view = View.of(vertices, faces)
    np.testing.assert_array_less(0.0, view.light[~view.inside])
    assert view.pose.put(vertices)[faces].mean(axis=1)[:, 2].max() > 0
    posed = view.pose.put(vertices)
    a, b, c = (posed[faces[:, k]] for k in range(3))
    assert np.cross(b - a, c - a)[:, 2].min() > 0
    assert not view.inside.all()


def test_both_sides_of_an_open_surface_are_drawn():
    vertices, faces = cap()
    both = View.of(vertices, faces[:, ::-1])  # turned over, it hangs
    assert len(both.faces) == len(faces)
    tube = zoo.icosphere(3)
    band = tube[1][(np.abs(tube[0][tube[1]][:, :, 2]) < 0.5).all(axis=1)]
    used, band = np.unique(band, return_inverse=True)
    view = View.of(tube[0][used], band.reshape(-1, 3))
    assert 0.2 < view.inside.mean() < 0.8
    white = np.ones((len(view.faces), 3))
    assert (view.shade(white)[view.inside] < view.shade(white)[~view.inside].max()).all()


def test_of_a_closed_surface_only_the_front_is_drawn():
    vertices, faces = zoo.icosphere(2)
    view = View.of(vertices, faces)
    assert not view.inside.any()
    assert len(view.faces) < len(faces)
