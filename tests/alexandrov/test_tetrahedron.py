"""Bodies of four vertices, from any triangulation of their metric."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed import GluedMetric, PolyhedralMetric, embed
from isoembed.alexandrov.tetrahedron import tetrahedron
from scrambling import scramble
from sprinkled import tables_of


@given(st.integers(0, 10**6), st.floats(-3.5, 0))
def test_random_ones_however_thin(seed, decades):
    rng = np.random.default_rng(seed)
    points, faces = zoo.outward_hull(rng.normal(size=(4, 3)))
    points = points * [1, 1, 10.0**decades]
    tables = tables_of(points, faces)
    scramble(tables, 2, rng, thinnest=0.02)
    metric = GluedMetric.flipped(tables)
    found = embed(metric, method="alexandrov")
    assert found.residual < 1e-13
    assert found.volume == pytest.approx(
        abs(np.linalg.det(points[1:] - points[0])) / 6, rel=1e-9 / 10.0 ** (2 * decades)
    )
    assert sum(stage.factorizations for stage in found.stages) < 50


def test_a_flat_body_is_none():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert tetrahedron(GluedMetric(*zoo.doubly_covered(square)).half_edges()) is None


def test_many_flips_away_is_found_by_polytopes():
    points = np.array([[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 5e-4, 1.0], [1e-3, -5e-4, 1.0]])
    points, faces = zoo.outward_hull(points)
    assert tetrahedron(tables_of(points, faces)) is None
    found = embed(PolyhedralMetric.from_mesh(points, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, points) < 1e-9
