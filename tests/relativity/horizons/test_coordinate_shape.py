"""Closed surfaces of scattered points, and of polygons that may fold over."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from isoembed.io.files import FileError
from isoembed.relativity.horizons.coordinate_shape import middle, triangulate_star_shaped
from scattered import bumpy, is_closed_and_outward, lattice


@given(seed=st.integers(0, 1000), exponent=st.integers(-100, 100))
def test_scattered_points_become_a_closed_surface(seed, exponent):
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    center = rng.normal(size=3)
    unit = bumpy(lattice(60, seed)) @ turn.T
    points = (unit + center) * 10.0**exponent
    twice = np.concatenate([points, points[::3]])
    kept, faces = triangulate_star_shaped(twice, center * 10.0**exponent, "x")
    np.testing.assert_array_equal(kept, np.arange(60))
    assert is_closed_and_outward(unit, faces, np.zeros(3))


def test_rings_around_open_poles_and_poles_written_many_times():
    theta, phi = np.linspace(0.0, np.pi, 21), 2.0 * np.pi / 40 * np.arange(41)
    for rows, count in ((theta, 19 * 40 + 2), (theta[1:-1], 19 * 40)):
        t, p = (a.ravel() for a in np.meshgrid(rows, phi, indexing="ij"))
        u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
        kept, faces = triangulate_star_shaped(u, np.zeros(3), "x")
        assert len(kept) == count
        assert is_closed_and_outward(u[kept], faces, np.zeros(3))


@given(seed=st.integers(0, 1000))
def test_the_middle_does_not_depend_on_the_sampling(seed):
    rng = np.random.default_rng(seed)
    u = lattice(200, seed)
    u = u[u[:, 2] > -0.9 + rng.uniform(0.0, 1.0)]  # many on one side
    np.testing.assert_allclose(middle(3e8 + 1e3 * u), 3e8, atol=1e-3)


def test_points_that_are_no_surface_around_a_center():
    u = lattice(100)
    cases = [
        (np.vstack([u, 2.0 * u[7]]), (), r"x: the points 7 and 100, .* are in one direction .* star-shaped"),
        (np.vstack([u[:4], [[0.0, 0.0, 0.0]], u[4:]]), (), "point 4 is at the center"),
        (u[:3], (), "3 points: that is not a surface"),
        (np.where(np.arange(100)[:, None] == 5, np.inf, u), (), "point 5 is not finite"),
        (
            u[u[:, 2] < 0.3],
            (),
            r"no points around the direction \(.*, 0.99\d*\) from the center .* not complete",
        ),
    ]
    for points, polygons, message in cases:
        with pytest.raises(FileError, match=message):
            triangulate_star_shaped(points, np.zeros(3), "x", polygons)


@given(seed=st.integers(0, 1000), exponent=st.integers(-100, 100), far=st.sampled_from([0.0, 1.0, 1e6]))
def test_points_in_a_plane(seed, exponent, far):
    turn = Rotation.random(random_state=seed).as_matrix()
    u = lattice(50, seed)
    for flat, where in (
        ([1, 1, 0], "lie in a plane"),
        ([1, 0, 0], "lie on a line"),
        ([0, 0, 0], "are one point"),
    ):
        with pytest.raises(FileError, match=f"x: the 50 points {where}"):
            triangulate_star_shaped(10.0**exponent * (u * flat @ turn.T + far), np.zeros(3), "x")
    for thickness, refusal in ((0.5, None), (1e-6, "no points around the direction")):
        thin = 10.0**exponent * (u * [1.0, 1.0, thickness] @ turn.T + far)
        center = np.full(3, 10.0**exponent * far)
        if refusal is None:
            assert len(triangulate_star_shaped(thin, center, "x")[0]) == 50
        else:
            with pytest.raises(FileError, match=refusal):
                triangulate_star_shaped(thin, center, "x")


def test_points_on_a_cone_about_the_center():
    phi = 2.0 * np.pi / 40 * np.arange(40)
    r = 1.0 + 0.5 * np.cos(3.0 * phi)
    points = r[:, None] * np.stack([np.cos(phi), np.sin(phi), 0.0 * phi + 0.3], axis=1)
    with pytest.raises(FileError, match=r"the directions of the points .* lie in a plane: .* not complete"):
        triangulate_star_shaped(points, np.zeros(3), "x")


def test_polygons_tell_where_a_surface_folds_over():
    points = bumpy(lattice(100))
    _, faces = triangulate_star_shaped(points, np.zeros(3), "x")
    assert (
        len(triangulate_star_shaped(points, np.zeros(3), "x", list(faces[:, ::-1]))[0]) == 100
    )  # either way round
    turned = points.copy()
    turned[13] = -0.5 * points[13]
    with pytest.raises(FileError, match=r"the surface folds over at point \d+"):
        triangulate_star_shaped(turned, np.zeros(3), "x", list(faces))
