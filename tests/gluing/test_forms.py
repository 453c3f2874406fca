"""Pita forms and D-forms."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing import (
    Ellipse,
    Stadium,
    circle,
    dform,
    pita,
    rectangle,
    regular_polygon,
    triangle,
    zipped,
)

CURVES = [circle(2.0), Ellipse(2.0, 1.0), Ellipse(1.0, 5.0), Stadium(2.0, 1.0), Stadium(0.1, 3.0)]


@given(part=st.integers(0, 63).map(lambda k: k / 64), n=st.integers(3, 60))
def test_a_circle_is_zipped_alike_from_everywhere(part, n):
    net = pita(circle(), part, n)
    assert net.n_vertices == (n + 1) // 2 + 1
    flap = 2 * np.pi / n
    last = np.pi + flap if n % 2 == 0 else np.pi  # the other end of the zip: a corner, or inside a side
    middle = np.full(net.n_vertices - 2, 2 * flap)
    assert np.sort(net.deficits) == pytest.approx(np.sort([np.pi + flap, last, *middle]), rel=1e-9)


@given(
    pair=st.sampled_from([(CURVES[0], CURVES[1]), (CURVES[1], CURVES[3]), (CURVES[4], CURVES[2])]),
    offset=st.integers(0, 63).map(lambda k: k / 64),
)
def test_two_curves_meet_corner_to_corner(pair, offset):
    net = dform(*pair, offset, 60)
    assert net.n_vertices == 60
    assert net.deficits.min() > 0
    assert net.deficits.sum() == pytest.approx(4 * np.pi, rel=1e-12)


@given(offset=st.integers(0, 63).map(lambda k: k / 64))
def test_a_circle_does_not_feel_the_offset(offset):
    expected = np.sort(dform(circle(), CURVES[1], 0.0, 40).deficits)
    assert np.sort(dform(CURVES[1], circle(), offset, 40).deficits) == pytest.approx(expected, abs=1e-9)


def test_polygons_stay_as_they_are():
    square = rectangle(1, 1)
    net = dform(square, 5 * square, 1 / 8)
    assert net.n_vertices == 8
    assert net.deficits == pytest.approx(np.full(8, np.pi / 2), rel=1e-14)
    assert net.triangles.areas.sum() * net.triangles.unit**2 == pytest.approx(2, rel=1e-14)
    doubled = dform(square, square)
    assert doubled.n_vertices == 4
    assert doubled.deficits == pytest.approx(np.full(4, np.pi), rel=1e-14)


def test_parts_of_polygons_follow_the_corners_as_given():
    clockwise = [[0, 0], [0, 1], [2, 1], [2, 0]]
    part = pita(clockwise, 0.5 / 6)  # half way up the first side
    assert np.sort(part.deficits) == pytest.approx(np.sort(zipped(clockwise, 0.5).deficits), rel=1e-14)
    assert len(part.polygons[0]) == len(zipped(clockwise, 0.5).polygons[0])


# What is refused


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: pita(circle(), 1.0), "at is 1.0, not a fraction of the perimeter in [0, 1)"),
        (lambda: pita(circle(), np.nan), "at is nan, not a fraction"),
        (lambda: pita(circle(), "a"), "at is 'a', not a fraction"),
        (lambda: dform(circle(), circle(), -0.1), "offset is -0.1, not a fraction of the perimeter"),
        (lambda: pita(circle(), 0.0, 2), "n is 2, not a whole number of sides, at least 3"),
        (lambda: pita(circle(), 0.0, 7.5), "n is 7.5, not a whole number"),
        (lambda: pita(Ellipse(30, 1), 0.25, 3), "3 sides are too few for Ellipse(a=30, b=1)"),
        (lambda: zipped(rectangle(1, 1), 4.5), "at is 4.5, not a position on the boundary from 0 to 4"),
        (lambda: zipped(rectangle(1, 1), True), "at is True, not a position"),
        (lambda: Ellipse(1, 0), "ellipse has b = 0, not a positive finite number"),
        (lambda: Stadium(np.inf, 1), "stadium has length = inf, not a positive"),
        (lambda: rectangle("a", 1), "rectangle has width = 'a', not a positive"),
        (lambda: triangle(1, 1, 2), "triangle has the sides 1, 1 and 2: one is too long"),
        (lambda: triangle(1, 1, -2), "triangle has c = -2, not a positive"),
        (lambda: regular_polygon(2), "n is 2, not a whole number of sides"),
        (lambda: regular_polygon(5, -1), "regular polygon has side = -1, not a positive"),
    ],
)
def test_what_is_no_form_is_refused(make, sentence):
    with pytest.raises(InvalidParameter, match=re.escape(sentence)):
        make()


def test_outlines_that_are_none_are_refused():
    with pytest.raises(InvalidMetric, match="the outline is not a list of corners"):
        pita([1, 2, 3])
    with pytest.raises(InvalidMetric, match="the polygon is not a list of corners"):
        zipped(3, 0)
