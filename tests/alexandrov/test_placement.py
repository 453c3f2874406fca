"""Vertices of a polytope that is a polyhedron, or nearly one."""

import zoo
from isoembed.alexandrov.placement import relaxed_without_dents
from isoembed.intrinsic.flips import flip
from isoembed.progress.stages import Log
from sprinkled import tables_of


def test_an_edge_that_flips_have_made_twice_is_no_reason_to_raise():
    vertices, faces = zoo.tetrahedron()
    tables = tables_of(vertices, faces)
    with Log().stage("placement") as recorder:
        assert relaxed_without_dents(tables.copy(), vertices, recorder).dent == 0
        assert flip(0, tables, 0.0)  # the other diagonal is an edge already
        assert relaxed_without_dents(tables, vertices, recorder) is None
