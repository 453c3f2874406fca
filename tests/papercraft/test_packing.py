"""Rectangles on pages and rolls."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from isoembed.papercraft.fitting import best_turn, compact_turn
from isoembed.papercraft.packing import packed


def check(sizes, room, gap, packing):
    corners, pages, turned = packing
    shapes = np.where(turned[:, None], sizes[:, ::-1], sizes)
    assert (corners >= 0).all() and (corners + shapes <= room * (1 + 1e-9)).all()
    assert set(pages) == set(range(pages.max() + 1))
    for k in range(len(sizes)):
        apart = np.maximum(corners[:k] - corners[k] - shapes[k], corners[k] - corners[:k] - shapes[:k]).max(
            axis=1
        )
        assert (apart[pages[:k] == pages[k]] >= gap * (1 - 1e-9)).all()


@given(st.integers(1, 40), st.integers(0, 10**6), st.sampled_from([120.0, np.inf]))
@settings(max_examples=60, deadline=None)
def test_rectangles_are_on_pages_and_apart(n, seed, height):
    rng = np.random.default_rng(seed)
    room, sizes = np.array([100.0, height]), rng.uniform(5, 100, (n, 2))
    check(sizes, room, 3.0, packed(sizes, room, 3.0))


def test_eight_dominoes_fill_a_page_exactly():
    """1 by 2 with gaps of 1: two rows of four on 7 by 5."""
    sizes = np.tile([1.0, 2.0], (8, 1))
    corners, pages, turned = packed(sizes, np.array([7.0, 5.0]), 1.0)
    check(sizes, np.array([7.0, 5.0]), 1.0, (corners, pages, turned))
    assert pages.max() == 0 and not turned.any()


def test_a_rectangle_is_turned_where_that_saves_a_page():
    sizes = np.array([[6.0, 10], [4, 3]])  # the second fits beside the first only upright
    assert packed(sizes, np.array([10.0, 10.0]), 1.0)[1].tolist() == [0, 0]
    assert packed(sizes[:1], np.array([10.0, 10.0]), 1.0)[2].tolist() == [False]


def test_a_roll_is_short():
    corners, pages, turned = packed(np.array([[10.0, 90], [30, 20]]), np.array([100.0, np.inf]), 0.0)
    assert pages.tolist() == [0, 0] and turned.tolist() == [True, False]
    assert sorted(corners[:, 1].tolist()) in ([0, 10], [0, 20])


@pytest.mark.parametrize("seed", range(5))
def test_a_compact_turn_has_the_smallest_bounding_box_of_any_angle(seed):
    points = np.random.default_rng(seed).normal(size=(10, 2)) * [3.0, 1.0]
    room = np.array([100.0, 100.0])
    turn = compact_turn(points, room)
    angles = np.linspace(0, np.pi / 2, 2001)
    turns = np.array([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]]).transpose(2, 0, 1)
    least = np.ptp(points @ turns, axis=1).prod(axis=1).min()
    assert np.ptp(points @ turn, axis=0).prod() <= least * (1 + 1e-12)


def test_a_compact_turn_fits():
    rod = np.array([[0.0, 0], [9, 0], [9, 1], [0, 1]])
    for room in ([9.5, 2.0], [2.0, 9.5]):
        assert (np.ptp(rod @ compact_turn(rod, np.array(room)), axis=0) <= np.array(room) + 1e-12).all()
        assert best_turn(rod, np.array(room))[1] >= 1
