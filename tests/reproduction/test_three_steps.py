"""The nets of the figure of the three steps."""

import numpy as np
import pytest

from isoembed import PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate
from reproduction import three_steps
from sections import check_section


@pytest.fixture(scope="module")
def section():
    return three_steps.study(vertices=60)


def test_the_section_can_be_written(section):
    check_section(section)


def test_the_nets_are_the_metrics(section):
    metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid(), 60))
    (illustration,) = section.figures
    before, after, *_ = illustration.figure.axes
    corners = np.array([path.vertices[:3] for path in before.collections[0].get_paths()])
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    np.testing.assert_allclose(sides, metric.face_lengths, rtol=1e-12)
    (a, b), (c, d) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    assert (a * d - b * c > 0).all()  # none is turned over
    # A spanning tree joins the triangles: at least as many sides of it lie on each other.
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    twins = metric.triangulation.twins
    apart = np.linalg.norm(middles.reshape(-1, 2) - middles.reshape(-1, 2)[twins], axis=1)
    assert (apart < 1e-10).sum() >= 2 * (metric.triangulation.n_faces - 1)
    assert len(after.collections[0].get_paths()) == metric.triangulation.n_faces
    low, high = section.numbers["curvature_after"]
    assert 1 - low < 1e-2
    assert high - 1 < 1e-2
    assert section.numbers["curvature_before"][1] > 5
    assert section.numbers["residual"] < 1e-10
