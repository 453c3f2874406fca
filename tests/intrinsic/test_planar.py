"""Polygons of triangles: unfolded into the plane, and searched for a point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.intrinsic.flat_vertices import remove_flat_vertices
from isoembed.intrinsic.insertion_loops import face_at
from isoembed.intrinsic.polygon_loops import first_sides
from isoembed.intrinsic.polygons import Polygons, lay_out
from sprinkled import box, polyhedron, tables_of

plane = st.floats(0, 2)


def cube():
    vertices, faces, flat = box(2)
    core, _ = remove_flat_vertices(tables_of(vertices, faces), flat)
    return polyhedron(core, vertices[~flat])


@pytest.mark.parametrize("opened", [0, 1, 3])
def test_coordinates_are_those_of_the_triangles(opened):
    tables, bent = cube()
    dropped = np.flatnonzero(bent)[:opened]
    bent[dropped] = bent[tables.twins[dropped]] = False
    _, _, z, fixed, cells, _ = lay_out(tables, bent)
    sides = np.abs(np.roll(z.reshape(-1, 3), -1, axis=1).ravel() - z)
    assert sides == pytest.approx(tables.lengths, rel=1e-15)
    # Across what is not fixed they are continuous, and the polygon is the same.
    inside = np.flatnonzero(~fixed)
    after = np.where(tables.twins[inside] % 3 == 2, -2, 1) + tables.twins[inside]
    assert np.array_equal(z[inside], z[after])
    assert np.array_equal(cells[inside // 3], cells[tables.twins[inside] // 3])
    assert (fixed | ~bent).all()


def test_squares_are_polygons_and_what_bends_around_a_corner_is_none():
    tables, bent = cube()
    polygons = lay_out(tables, bent)
    assert np.bincount(polygons.cells).tolist() == [2] * 6
    assert np.array_equal(polygons.fixed, bent)
    polygons = lay_out(tables, np.zeros_like(bent))
    assert polygons.fixed.all() and np.bincount(polygons.cells).tolist() == [1] * 12
    # Two squares beside each other are a rectangle.
    one = int(np.flatnonzero(bent)[0])
    bent[one] = bent[tables.twins[one]] = False
    assert sorted(np.bincount(lay_out(tables, bent).cells)) == [2, 2, 2, 2, 4]


def test_first_sides():
    tables, bent = cube()
    first = first_sides(tables.twins, bent)
    assert bent[first].all()
    assert np.array_equal(first[bent], np.flatnonzero(bent))
    assert np.array_equal(tables.corners[first], tables.corners)


@given(plane, plane)
def test_a_point_in_an_l_is_found_around_the_corner(px, py):
    # Three squares on a body: from the first, the straight way to the last leads outside.
    vertices = np.array([[x, y, 0.0] for y in (0, 1, 2) for x in (0, 1, 2)] + [[1.0, 1, -1]])
    squares = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [4, 5, 8, 7]])
    top = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]])
    outline = [0, 1, 2, 5, 8, 7, 4, 3]
    skirt = [[b, a, 9] for a, b in zip(outline, np.roll(outline, -1), strict=True)]
    used, faces = np.unique(np.concatenate([top, skirt]), return_inverse=True)
    faces = faces.reshape(-1, 3)
    tables = tables_of(vertices[used], faces)
    fixed = np.zeros(tables.twins.size, dtype=bool)
    fixed[18:] = True
    fixed |= fixed[tables.twins]
    cells = np.minimum(np.arange(len(faces)), 6)
    cells[:6] = 0
    x, y = vertices[used][tables.corners, :2].T
    polygons = Polygons(tables.corners, tables.twins, x + 1j * y, fixed, cells)
    found = face_at(complex(px, py), 0, polygons.views, len(faces))
    assert found < 6
    if not (px < 1 and py > 1):
        corners = np.column_stack([x, y])[3 * found : 3 * found + 3]
        weights = np.linalg.solve(np.vstack([corners.T, np.ones(3)]), [px, py, 1])
        assert weights.min() > -1e-9


def test_an_icosahedron_of_single_faces():
    tables = tables_of(*zoo.icosahedron())
    polygons = lay_out(tables, np.ones(60, dtype=bool))
    assert np.array_equal(polygons.cells, np.arange(20))
