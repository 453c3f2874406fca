"""Gluing polygons: what becomes one vertex, which angles meet there, and what is refused."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gluing_polygons import shoelace, star
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing import Net, glue, rectangle, regular_polygon, zipped
from isoembed.gluing.classics import regular_faces
from isoembed.intrinsic.ears import triangulated
from isoembed.metric import curvature

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
FOLDED = [((0, k), (0, k)) for k in range(4)]


def sixty_fourths(most):
    """Numbers from 0 to most that are not so near to one another that triangles between them are lost."""
    return st.integers(0, 64 * most).map(lambda k: k / 64)


def areas(net):
    triangles = net.triangles
    return triangles.areas * triangles.unit**2


# What becomes of the polygons


def test_an_envelope():
    net = glue([SQUARE], FOLDED)
    assert repr(net) == "Net(5 vertices, 9 edges, 6 faces, mean edge length 0.647603)"
    assert net.deficits == pytest.approx([0, np.pi, np.pi, np.pi, np.pi], abs=1e-14)
    assert [some.tolist() for some in net.corners] == [[0, 0, 0, 0]]
    assert [some.tolist() for some in net.outlines] == [[0, 1, 0, 2, 0, 3, 0, 4]]
    assert net.polygons[0][1].tolist() == [0.5, 0.0]


def test_six_squares_are_a_cube():
    loops = [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    net = regular_faces(loops)
    assert net.n_vertices == 8
    assert net.deficits == pytest.approx(np.full(8, np.pi / 2), rel=1e-14)
    assert areas(net).sum() == pytest.approx(6, rel=1e-14)
    # Each vertex of the loops became one vertex of the net.
    pairs = {
        (a, int(b))
        for loop, some in zip(loops, net.corners, strict=True)
        for a, b in zip(loop, some, strict=True)
    }
    assert len(pairs) == 8
    assert net.seams.sum() == 24  # all but the diagonals


def test_the_drawing_has_the_lengths_of_the_metric():
    net = glue([star(9, 1), star(9, 1)[::-1] * [-1, 1]], [((0, 0, 0), (1, 0, 0))])
    sides = np.roll(net.places, -1, axis=1) - net.places
    assert np.linalg.norm(sides, axis=2) == pytest.approx(net.face_lengths, rel=1e-12)
    for p, (polygon, outline) in enumerate(zip(net.polygons, net.outlines, strict=True)):
        drawn = {tuple(point) for point in net.places[net.face_polygons == p].reshape(-1, 2).tolist()}
        assert drawn == {tuple(point) for point in polygon.tolist()}
        assert len(outline) == len(polygon)
    start, end = net.faces.ravel()[net.seams], np.roll(net.faces, -1, axis=1).ravel()[net.seams]
    steps = {(int(a), int(b)) for outline in net.outlines for a, b in pairwise([*outline, outline[0]])}
    assert set(zip(start.tolist(), end.tolist(), strict=True)) == steps


def test_what_it_remembers_is_read_only():
    net = glue([SQUARE], FOLDED)
    for arrays in (net.polygons, net.outlines, net.corners, [net.places, net.face_polygons, net.seams]):
        assert not any(array.flags.writeable for array in arrays)
    assert type(net.normalized).__name__ == "GluedMetric"


@given(seed=st.integers(0, 10**6), n=st.integers(3, 12))
def test_two_copies_back_to_back(seed, n):
    polygon = star(n, seed)
    mirrored = polygon * [-1, 1]  # clockwise now: side k of it lies against side k
    net = glue([polygon, mirrored], [((0, k), (1, k)) for k in range(n)])
    assert net.n_vertices == n
    assert net.corners[0].tolist() == net.corners[1].tolist() == list(range(n))
    ahead, back = np.roll(polygon, -1, axis=0) - polygon, np.roll(polygon, 1, axis=0) - polygon
    directions = [np.arctan2(*some.T[::-1]) for some in (back, ahead)]
    angles = (directions[0] - directions[1]) % (2 * np.pi)
    assert net.deficits == pytest.approx(2 * np.pi - 2 * angles, abs=1e-9)
    assert areas(net).sum() == pytest.approx(2 * shoelace(polygon), rel=1e-12)


@given(seed=st.integers(0, 10**6), n=st.integers(3, 9), at=sixty_fourths(3))
def test_zipping_keeps_area_and_curvature(seed, n, at):
    polygon = star(n, seed)
    net = zipped(polygon, at)
    assert net.deficits.sum() == pytest.approx(4 * np.pi, rel=1e-12)
    assert areas(net).sum() == pytest.approx(shoelace(polygon), rel=1e-12)
    simplicial = net.simplicial()
    assert curvature.area(simplicial) == pytest.approx(shoelace(polygon), rel=1e-9)


@given(seed=st.integers(0, 10**6), at=sixty_fourths(7), turn=st.integers(0, 6), angle=sixty_fourths(6))
def test_where_and_how_a_polygon_is_given_is_all_the_same(seed, at, turn, angle):
    polygon = star(7, seed)
    expected = np.sort(zipped(polygon, at).deficits)
    rotation = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    moved = 3.7 * polygon @ rotation + [5.0, -2.0]
    again = zipped(np.roll(moved, -turn, axis=0), (at - turn) % 7)
    assert np.sort(again.deficits) == pytest.approx(expected, abs=1e-9)
    clockwise = zipped(moved[::-1], (6 - at) % 7)
    assert np.sort(clockwise.deficits) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("scale", [1e-150, 1e-12, 1e150])
def test_no_polygon_is_too_small_or_too_large(scale):
    polygon = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    net, scaled = zipped(polygon, 0.3), zipped(scale * polygon, 0.3)
    assert scaled.faces.tolist() == net.faces.tolist()
    assert scaled.face_lengths == pytest.approx(scale * net.face_lengths, rel=1e-13)


def test_corners_of_one_meet_sides_of_the_other():
    # A 2 x 1 rectangle zipped from .3: four right angles in the sides, two folds.
    net = zipped(rectangle(2, 1), 0.15)
    assert net.deficits == pytest.approx(np.pi * np.array([0.5, 0.5, 0.5, 0.5, 1, 1]), rel=1e-14)
    assert len(net.polygons[0]) == 10
    assert net.corners[0].tolist() == [0, 1, 2, 3]


def test_runs_may_pass_the_first_corner_and_be_cut_anywhere():
    whole = glue([SQUARE], [((0, 0.25, 2.25), (0, 2.25, 0.25))])
    parts = glue(
        [SQUARE],
        [((0, 0.25, 1), (0, 3.5, 0.25)), ((0, 1, 1.9), (0, 2.6, 3.5)), ((0, 1.9, 2.25), (0, 2.25, 2.6))],
    )
    assert np.sort(parts.deficits)[-6:] == pytest.approx(np.sort(whole.deficits), abs=1e-14)
    assert parts.n_vertices == whole.n_vertices + 1  # at 1.9, flat
    assert np.abs(parts.deficits).min() < 1e-14


def test_positions_that_differ_by_rounding_are_one():
    third = 1 / 3
    net = glue([SQUARE], [((0, third, 2 + third), (0, 2 + third + 1e-13, third - 1e-13))])
    assert net.n_vertices == zipped(SQUARE, third).n_vertices


def test_lengths_that_differ_by_rounding_become_their_mean():
    wide = rectangle(1 + 2e-10, 1)
    net = glue([SQUARE, wide], [((0, k), (1, (4 - k) % 4)) for k in range(4)])
    assert (1 + 1e-10) in net.face_lengths.ravel().tolist()


def test_arrays_and_whole_floats_are_fine():
    net = glue(np.array([SQUARE]), np.array([((0, k), (0, k)) for k in range(4)], dtype=float))
    assert net.n_vertices == 5


def test_a_comb_with_many_teeth():
    x = np.arange(2000.0, -1.0, -1.0)
    comb = np.vstack([np.column_stack([x, np.where(x % 2 == 0, 1.0, 0.1)]), [[0.0, 0.0], [2000.0, 0.0]]])
    net = zipped(comb, 0.0)
    assert areas(net).sum() == pytest.approx(shoelace(comb), rel=1e-12)


# What is refused


@pytest.mark.parametrize(
    ("polygons", "sides", "sentence"),
    [
        ([], FOLDED, "there are no polygons"),
        ([SQUARE[:2]], FOLDED, "polygon 0 has 2 corners: it takes 3"),
        (SQUARE, FOLDED, "polygon 0 is not a list of corners [x, y]"),
        ([[[0, 0], [1, 0], [1]]], FOLDED, "polygon 0 is not a list of corners [x, y]"),
        ([[[0, 0], [1, 0], ["a", 1]]], FOLDED, "polygon 0 is not a list of corners [x, y]"),
        ([SQUARE, [[0, 0], [1, 0], [np.nan, 1]]], FOLDED, "corner 2 of polygon 1 is at [nan, 1.0]"),
        ([[*SQUARE, [0, 0]]], FOLDED, "side 4 of polygon 0 has no length: its ends are both at [0.0, 0.0]"),
        ([[[0, 0], [1, 1], [1, 0], [0, 1]]], FOLDED, "polygon 0 is not simple: sides 0 and 2 meet"),
        ([[[0, 0], [2, 0], [1, 0], [1, 1]]], FOLDED, "polygon 0 is not simple: sides 0 and 1 meet"),
        ([[[0, 0], [1, 0], [2, 0]]], FOLDED, "polygon 0 is not simple"),
        ([[[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]]], FOLDED, "polygon 0 is not simple: sides 0 and"),
        ([[[0, 0], [1, 0], [1, 1e-15], [0, 1e-16]]], FOLDED, "polygon 0 is not simple"),
        ([SQUARE], FOLDED[:3], "side 3 of polygon 0 is glued to nothing"),
        ([SQUARE[::-1]], FOLDED[:3], "side 3 of polygon 0 is glued to nothing"),
        ([SQUARE], [((0, 3.5, 1.5), (0, 3.5, 1.5))], "polygon 0 from 1.5 to 3.5 is glued to nothing"),
        ([SQUARE[::-1]], [((0, 3.5, 1.5), (0, 3.5, 1.5))], "polygon 0 from 1.5 to 3.5 is glued to nothing"),
        ([SQUARE, SQUARE], FOLDED, "polygon 1 is glued to nothing: any_surface permits a boundary"),
        ([SQUARE], [], "polygon 0 is glued to nothing"),
        (
            [SQUARE],
            [*FOLDED, ((0, 1, 1.5), (0, 1, 1.5))],
            "the boundary of polygon 0 from 1 to 1.5 is glued twice, by sides[1] and by sides[4]",
        ),
        (
            [SQUARE],
            [((0, 0, 2), (0, 1, 3)), ((0, 3), (0, 3))],
            "side 1 of polygon 0 is glued twice, by sides[0]",
        ),
        (
            [rectangle(2, 1)],
            [((0, 0), (0, 2)), ((0, 1, 2), (0, 3, 3.9))],
            "sides[1] glues polygon 0 from 1 to 2, of length 1.0, to polygon 0 from 3 to 3.9, of length 0.9",
        ),
        (
            [rectangle(2, 1)],
            [((0, 0), (0, 1)), ((0, 2), (0, 3))],
            "sides[0] glues side 0 of polygon 0, of length 2.0, to side 1 of polygon 0, of length 1.0",
        ),
        (
            [SQUARE, SQUARE],
            [*FOLDED, *(((1, k), (1, k)) for k in range(4))],
            "the polygons make 2 surfaces, not one: polygon 1 is not connected to polygon 0",
        ),
        (
            [SQUARE],
            [((0, 0), (0, 2)), ((0, 1), (0, 3))],
            "the polygons make a surface of Euler characteristic 0 (genus 1), not 2",
        ),
    ],
)
def test_what_makes_no_metric_is_refused(polygons, sides, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        glue(polygons, sides)


def test_a_polygon_lost_in_rounding_is_refused(monkeypatch):
    flat = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 1e-16]])
    assert triangulated(flat) is None
    assert triangulated(flat[[0, 2, 3]]) is None
    with pytest.raises(InvalidMetric, match="polygon 0 is not simple: sides 0 and 3 meet"):
        glue([flat], FOLDED)
    # No polygon is known that gets this far.
    monkeypatch.setattr("isoembed.gluing.net.triangulated", lambda points: None)
    with pytest.raises(InvalidMetric, match="polygon 0 is too thin to be triangulated"):
        glue([SQUARE], FOLDED)


@pytest.mark.parametrize(
    ("sides", "sentence"),
    [
        (None, "give either the glued sides or the names of the corners"),
        (17, "the sides are 17, not a list of pairs"),
        ([(0, 1, 2)], "sides[0] is (0, 1, 2), not a pair of sides or runs"),
        ([((0, 1), 3)], "sides[0] glues 3, which is neither a side (polygon, side) nor a run"),
        ([((0, 1), (0, 1, 2, 3))], "sides[0] glues (0, 1, 2, 3), which is neither"),
        ([((0, 1), (0, "a"))], "sides[0] glues (0, 'a'), where 'a' is not a finite number"),
        ([((0, True), (0, 1))], "sides[0] glues (0, True), where True is not a finite number"),
        ([((0, 10**400), (0, 1))], "is not a finite number"),
        ([((0, 1), (1, 1))], "sides[0] glues (1, 1), but the polygons are numbered from 0 to 0"),
        ([((0.5, 1), (0, 1))], "sides[0] glues (0.5, 1), but the polygons are numbered"),
        ([((0, 4), (0, 1))], "sides[0] glues (0, 4), but the sides of polygon 0 are numbered from 0 to 3"),
        ([((0, 1.5), (0, 1))], "sides[0] glues (0, 1.5), but the sides of polygon 0 are numbered"),
        ([((0, -1, 1), (0, 1))], "a run around polygon 0 starts between 0 and 4 and is at most 4 long"),
        ([((0, 1, 5.5), (0, 1))], "a run around polygon 0 starts between 0 and 4 and is at most 4 long"),
        ([((0, 1, 1 + 1e-12), (0, 1))], "which has no length"),
    ],
)
def test_what_is_no_identification_is_refused(sides, sentence):
    with pytest.raises(InvalidParameter, match=re.escape(sentence)):
        glue([SQUARE], sides)


def test_polygons_that_are_no_list_are_refused():
    with pytest.raises(InvalidParameter, match="the polygons are 3, not a list"):
        glue(3, FOLDED)


def test_a_net_is_a_metric():
    assert isinstance(glue([regular_polygon(3)], [((0, k), (0, k)) for k in range(3)]), Net)
