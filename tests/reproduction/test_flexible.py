"""Flexible polyhedra, and counts of realizations."""

import numpy as np
import pytest

from isoembed import Triangulation
from isoembed.surface.intersection import self_intersections
from isoembed.surface.measures import edge_lengths, volume
from reproduction import flexible
from sections import check_section


def test_steffens_polyhedron_keeps_its_lengths_and_its_volume():
    edges = Triangulation(flexible.STEFFEN).edges
    lengths = edge_lengths(edges, flexible.steffen(np.pi))
    assert sorted(set(np.round(lengths, 12))) == [5, 10, 11, 12, 17]
    for t in (2.0, 2.9, np.pi, 3.3):
        x = flexible.steffen(t)
        assert edge_lengths(edges, x) == pytest.approx(lengths, abs=1e-12)
        assert volume(np.array(flexible.STEFFEN), x) == pytest.approx(200.7772051581332, abs=1e-10)
    assert len(self_intersections(flexible.STEFFEN, flexible.steffen(np.pi))) == 0
    assert len(self_intersections(flexible.STEFFEN, flexible.steffen(2.0))) > 0


def test_two_computations_of_the_range_agree():
    assert flexible.embedded_range() == pytest.approx(flexible.range_by_contact(), abs=1e-8)


@pytest.mark.parametrize("start", [flexible.line_symmetric(), flexible.plane_symmetric()])
def test_bricards_octahedra_keep_volume_and_mean_curvature(start):
    record = flexible.followed("octahedron", flexible.OCTAHEDRON, start, 15).record
    assert record["turned"] > 20
    assert record["missed"] < 1e-14
    assert abs(record["volume"]) < 1e-14
    assert record["volume_varies"] < 1e-14 and record["mean_curvature_varies"] < 1e-13


def test_a_rigid_octahedron_cannot_be_followed_along_its_softest_motion():
    x = flexible.line_symmetric()
    x[0, 0] += 0.1
    record = flexible.followed("rigid", flexible.OCTAHEDRON, x, 3).record
    assert record["turned"] < 1 or record["missed"] > 1e-6


@pytest.mark.slow
def test_the_section():
    section = flexible.study(steps=5, stacked=1, starts=2)
    check_section(section)
    assert all(one["agrees"] is not False for one in section.numbers["published"])
    assert [one["found"] for one in section.numbers["stacked"]] == [1, 2]
    assert section.numbers["found_again"]["volume"] == pytest.approx(flexible.STEFFEN_VOLUME, abs=1e-9)
    assert max(one["found"] for one in section.numbers["octahedra"]) <= flexible.MOST_REAL
