"""Surfaces and what is measured on them."""

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.surface.surface import Surface


def test_a_cube_in_any_unit():
    x, faces = zoo.cube()
    t = isoembed.Triangulation(faces)
    side = np.ptp(x[:, 0])
    for unit in (2.0**-600, 1.0, 2.0**300):
        cube = Surface(t, unit * x, unit=unit)
        assert cube.area == pytest.approx(6 * (side * unit) ** 2)
        assert cube.integrated_mean_curvature == pytest.approx(3 * np.pi * side * unit)
        assert np.allclose(np.sort(cube.dihedral_angles)[6:], np.pi / 2)
        assert not cube.concave_edges.any() and not len(cube.self_intersections)


def test_polygons_of_a_polyhedron():
    x, faces = zoo.cube()
    t = isoembed.Triangulation(faces)
    triangles = Surface(t, x)
    cube = Surface(t, x, flat_vertices=np.zeros(8, dtype=bool))
    assert triangles.flat_faces.polygons is t.faces and len(triangles.flat_faces) == 12
    assert len(cube.flat_faces) == 6 and cube.flat_faces.sides.tolist() == [4] * 6
    assert cube.flat_faces.edges.sum() == 12
    assert np.allclose(cube.mean_curvature, cube.mean_curvature[0])  # wherever the diagonals are


def test_vertices_that_are_none_are_refused():
    x, faces = zoo.cube()
    t = isoembed.Triangulation(faces)
    with pytest.raises(ValueError, match=r"shape \(7, 3\), not \(8, 3\)"):
        Surface(t, x[:7])
    x[5, 1] = np.nan
    with pytest.raises(ValueError, match=r"vertex 5 has the coordinates .* not finite"):
        Surface(t, x)


def test_vertices_are_copied():
    x, faces = zoo.cube()
    surface = Surface(isoembed.Triangulation(faces), x)
    x[0] = 7.0
    assert surface.vertices[0].max() < 7.0
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices[0] = 0.0
