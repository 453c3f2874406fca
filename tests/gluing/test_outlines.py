"""Outlines and the polygons inscribed in them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe

from isoembed.gluing import (
    Ellipse,
    Stadium,
    circle,
    rectangle,
    regular_polygon,
    triangle,
)
from isoembed.gluing.outlines import inscribed
from isoembed.gluing.polygon import side_lengths

CURVES = [circle(2.0), Ellipse(2.0, 1.0), Ellipse(1.0, 5.0), Stadium(2.0, 1.0), Stadium(0.1, 3.0)]


def perimeter(curve):
    if isinstance(curve, Stadium):
        return 2 * curve.length + 2 * np.pi * curve.radius
    major, minor = max(curve.a, curve.b), min(curve.a, curve.b)
    return 4 * major * ellipe(1 - (minor / major) ** 2)


def distance_from(curve, points):
    """How far points are from a curve, to first order."""
    x, y = points.T
    if isinstance(curve, Stadium):
        return np.hypot(np.maximum(np.abs(x) - curve.length / 2, 0), y) - curve.radius
    level = np.hypot(x / curve.a, y / curve.b)
    return (level - 1) / np.hypot(x / curve.a**2, y / curve.b**2)


@pytest.mark.parametrize("curve", CURVES, ids=repr)
@given(n=st.integers(8, 200), part=st.integers(0, 63).map(lambda k: k / 64))
def test_inscribed_polygons_are_equilateral_and_on_the_curve(curve, n, part):
    points = inscribed(curve, n, part)
    assert points.shape == (n, 2)
    assert side_lengths(points) == pytest.approx(np.full(n, side_lengths(points)[0]), rel=1e-10)
    assert distance_from(curve, points) == pytest.approx(np.zeros(n), abs=1e-12)
    x, y = points.T
    assert (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() > 0


@pytest.mark.parametrize("curve", CURVES, ids=repr)
def test_their_perimeters_converge_quadratically(curve):
    missing = [1 - side_lengths(inscribed(curve, n, 0.1)).sum() / perimeter(curve) for n in (2000, 4000)]
    assert missing[0] < 1e-4
    assert 3.8 < missing[0] / missing[1] < 4.2


@pytest.mark.parametrize("curve", CURVES, ids=repr)
def test_parts_are_parts_of_the_perimeter(curve):
    u = np.linspace(0, curve.parameter(0.3), 100_001)
    length = np.linalg.norm(np.diff(curve.points(u), axis=0), axis=1).sum()
    assert length == pytest.approx(0.3 * perimeter(curve), rel=1e-7)


def test_polygons_by_their_sides():
    assert side_lengths(rectangle(2, 3)).tolist() == [2, 3, 2, 3]
    assert side_lengths(triangle(4, 5, 6)) == pytest.approx([4, 5, 6], rel=1e-15)
    assert side_lengths(regular_polygon(7, 2.5)) == pytest.approx(np.full(7, 2.5), rel=1e-14)
