"""The search for edge-to-edge gluings, against counting, brute force and known results."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from isoembed.errors import InvalidMetric
from isoembed.gluing import edge_gluings, glue, rectangle, regular_polygon
from isoembed.gluing.classics import LATIN_CROSS


def matchings(sides):
    """All ways to pair a list of sides."""
    if not sides:
        yield []
        return
    first, *rest = sides
    for k, partner in enumerate(rest):
        for others in matchings(rest[:k] + rest[k + 1 :]):
            yield [((0, first), (0, partner)), *others]


def glued(polygon, sides):
    try:
        return glue([polygon], sides)
    except InvalidMetric:
        return None


def catalan(m):
    return math.comb(2 * m, m) // (m + 1)


def test_the_latin_cross():
    every, convex = edge_gluings(LATIN_CROSS, convex=False), edge_gluings(LATIN_CROSS)
    assert len(every) == catalan(7) == 429
    assert len(convex) == 17
    nets = [glue([LATIN_CROSS], sides) for sides in every]
    assert [sides for sides, net in zip(every, nets, strict=True) if net.deficits.min() > -1e-9] == convex
    assert {net.n_vertices for net in nets} == {8}
    for net in nets:
        assert net.deficits.sum() == pytest.approx(4 * np.pi, rel=1e-13)
    cones = [int((glue([LATIN_CROSS], sides).deficits > 1e-9).sum()) for sides in convex]
    assert sorted(cones) == [4] * 8 + [5] * 4 + [6] * 4 + [8]


@settings(max_examples=12)
@given(n=st.sampled_from([4, 6, 8]), seed=st.integers(0, 10**6))
def test_as_by_brute_force(n, seed):
    # An equilateral polygon that need not be convex: unit steps of which each is paired with its opposite.
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, np.pi, n // 2)) + np.linspace(0, 0.01, n // 2)
    steps = np.column_stack([np.cos(angles), np.sin(angles)])
    polygon = np.cumsum(np.concatenate([steps, -steps]), axis=0)
    spheres = [sides for sides in matchings(list(range(n))) if glued(polygon, sides)]
    assert edge_gluings(polygon, convex=False) == spheres
    assert len(spheres) == catalan(n // 2)
    convex = [sides for sides in spheres if glue([polygon], sides).deficits.min() > -1e-9]
    assert edge_gluings(polygon) == convex


@settings(max_examples=12)
@given(turn=st.integers(0, 13), mirror=st.booleans())
def test_the_first_corner_and_the_orientation_do_not_matter(turn, mirror):
    polygon = np.roll(LATIN_CROSS, turn, axis=0)
    polygon = polygon[::-1] if mirror else polygon
    found = edge_gluings(polygon)
    assert len(found) == 17
    assert all(glue([polygon], sides).deficits.min() > -1e-9 for sides in found)


def test_sides_of_different_lengths_are_not_glued():
    assert edge_gluings(rectangle(2, 1)) == []  # opposite sides would make a torus
    assert edge_gluings([[0, 0], [2, 0], [2, 1], [1, 1], [0, 1]]) == []  # an odd number
    halves = [[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]]
    assert edge_gluings([*halves[:4], [1, 1], halves[4]]) == [
        s for s in matchings(list(range(6))) if glued([*halves[:4], [1, 1], halves[4]], s)
    ]


@pytest.mark.parametrize("n", [8, 14, 30])
def test_a_regular_polygon_is_zipped_from_its_corners(n):
    # Three of its angles are more than a full one; Catalan(15) = 9,694,845 gluings are never made.
    found = edge_gluings(regular_polygon(n))
    expected = [
        sorted(tuple(sorted(((0, (k + j) % n), (0, (k - 1 - j) % n)))) for j in range(n // 2))
        for k in range(n // 2)
    ]
    assert found == sorted(expected)
