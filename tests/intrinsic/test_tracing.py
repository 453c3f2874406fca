"""Straight lines across triangles: against the plane that a folded square unfolds to."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import modulo, third_corner, total_angle
from isoembed.intrinsic.polygon_loops import from_corner, from_inside, place, sector, straight
from isoembed.intrinsic.polygons import lay_out
from sprinkled import box, checked, tables_of

angles = st.floats(0, 2 * np.pi)


def square():
    """The unit square covered twice, cut along the diagonal from 0 to 2 above and from 1 to 3 below."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return vertices, tables_of(vertices, np.array([[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]]))


def laid_out(tables):
    """Every triangle in a frame of its own, with its first half-edge along the x axis."""
    return lay_out(tables, np.ones(tables.twins.size, dtype=bool))


def end_of(state, length, vertices, tables):
    """Where a line ends in space, and in which face."""
    state = straight(state, length, laid_out(tables).views)
    out = state[0]
    halfedges = 3 * (out // 3) + np.arange(3)
    plane = np.array([place(h, state, laid_out(tables).views) for h in halfedges])
    weights = np.linalg.solve(np.vstack([plane.real, plane.imag, np.ones(3)]), [length, 0, 1])
    assert weights.min() > -1e-9
    return weights @ vertices[tables.corners[halfedges]], out // 3


def folded(x, y):
    """A point of the plane folded up to the square, and whether it is below."""
    sides = np.floor([x, y])
    within = np.array([x, y]) - sides
    return np.where(sides % 2 == 0, within, 1 - within), int(sides.sum()) % 2


@given(st.floats(0.01, np.pi / 2 - 0.01), st.floats(0.01, 200))
def test_from_a_corner_of_a_square_covered_twice(angle, length):
    vertices, tables = square()
    # Half-edge 0 runs along the x axis; the total angle is pi, and half of it is above.
    h, offset = sector(3, tables.directions[0] + angle, np.pi, tables.views)
    assert tables.corners[h] == 0 and 0 <= offset < np.pi / 2
    end, face = end_of(from_corner(h, offset, laid_out(tables).views), length, vertices, tables)
    place, below = folded(length * np.cos(angle), length * np.sin(angle))
    assert end[:2] == pytest.approx(place, abs=1e-10)
    if np.abs(place - np.round(place)).min() > 1e-9:
        assert face // 2 == below


@given(st.floats(0.01, 0.98), st.floats(0.01, 0.98), angles, st.floats(0, 200))
def test_from_inside_a_square_covered_twice(x, y, angle, length):
    vertices, tables = square()
    if y > x:
        x, y = y, x  # in face 0, whose first half-edge is the x axis
    end, face = end_of(from_inside(0, complex(x, y), angle, laid_out(tables).views), length, vertices, tables)
    place, below = folded(x + length * np.cos(angle), y + length * np.sin(angle))
    assert end[:2] == pytest.approx(place, abs=1e-10)
    if np.abs(place - np.round(place)).min() > 1e-9:
        assert face // 2 == below


@pytest.mark.parametrize("x", [0.25, 0.5, 0.75])
@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_along_and_across_the_sides_of_a_face(x, turns):
    vertices, tables = square()
    angle = turns * np.pi / 2
    end, _ = end_of(from_inside(0, complex(x, 0.0), angle, laid_out(tables).views), 0.125, vertices, tables)
    place, _ = folded(x + 0.125 * np.cos(angle), 0.125 * np.sin(angle))
    assert end[:2] == pytest.approx(place, abs=1e-15)


def test_once_around_a_box():
    vertices, faces, _ = box(3, (1.0, 2.0, 3.0))
    tables = tables_of(vertices, faces)
    f = int(np.flatnonzero((vertices[faces][:, :, 2] == 3).all(axis=1))[0])
    a, b, c = vertices[faces[f]]
    start = 0.3 * a + 0.3 * b + 0.4 * c
    along = (b - a) / np.linalg.norm(b - a)
    across = np.cross([0, 0, 1], along)
    x, y = (start - a) @ along, (start - a) @ across
    for way, around in ((0.0, 2 * (2 + 3)), (np.pi / 2, 2 * (1 + 3))):
        angle = way if abs(along[1]) == 1 else way + np.pi / 2
        end, face = end_of(
            from_inside(f, complex(x, y), angle, laid_out(tables).views), around, vertices, tables
        )
        assert face == f
        assert end == pytest.approx(start, abs=1e-13)


@given(st.integers(0, 10**6), angles)
def test_every_direction_is_in_one_sector(seed, direction):
    tables = tables_of(*zoo.random_hull(10, seed))
    corner_angles = checked(tables).triangles.angles.ravel()
    for h in range(tables.corners.size):
        total = total_angle(h, tables.views)
        deficit = checked(tables).deficits[tables.corners[h]]
        assert total == pytest.approx(2 * np.pi - deficit, rel=1e-12)
        g, offset = sector(h, direction, total, tables.views)
        assert tables.corners[g] == tables.corners[h]
        assert -1e-12 < offset < corner_angles[g] + 1e-12
        turns = (tables.directions[g] + offset - direction) / total
        assert turns == pytest.approx(round(turns), abs=1e-12)


def test_a_tetrahedron_unfolds_to_the_lattice_of_triangles():
    vertices, faces = zoo.tetrahedron()
    tables = tables_of(vertices, faces)
    l = tables.lengths[0]
    # No line from a vertex comes back to it: where it meets a vertex, that is one of the other three.
    for m, n in ((1, 0), (1, 1), (2, 1), (3, 1), (3, 2), (5, 3)):
        along, far = np.arctan2(n * 3**0.5 / 2, m + n / 2), l * np.sqrt(m * m + m * n + n * n)
        h, offset = sector(0, tables.directions[0] + along, np.pi, tables.views)
        end, _ = end_of(from_corner(h, offset, laid_out(tables).views), far * (1 - 1e-13), vertices, tables)
        nearest = int(np.argmin(np.linalg.norm(vertices - end, axis=1)))
        assert np.linalg.norm(vertices[nearest] - end) < 1e-10
        assert nearest != tables.corners[0]


def test_absurdly_far():
    _, tables = square()
    assert straight(from_corner(0, 0.1, laid_out(tables).views), np.inf, laid_out(tables).views)[0] == -1


def test_modulo():
    assert [modulo(x, 3.0) for x in (-0.5, 0.0, 2.5, 3.0, 7.0)] == [2.5, 0.0, 2.5, 0.0, 1.0]


@given(st.floats(0.1, 10), st.floats(0.1, 3), st.floats(-5, 5), angles)
def test_third_corner_is_to_the_left(base, height, foot, angle):
    corners = np.array([[0.0, 0], [base, 0], [foot, height]])
    lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    tables = HalfEdges(np.arange(3), np.arange(3), lengths, np.zeros(3))
    c, s = np.cos(angle), np.sin(angle)
    p, q, r = corners @ [1, 1j] * (c + 1j * s) + (1.0 - 2.0j)
    assert third_corner(0, p, q, tables.views) == pytest.approx(r, abs=1e-9)
    assert third_corner(1, q, r, tables.views) == pytest.approx(p, abs=1e-9)


def test_a_line_without_a_direction_leads_nowhere():
    _, tables = square()
    polygons = laid_out(tables).views
    assert straight(from_corner(0, np.nan, polygons), 1.0, polygons)[0] == -1
