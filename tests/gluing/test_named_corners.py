"""Gluing by the names of corners: faces of polyhedra as one lists them, and what names cannot tell."""

import json
import re

import numpy as np
import pytest

import isoembed
from isoembed import InvalidMetric, InvalidParameter, glue
from isoembed.gluing import rectangle, regular_polygon, triangle
from isoembed.io.net import read_net

SQUARE = regular_polygon(4)
CUBE = ["abcd", "abfe", "bcgf", "cdhg", "daeh", "efgh"]  # neither orientation throughout


def volume(net):
    return isoembed.embed(net, method="alexandrov").volume


def prism(n):
    """Names of the faces of a prism, the squares in one orientation and the ends in the other."""
    ring = [(k, (k + 1) % n) for k in range(n)]
    return [list(range(n)), list(range(n, 2 * n)), *([a, b, n + b, n + a] for a, b in ring)]


def test_a_cube_of_squares_in_any_orientation():
    for seed in range(4):
        rng = np.random.default_rng(seed)
        names = [name[::-1] if rng.integers(2) else name for name in CUBE]
        sheets = [SQUARE[:: 1 if rng.integers(2) else -1] for _ in CUBE]
        net = glue(sheets, corners=names)
        assert net.n_vertices == 8 and volume(net) == pytest.approx(1)
        for name, corners in zip(names, net.corners, strict=True):
            for letter, vertex in zip(name, corners.tolist(), strict=True):
                assert all(
                    own[other.index(letter)] == vertex
                    for other, own in zip(names, net.corners, strict=True)
                    if letter in other
                )


def test_names_say_what_sides_say():
    sheets = [regular_polygon(5), regular_polygon(5), *[rectangle(1, 3)] * 5]
    by_names = glue(sheets, corners=prism(5))
    area = 5 / (4 * np.tan(np.pi / 5))
    assert volume(by_names) == pytest.approx(3 * area)
    sides = [((0, k), (2 + k, 0)) for k in range(5)] + [((1, k), (2 + k, 2)) for k in range(5)]
    sides += [((2 + k, 1), (2 + (k + 1) % 5, 3)) for k in range(5)]
    turned = [np.array(sheet) * [-1, 1] if p < 1 else sheet for p, sheet in enumerate(sheets)]
    by_sides = glue(turned, sides)
    assert volume(by_sides) == pytest.approx(3 * area)
    np.testing.assert_allclose(np.sort(by_sides.deficits), np.sort(by_names.deficits), atol=1e-12)


def test_a_polygon_without_symmetry_is_turned_over():
    # Two copies of one triangle of sides 3, 4, 5 cover one another; so do it and its mirror image.
    one = triangle(3, 4, 5)
    for other in (one, one * [-1, 1]):
        disc = glue([one, other], corners=["abc", "abc"])
        angles = np.arctan2([3, 4, 1], [4, 3, 0])
        assert np.sort(disc.deficits) == pytest.approx(np.sort(2 * np.pi - 2 * angles))
    with pytest.raises(InvalidMetric, match=r"side 0 of polygon 0 has length 3\.0, but side 1 of polygon 1"):
        glue([one, one], corners=["abc", "cab"])


def test_a_polygon_may_be_glued_to_itself():
    # A square folded along its diagonal.
    assert glue([SQUARE], corners=["abcb"]).n_vertices == 3
    with pytest.raises(InvalidMetric, match="a surface with one side, not a sphere"):
        glue([regular_polygon(6)], corners=["abcabc"])


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (
            ["abc", "abd", "acd"],
            "side 1 of polygon 0 is glued to nothing: no other side joins corners 'b' and 'c'",
        ),
        (
            ["abc", "abc", "abc"],
            "3 sides join corners 'a' and 'b': side 0 of polygon 0, 0 of polygon 1, 0 of ",
        ),
        (["aab", "aab", "abc"], "side 0 of polygon 0 has corner 'a' at both ends"),
    ],
)
def test_names_that_tell_no_gluing(names, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        glue([regular_polygon(3)] * 3, corners=names)


def test_one_name_for_two_vertices():
    # A cube, two of whose far corners have the same name.
    with pytest.raises(InvalidMetric, match=r"the corners 'a' of polygons \d and \d do not meet"):
        glue([SQUARE] * 6, corners=[name.replace("g", "a") for name in CUBE])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({}, "either the glued sides or the names"),
        ({"sides": [], "corners": []}, "either the glued sides or the names"),
        ({"corners": ["abc"]}, "the corners are not 2 lists of names"),
        ({"corners": ["abc", "ab"]}, "corners[1] is 'ab', not a list of the names of the 3 corners"),
        (
            {"corners": ["abc", ["a", "b", 1.5]]},
            "corner 2 of polygon 1 is called 1.5, neither text nor a whole number",
        ),
        ({"corners": 7}, "the corners are not 2 lists of names"),
    ],
)
def test_what_is_no_list_of_names(options, sentence):
    with pytest.raises(InvalidParameter, match=re.escape(sentence)):
        glue([regular_polygon(3)] * 2, **options)


def test_files(tmp_path):
    path = tmp_path / "net.json"
    path.write_text(json.dumps({"regular": [list(name) for name in CUBE]}))
    assert volume(read_net(str(path))) == pytest.approx(1)
    path.write_text(json.dumps({"regular": CUBE}))
    assert volume(read_net(str(path))) == pytest.approx(1)
    path.write_text(json.dumps({"polygons": [{"regular": [4, 2]}] * 6, "corners": CUBE}))
    assert volume(read_net(str(path))) == pytest.approx(8)
    path.write_text(json.dumps({"regular": [7]}))
    with pytest.raises(isoembed.io.FileError, match="the corners of polygon 0 are not a list"):
        read_net(str(path))


def test_short_sides_are_the_same_up_to_the_rounding_of_long_ones():
    sheet = np.array([[0, 0], [1, 0], [1, 1e-9], [0, 1]])
    cosine, sine = np.cos(0.7), np.sin(0.7)
    other = sheet @ [[cosine, sine], [-sine, cosine]]
    short = [np.linalg.norm(points[2] - points[1]) for points in (sheet, other)]
    assert abs(short[1] / short[0] - 1) > 2e-9
    assert glue([sheet, other], corners=["abcd", "abcd"]).n_vertices == 4
