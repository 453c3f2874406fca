"""Triangles laid out in polygons, and lengths that make triangles in floats."""

import numpy as np
import pytest

import zoo
from isoembed.intrinsic.polygons import loosened
from sprinkled import tables_of


@pytest.mark.parametrize("short", [0.0, 1e-300, 1e-17, 1e-16])
def test_sides_shorter_than_the_rounding_of_the_others_are_rounded_up(short):
    # By little of themselves they would be rounded up a thousand million million times, or for ever.
    tables = tables_of(*zoo.octahedron())
    lengths = np.ones(24)
    h = int(np.flatnonzero(tables.corners < tables.corners[tables.twins])[0])
    lengths[[h, tables.twins[h]]] = short
    other = h // 3 * 3 + (h + 1) % 3  # longer than the third side by more than the short one is
    lengths[[other, tables.twins[other]]] = 1 + 2.0**-52
    found = loosened(lengths, tables.twins)
    a, b, c = np.sort(found.reshape(-1, 3), axis=1).T
    assert (c - b < a).all()
    assert np.abs(found - lengths).max() < 1e-14
    assert np.array_equal(found, found[tables.twins])


def test_lengths_that_make_triangles_are_left_alone():
    tables = tables_of(*zoo.random_hull(20, 1))
    assert np.array_equal(loosened(tables.lengths, tables.twins), tables.lengths)
