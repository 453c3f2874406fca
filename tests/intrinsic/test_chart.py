"""Conformal coordinates: against points on hyperboloid and sphere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.intrinsic.chart import (
    coordinate,
    distance,
    distances,
    motion,
    moved,
    stretch,
    toward,
    turn_at,
)
from isoembed.space import Space
from isoembed.space.models import from_model, to_model

curvatures = st.sampled_from([-1.0, 1.0, -0.3, 4.0, -1e-20, 1e-20, 0.0])
numbers = st.complex_numbers(max_magnitude=0.9, allow_nan=False, allow_subnormal=False)


def ambient(space, *points):
    flat = np.array([[z.real, z.imag, 0.0] for z in points])
    return from_model(space, flat, "conformal")


def as_complex(p):
    return complex(p[0], p[1])


@given(curvatures, numbers, numbers)
def test_what_is_seen_from_a_point(k, a, b):
    space = Space(k)
    x, y = ambient(space, a, b)
    assert distance(toward(a, b, k), k) == pytest.approx(float(space.distances(x, y)), abs=1e-14)
    if k <= 0:  # the other half of the sphere has no ambient coordinates
        seen = to_model(space, space.translated(y, -x), "conformal")
        assert toward(a, b, k) == pytest.approx(as_complex(seen), abs=1e-13)
    assert toward(-a, toward(a, b, k), k) == pytest.approx(b, abs=1e-13)
    assert (b.real, b.imag) == pytest.approx(tuple(y[:2] * stretch(b, k)), abs=1e-15)
    assert 2 / stretch(b, k) - 1 == pytest.approx(float(space.heights(y)), abs=1e-14)


@given(curvatures, numbers, numbers, numbers, numbers)
def test_motions(k, a, b, c, d):
    if min(abs(a - b), abs(c - d)) < 1e-3:
        return
    turn, shift = motion(a, b, c, d, k)
    assert abs(turn) == pytest.approx(1.0, rel=1e-12)
    assert moved(c, turn, shift, k) == pytest.approx(a, abs=1e-12)
    there = toward(a, moved(d, turn, shift, k), k) / toward(a, b, k)
    assert there.real > 0 and there.imag == pytest.approx(0.0, abs=1e-9 * abs(there))
    assert distance(toward(moved(b, turn, shift, k), a, k), k) == pytest.approx(
        distance(toward(b, c, k), k), rel=1e-9
    )
    step = 1e-6
    turned = (moved(b + step, turn, shift, k) - moved(b - step, turn, shift, k)) / (2 * step)
    assert np.exp(1j * turn_at(b, turn, shift, k)) == pytest.approx(turned / abs(turned), abs=1e-8)


@pytest.mark.parametrize("k", [-1.0, 1.0, -1e-9, 1e-9, 0.0])
def test_there_and_back_along_the_axis(k):
    lengths = np.array([0.0, 1e-12, 0.1, 1.0, 3.0])
    z = np.array([coordinate(l, k) for l in lengths]) * np.exp(0.3j)
    assert distances(z, k) == pytest.approx(lengths, rel=1e-14)
    if k == 0:
        assert toward(0.1 + 0.7j, 0.3 - 0.2j, k) == (0.3 - 0.2j) - (0.1 + 0.7j)
        assert moved(0.1 + 0.7j, 1j, 0.3 - 0.2j, k) == 1j * (0.1 + 0.7j) + (0.3 - 0.2j)
