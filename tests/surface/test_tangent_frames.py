"""A surface in a space form, seen from its points and faces."""

import numpy as np
import pytest

from isoembed.gallery import Ellipsoid, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.space.models import from_model, to_model
from isoembed.surface.fit_loops import seen_from
from isoembed.surface.shape_operator import normal_curvatures, shape_operators
from isoembed.surface.tangent_frames import carried_to_faces, directions, drawn_faces

AXES = np.array([0.7, 0.5, 0.4])
CURVATURES = (-1.0, 0.0, 1.0)


def ellipsoid(k, n):
    """Points on the surface that is an ellipsoid in the conformal model, and its exact shape operators.

    Where lengths are L times the Euclidean ones, ``B = (B_E + d log L / dn) / L``.
    """
    p, faces = triangulate(Ellipsoid(tuple(AXES)), n)
    gradient = 2 * p / AXES**2
    size = np.linalg.norm(gradient, axis=1)
    normals = gradient / size[:, None]
    tangential = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    euclidean = tangential @ (np.diag(2 / AXES**2) / size[:, None, None]) @ tangential
    factor = 1 / (1 + k * np.sum(p * p, axis=1) / 4)
    outward = -k / 2 * np.sum(p * normals, axis=1) * factor
    exact = (euclidean + outward[:, None, None] * tangential) / factor[:, None, None]
    return Triangulation(faces), from_model(Space(k), p, "conformal"), exact


@pytest.mark.parametrize("k", CURVATURES)
def test_shape_operators_are_of_fourth_order(k):
    errors = []
    for n in (500, 2000):
        triangulation, x, exact = ellipsoid(k, n)
        errors.append(np.abs(shape_operators(triangulation, x, 4, Space(k)) - exact).max())
    assert errors[1] < 0.03 and errors[0] / errors[1] > 8


@pytest.mark.parametrize("k", CURVATURES)
def test_normal_curvatures_of_a_sphere(k):
    space, errors = Space(k), []
    curvature = float(space.cs(0.8) / space.sn(0.8))
    for n in (300, 1200):
        p, faces = triangulate(Ellipsoid((1.0, 1.0, 1.0)), n)
        triangulation, x = Triangulation(faces), float(space.sn(0.8)) * p
        B = shape_operators(triangulation, x, 4, space)
        errors.append(np.abs(normal_curvatures(triangulation, x, B, space) / curvature - 1).max())
    assert errors[0] < 0.1 and errors[0] / errors[1] > 6


@pytest.mark.parametrize("k", CURVATURES)
def test_points_seen_from_one_another(k):
    space, rng = Space(k), np.random.default_rng(1)
    x = 0.3 * rng.standard_normal((2, 3))
    seen = seen_from(0, 1, x, space.heights(x), k)
    assert np.allclose(seen, to_model(space, space.translated(x[1], -x[0]), "conformal"), rtol=1e-14)
    assert np.allclose(seen / np.linalg.norm(seen), directions(space, x[:1], x[1:])[0], rtol=1e-14)


@pytest.mark.parametrize("k", CURVATURES)
def test_tensors_turn_with_the_directions_at_the_corners(k):
    space, faces = Space(k), np.array([[0, 1, 2]])
    x = 0.3 * np.random.default_rng(2).standard_normal((3, 3))
    drawn = from_model(space, drawn_faces(space, faces, x)[0], "conformal")
    assert np.allclose(space.distances(drawn, drawn[[1, 2, 0]]), space.distances(x, x[[1, 2, 0]]), rtol=1e-14)
    for other in ([1, 2, 0], [2, 0, 1]):
        before, after = directions(space, x, x[other]), directions(space, drawn, drawn[other])
        carried = carried_to_faces(space, faces, x, before[:, :, None] * before[:, None, :])[0]
        assert np.allclose(carried, after[:, :, None] * after[:, None, :], rtol=0, atol=1e-14)
