"""Surfaces through points and meshes of files: star-shaped ones as before, others as maps."""

import numpy as np
import pytest

import mapped_shapes
from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrSchild, horizon_data, read_horizon
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon import coordinate_surface
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from mapped_shapes import mesh


def from_file(tmp_path, shape, n, faces=True, **more):
    x, triangles, _ = mesh(shape, n)
    path = tmp_path / "surface.npz"
    np.savez(path, points=x, **({"faces": triangles[:, ::-1]} if faces else {}), **more)
    return read_horizon(path)


def test_what_the_center_does_not_see_is_mapped(tmp_path):
    found = from_file(tmp_path, mapped_shapes.banana, 400)
    surface = coordinate_surface(found)
    assert isinstance(surface, MappedSurface)
    np.testing.assert_allclose(surface.points(surface.directions), found.points, atol=1e-5)
    exact = MappedSurface.from_map(mapped_shapes.banana)
    assert surface.mean_radius == pytest.approx(exact.mean_radius, rel=1e-6)
    np.testing.assert_allclose(surface.center, exact.center, atol=1e-5)


def test_long_bodies_are_mapped_and_others_are_not(tmp_path):
    assert isinstance(coordinate_surface(from_file(tmp_path, mapped_shapes.ellipsoid, 300)), MappedSurface)
    round_ = from_file(tmp_path, lambda u: u * (2.0 + 0.1 * u[:, :1] ** 3), 300)
    surface = coordinate_surface(round_)
    assert isinstance(surface, StarSurface)
    expected = StarSurface.from_points(round_.points, round_.center)
    np.testing.assert_array_equal(surface.coefficients, expected.coefficients)


def test_triangles_that_are_too_coarse_for_a_map_leave_a_star_shape(tmp_path):
    found = from_file(tmp_path, lambda u: u * (2.0 + 0.7 * np.sin(7.0 * u[:, :1])), 60)
    assert isinstance(coordinate_surface(found), StarSurface)


def test_horizon_of_a_mesh(tmp_path):
    hole = KerrSchild(1.0, (0.0, 0.0, 0.6))
    spheroid = StarSurface.from_radius(hole.spheroid(hole.horizon))
    x, faces, _ = mesh(spheroid.points, 300)
    outside = np.array([2.5, 0.0, 0.0])
    found = CoordinateShape(x, faces, outside, fields={"expansion": np.zeros(300)})
    data, facts = horizon_data(found, hole)
    assert data.marginal
    assert facts.report["points"] == 300
    np.testing.assert_allclose(facts.report["center"], 0.0, atol=1e-5)


def test_curvature_in_the_file_is_compared_where_the_vertices_are(tmp_path):
    x, faces, _ = mesh(mapped_shapes.ellipsoid, 400)
    a = np.array([3.0, 2.0, 1.0])
    K = 1.0 / (np.prod(a) * np.sum(x**2 / a**4, axis=1)) ** 2
    found = CoordinateShape(x, faces, np.array([0.5, 0.0, 0.0]), fields={"gaussian_curvature": K})
    check = horizon_data(found, KerrSchild(1e-30, (0.0, 0.0, 0.0)), marginal=False)[1].curvature_check
    assert check.agrees
    assert check.relative < 1e-6


@pytest.mark.parametrize(
    ("shape", "sentence"),
    [
        (mapped_shapes.banana, "not complete, or not star-shaped about it, which takes triangles"),
        (
            lambda u: u * (2.0 + 1.5 * (-1.0) ** np.arange(len(u)))[:, None],
            r"surface.npz: a surface r\(u\) about the center .* misses the points by .* % of its radius: "
            "they are not star-shaped about it, and other shapes take triangles",
        ),
    ],
)
def test_points_without_triangles_that_are_not_star_shaped(tmp_path, shape, sentence):
    path = tmp_path / "surface.npz"
    np.savez(path, points=shape(fibonacci_directions(500)))
    with pytest.raises((FileError, InvalidParameter), match=sentence):
        coordinate_surface(read_horizon(path))
