"""The solids of the classics, from the lengths on their triangles."""

from collections import Counter

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import zoo
from isoembed import PolyhedralMetric, embed
from johnson_solids import johnson
from solids import ARCHIMEDEAN, PLATONIC, catalan, has_regular_faces, polygons, triangles, uniform


def refound(points):
    """The polyhedron of the metric on triangles of the hull of these points, all of them vertices."""
    return embed(PolyhedralMetric.from_mesh(points, triangles(polygons(points))), method="alexandrov")


def test_the_92_johnson_solids_have_regular_faces_and_are_different():
    # By Johnson and Zalgaller there are no other solids with regular faces but these, prisms and antiprisms.
    uniform_ones = [uniform(name) for name in (*PLATONIC, *ARCHIMEDEAN)]
    solids = [johnson(number) for number in range(1, 93)]
    assert all(map(has_regular_faces, uniform_ones + solids))
    assert len({tuple(np.sort(pdist(x)).round(9)) for x in uniform_ones + solids}) == 18 + 92


@pytest.mark.parametrize("name", [*PLATONIC, *ARCHIMEDEAN])
def test_platonic_archimedean_and_catalan_solids(name):
    for points in (uniform(name), catalan(name)):
        found = refound(points)
        assert zoo.aligned(found.vertices, points) < 1e-10
        assert Counter(map(len, found.polygons)) == Counter(map(len, polygons(points)))


@pytest.mark.parametrize(
    "tens", [pytest.param(tens, marks=() if tens in (0, 4, 8) else pytest.mark.slow) for tens in range(10)]
)
def test_johnson_solids(tens):
    for number in range(max(10 * tens, 1), min(10 * tens + 10, 93)):
        points = johnson(number)
        found = refound(points)
        assert zoo.aligned(found.vertices, points) < 1e-10
        assert Counter(map(len, found.polygons)) == Counter(map(len, polygons(points)))
