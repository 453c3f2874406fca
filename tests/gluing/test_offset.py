"""Offset of polygons: closed forms, distances, and notches that close."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exact import is_simple
from gluing_polygons import shoelace
from isoembed import InvalidParameter
from isoembed.gluing import regular_polygon
from isoembed.gluing.offset import offset

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
NOTCHED = np.array([[0.0, 0], [4, 0], [4, 4], [2.5, 4], [2.5, 1], [1.5, 1], [1.5, 4], [0, 4]])

HOLLOW = np.array(
    [[0.0, 0], [9, 0], [9, 9], [5.2, 9], [5.2, 5], [7, 5], [7, 3], [2, 3], [2, 5], [4.8, 5], [4.8, 9], [0, 9]]
)


def distance(point, outline):
    """From a point to the boundary of a polygon."""
    step = np.roll(outline, -1, axis=0) - outline
    part = np.clip(((point - outline) * step).sum(axis=1) / (step**2).sum(axis=1), 0, 1)
    return float(np.hypot(*(outline + part[:, None] * step - point).T).min())


@pytest.mark.parametrize("d", [0.25, -0.25])
def test_a_square(d):
    assert offset(SQUARE, d, "it").tolist() == [[-d, -d], [1 + d, -d], [1 + d, 1 + d], [-d, 1 + d]]


@pytest.mark.parametrize("n", [3, 5, 8])
def test_regular_polygons_stay_regular(n):
    outline = regular_polygon(n)
    inradius = 0.5 / math.tan(math.pi / n)
    found = offset(outline, 0.3, "it")
    assert found == pytest.approx(outline * (inradius + 0.3) / inradius)


@pytest.mark.parametrize("limit", [1.2, 2.0, 5.0])
def test_sharp_corners_are_cut_off_at_the_limit(limit):
    thin = np.array([[0.0, 0], [10, -1], [10, 1]])
    found = offset(thin, 0.1, "it", limit)
    tip = np.flatnonzero(found[:, 0] < 5)
    assert len(tip) == 2
    assert found[tip, 0] == pytest.approx([-limit * 0.1] * 2)  # across the bisector, which is the axis
    assert len(found) == (4 if limit > 1.5 else 6)
    assert min(distance(point, thin) for point in found) > 0.1 - 1e-12


def test_each_side_by_its_own_distance():
    found = offset(SQUARE, [0.1, 0.2, 0.3, 0.4], "it")
    assert found == pytest.approx(np.array([[-0.4, -0.1], [1.2, -0.1], [1.2, 1.3], [-0.4, 1.3]]))
    split = np.insert(SQUARE, 1, [0.5, 0], axis=0)
    found = offset(split, [0.1, 0.2, 0, 0, 0], "it")  # a step between sides in line
    assert found == pytest.approx(np.array([[0, -0.1], [0.5, -0.1], [0.5, -0.2], [1, -0.2], [1, 1], [0, 1]]))


@pytest.mark.parametrize(
    ("outline", "d", "sentence"),
    [
        (NOTCHED, 0.51, r"side 4 of it vanishes: an offset of 0\.51 is too large, as in a notch; it takes"),
        (SQUARE, -0.6, r"side 0 of it vanishes: an offset of -0\.6 is too large"),
        (
            HOLLOW,
            0.3,
            r"an offset of 0\.3 closes the notch of it between its sides \d+ and \d+",
        ),
    ],
)  # fmt: skip
def test_notches_that_close(outline, d, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        offset(outline, d, "it")
    assert is_simple(offset(outline, d / 4, "it"))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.5, 2.0), min_size=5, max_size=12), st.floats(0.001, 0.3))
def test_all_sides_are_as_far(radii, d):
    angles = 2 * np.pi * np.arange(len(radii)) / len(radii)
    star = np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    try:
        found = offset(star, d, "it")
    except InvalidParameter:
        return
    assert is_simple(found)
    assert shoelace(found) > shoelace(star)
    middles = (found + np.roll(found, -1, axis=0)) / 2
    assert all(distance(point, star) >= d - 1e-9 for point in (*found, *middles))
    back = offset(found, -d, "it")
    assert back == pytest.approx(star, abs=1e-6)
