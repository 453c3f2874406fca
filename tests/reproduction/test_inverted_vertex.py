"""Inverted vertices and the convexity routine."""

import pytest

from reproduction import inverted_vertex
from sections import check_section


@pytest.fixture(scope="module")
def section():
    return inverted_vertex.study(vertices=30)


def test_the_section_can_be_written(section):
    check_section(section)


def test_two_surfaces_have_the_same_lengths(section):
    pair = section.numbers["pair"]
    assert pair["lengths"] < 1e-12
    assert pair["deficits"] < 1e-12
    assert pair["dihedral"] > 0.5
    assert pair["integral_convex"] > pair["integral_inverted"]
    assert pair["others_moved"] < pair["vertex_moved"] / 4


def test_only_the_corrected_routine_pops(section):
    numbers = section.numbers
    pair, printed, corrected = numbers["pair"], numbers["routine"]["printed"], numbers["routine"]["corrected"]
    assert pair["height_inverted"] < 0 < pair["height_convex"]
    # The vertex normal turns a little with the vertex, so the height is not quite linear in the move.
    assert printed["moved"] == pytest.approx(3 * pair["height_inverted"], rel=0.02)
    assert corrected["moved"] == pytest.approx(-pair["height_inverted"], rel=0.02)
    assert corrected["annealed"] == pytest.approx(pair["height_convex"], rel=1e-9)
    assert printed["annealed"] < 0
    assert corrected["annealed_concave"] == 0 < printed["annealed_concave"]
    everywhere = numbers["every_vertex"]
    assert everywhere["inverted"] > everywhere["vertices"] / 3
    assert everywhere["corrected"] == everywhere["inverted"]
    assert everywhere["printed"] == 0
