"""Triangles of constant curvature."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.space.trigonometry import (
    amplitude,
    angle_between,
    apex,
    arc,
    chord,
    cs,
    sn,
    triangle_area,
    twice_area,
    versine,
)

SIDES = (0.7, 0.8, 0.5)


def cyclic(f, k, sides=SIDES):
    a, b, c = sides
    return np.array([f(b, c, a, k), f(c, a, b, k), f(a, b, c, k)])


@pytest.mark.parametrize("k", [-1.0, -0.3, 0.0, 0.4, 1.0])
def test_laws_of_cosines_and_sines(k):
    a, b, c = SIDES
    angles = cyclic(angle_between, k)
    A = angles[0]
    if k == 0:
        assert abs(a * a - (b * b + c * c - 2 * b * c * math.cos(A))) < 1e-15
    else:
        assert abs(cs(a, k) - cs(b, k) * cs(c, k) - k * sn(b, k) * sn(c, k) * math.cos(A)) < 2e-16
    ratios = np.sin(angles) / [sn(s, k) for s in SIDES]
    assert np.ptp(ratios) < 1e-15
    assert abs(sn(b, k) * sn(c, k) * math.sin(A) - amplitude(a, b, c, k)) < 1e-15


@pytest.mark.parametrize("k", [-1.0, 1.0])
def test_area_is_the_excess_of_the_angles(k):
    assert abs(k * triangle_area(*SIDES, k) - (cyclic(angle_between, k).sum() - math.pi)) < 1e-15


def test_octant():
    right = math.pi / 2
    assert abs(triangle_area(right, right, right, 1.0) - right) < 1e-15
    assert abs(angle_between(right, right, right, 1.0) - right) < 1e-15


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("f", [angle_between, amplitude, triangle_area])
def test_flat_limit_is_linear(f, sign):
    flat = cyclic(f, 0.0)
    off = [np.abs(cyclic(f, sign * k) - flat).max() for k in (1e-2, 1e-3, 1e-12, 1e-300)]
    assert 9 < off[0] / off[1] < 11
    assert off[2] < 1e-12
    assert off[3] <= 2.3e-16


@pytest.mark.parametrize("k", [-1.0, 0.0, 1.0])
def test_needle_keeps_its_angle(k):
    # Two sides of length 1 at an angle of 1e-9: the side across from the law of sines for half of it.
    across = 2 * arc(2 * sn(1.0, k) * math.sin(0.25e-9) * 1.0, k)
    assert abs(angle_between(1.0, 1.0, across, k) / 1e-9 - 1) < 1e-9


@pytest.mark.parametrize("k", [-1.0, -1e-8, 0.0, 1e-8, 1.0])
def test_apex_is_at_its_distances(k):
    l, second, third = SIDES
    x, y = apex(l, second, third, k)
    side = sn(l, k)
    fourth = -k * (versine(third, k) - versine(l, k))  # difference of cosines, over the radius of curvature
    squared = math.hypot(x - side, y) ** 2 + (fourth * fourth / k if k else 0.0)
    assert abs(arc(math.sqrt(squared), k) - second) < 1e-15
    assert abs(math.hypot(x, y) - sn(third, k)) < 1e-15


@given(st.floats(1e-3, 1.5), st.sampled_from([-2.0, -1e-200, 0.0, 1e-12, 1.0]))
def test_functions_agree(x, k):
    assert math.isclose(arc(chord(x, k), k), x, rel_tol=1e-14)
    assert math.isclose(sn(x, k) ** 2 * k + cs(x, k) ** 2, 1.0, rel_tol=1e-13)
    assert math.isclose(versine(x, k) * k, 1 - cs(x, k), abs_tol=1e-15)


@pytest.mark.parametrize("k", [-1.0, 0.0, 1.0])
def test_sides_that_make_no_triangle(k):
    assert amplitude(1.0, 0.3, 0.3, k) == triangle_area(1.0, 0.3, 0.3, k) == twice_area(1.0, 0.3, 0.3) == 0
    assert amplitude(2.2, 2.2, 2.2, 1.0) == 0  # more than a great circle


@pytest.mark.parametrize("k", [-2.0, 2.0])
def test_sine_and_cosine_to_the_last_place(k):
    # On both sides of where the series are left for the library.
    edge = (0.1 / abs(k)) ** 0.5
    for x in [1e-200, 1e-8, *np.linspace(0.01, 0.9999, 40) * edge, 1.0001 * edge]:
        t, sine, cosine, term = Fraction(k) * Fraction(x) ** 2, Fraction(0), Fraction(0), Fraction(1)
        for n in range(20):
            cosine += term
            sine += term / (2 * n + 1)
            term = -term * t / ((2 * n + 1) * (2 * n + 2))
        assert sn(x, k) == pytest.approx(float(sine * Fraction(x)), rel=2.0**-51, abs=0)
        assert cs(x, k) == pytest.approx(float(cosine), rel=2.0**-52, abs=0)
