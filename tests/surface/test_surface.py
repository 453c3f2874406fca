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


@pytest.mark.parametrize(
    ("curvature", "scale"), [(0.0, 1e-200), (0.0, 1e-7), (0.0, 1e200), (-1.0, 1e-7), (1e-3, 1e100)]
)
def test_the_unit_is_that_of_the_edges_by_default(curvature, scale):
    x, faces = zoo.icosphere(1)
    t, space = isoembed.Triangulation(faces), isoembed.Space(curvature)
    one, other = Surface(t, x, space), Surface(t, scale * x, space.scaled(scale))
    lengths = other.lengths / scale
    assert other.unit <= other.lengths.mean() <= 2 * other.unit
    assert lengths == pytest.approx(one.lengths, rel=1e-14)
    assert other.mean_curvature * scale == pytest.approx(one.mean_curvature, rel=1e-12)
    assert other.bending_energy == pytest.approx(one.bending_energy, rel=1e-12)
    assert other.fine_roughness == pytest.approx(one.fine_roughness, rel=1e-6)
    assert np.array_equal(other.concave_edges, one.concave_edges)


def test_arrays_are_read_only_and_texts_short():
    x, faces = zoo.cube()
    t, flat = isoembed.Triangulation(faces), np.zeros(8, dtype=bool)
    for surface in (Surface(t, x), Surface(t, x, flat_vertices=flat)):
        faces = surface.flat_faces
        for array in (faces.of_triangles, faces.sides, faces.edges, *surface.seams):
            assert not array.flags.writeable
        assert max(len(repr(each)) for each in (surface, faces, surface.seams)) < 200
    assert flat.flags.writeable and not surface.flat_vertices.flags.writeable


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
