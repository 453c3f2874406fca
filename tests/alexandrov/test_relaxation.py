"""Vertices of a polytope that is nearly a polyhedron, put right by their lengths and by flips."""

import numpy as np
import pytest

import zoo
from isoembed.alexandrov.relaxation import relaxed_without_dents
from isoembed.intrinsic.loops import flip
from isoembed.progress.stages import Log
from sprinkled import tables_of


def test_an_edge_that_flips_have_made_twice_is_no_reason_to_raise():
    vertices, faces = zoo.tetrahedron()
    tables = tables_of(vertices, faces)
    with Log().stage("placement") as recorder:
        assert relaxed_without_dents(tables.copy(), vertices, recorder).dent == 0
        assert flip(0, tables.views, 0.0)  # the other diagonal is an edge already
        assert relaxed_without_dents(tables, vertices, recorder) is None


@pytest.mark.parametrize("seed", range(4))
def test_shallow_dents_are_flipped_away_though_they_get_deeper_between(seed):
    rng = np.random.default_rng(seed)
    disk = np.sqrt(rng.random(12)) * np.exp(2j * np.pi * rng.random(12))
    cap = np.column_stack([disk.real, disk.imag, 1e-8 * (1 - abs(disk) ** 2)])
    vertices, faces = zoo.outward_hull(np.vstack([cap, [[3, 0, -1], [-2, 3, -1], [-2, -3, -1]]]))
    tables = tables_of(vertices, faces)
    for h in rng.integers(tables.corners.size, size=100):
        if (tables.faces[[h // 3, tables.twins[h] // 3]] < 12).all():
            flip(int(h), tables.views, 0.0)
    with Log().stage("placement") as recorder:
        assert relaxed_without_dents(tables, vertices, recorder).dent <= 1e-13
