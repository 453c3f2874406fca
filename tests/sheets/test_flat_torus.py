"""Flat tori of eight vertices, from their lengths alone.

Schwartz (Vertex-minimal paper tori, arXiv:2507.14998) proves that fewer vertices do not do.  For every
modulus x + iy, Doyle and Schwartz (2025) give one with six edges at each vertex, and six vertices in a plane;
it touches itself, as a limit of embedded ones.
"""

import numpy as np
import pytest

from gluing_polygons import shoelace
from isoembed import PolyhedralMetric, certify, embed, unfold
from isoembed.metric.curvature import area, deficits
from isoembed.surface.alignment import distance

FACES = [[i, (i + 1) % 8, (i + 3) % 8] for i in range(8)] + [[i, (i + 3) % 8, (i + 2) % 8] for i in range(8)]


def pup_tent(x, y):
    q, height = x * x + y * y, np.sqrt(8 * x) * y
    half = [[x - 2 * x * x, y - 2 * x * y, height], [x - q, -y, 0], [2 * x - q, 0, 0], [3 * x - q, y, 0]]
    return np.array(half + [[-a, -b, c] for a, b, c in half[::-1]])


@pytest.mark.parametrize(("x", "y"), [(0.2, 1.0), (0.1, 1.2), (0.3, 0.9)])
def test_a_flat_torus_is_found_from_its_lengths(x, y):
    given = pup_tent(x, y)
    metric = PolyhedralMetric.from_mesh(given, FACES)
    assert metric.triangulation.genus == 1
    assert np.abs(deficits(metric)).max() < 1e-14
    found = embed(metric, boundary="free")
    assert found.residual < 1e-14
    assert distance(found.vertices, given) < 1e-13
    assert certify(found).reason.startswith("not certified: there are 6 more equations than unknowns")
    net = unfold(found)
    assert net.net.deficits == pytest.approx(np.zeros(net.net.n_vertices), abs=1e-12)
    assert sum(map(shoelace, net.sheets)) == pytest.approx(area(metric), rel=1e-12)
