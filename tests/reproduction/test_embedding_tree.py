"""The embedding tree: only the edges that it does not use are wrong."""

import pytest

from reproduction import embedding_tree
from sections import check_section


@pytest.fixture(scope="module")
def section():
    return embedding_tree.study(shown=100, sizes=(60, 120, 240))


def test_the_section_can_be_written(section):
    check_section(section)


def test_only_the_edges_that_the_tree_does_not_use_are_wrong(section):
    numbers = section.numbers
    for row in numbers["ellipsoid"]:
        assert row["determined"] == row["vertices"] - 3
        assert row["used"] < 1e-10
        assert 1e-4 < row["median"] < row["worst"]
    assert numbers["exponents"]["median"] < -1 < numbers["exponents"]["worst"]
    assert numbers["growth_per_layer"] > 1
    assert max(numbers["first_edge"].values()) < 1e-14
    assert numbers["two_solutions"]["far"] > numbers["two_solutions"]["near"]
    assert numbers["two_solutions"]["apart"] < 1e-15


def test_the_tree_has_two_used_edges_for_every_vertex_that_it_shows(section):
    figure = section.figures[0].figure
    lines = {line.get_label(): len(line.get_segments()) for line in figure.axes[0].collections[1:]}
    (dots,) = figure.axes[0].lines
    assert lines["used for the next"] == 2 * len(dots.get_xdata()) > 0
    assert lines["determined"] > 0
