"""Triangles of polygons."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from gluing_polygons import shoelace, star, twice_areas
from isoembed.intrinsic.ears import triangulated


@given(seed=st.integers(0, 10**6), n=st.integers(3, 40))
def test_triangles_of_a_polygon_fill_it(seed, n):
    polygon = star(n, seed)
    triangles = triangulated(polygon)
    assert triangles.shape == (n - 2, 3)
    twice = twice_areas(polygon, triangles)
    assert (twice > 0).all()
    assert twice.sum() / 2 == pytest.approx(shoelace(polygon), rel=1e-12)


@given(seed=st.integers(0, 10**6), n=st.integers(3, 40))
def test_triangles_of_a_convex_polygon_are_those_of_delaunay(seed, n):
    angles = np.sort(np.random.default_rng(seed).uniform(0, 2 * np.pi, n)) + np.linspace(0, 1e-2, n)
    polygon = np.column_stack([np.cos(angles), 0.7 * np.sin(angles)])
    expected = {tuple(sorted(face)) for face in Delaunay(polygon).simplices.tolist()}
    assert {tuple(sorted(face)) for face in triangulated(polygon).tolist()} == expected


def test_corners_in_line_are_no_ears():
    along = np.linspace(0, 1, 20, endpoint=False)
    zero = np.zeros(20)
    sides = [(along, zero), (zero + 1, along), (1 - along, zero + 1), (zero, 1 - along)]
    outline = np.concatenate([np.column_stack(side) for side in sides]) @ [[0.8, 0.6], [-0.6, 0.8]]
    triangles = triangulated(outline - outline.min(axis=0))
    assert twice_areas(outline, triangles).min() > 1e-3
