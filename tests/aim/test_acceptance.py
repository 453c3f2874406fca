"""What counts as a realization, by residual and tolerance."""

import pytest

import zoo
from isoembed.aim.acceptance import is_accepted, is_exact, is_near, is_realization
from isoembed.embedding.embedding import Embedding
from isoembed.metric.polyhedral import PolyhedralMetric


@pytest.mark.parametrize(
    ("residual", "tolerance", "accepted", "exact", "near", "realization"),
    [
        (5e-12, 1e-10, True, True, True, True),
        (5e-12, 1e-13, True, True, True, False),  # a tolerance below rounding
        (5e-11, 1e-13, False, False, True, False),
        (5e-11, 1e-8, True, True, True, True),
        (5e-9, 1e-8, True, False, True, True),
        (5e-5, 1e-3, True, False, False, False),  # however loose the tolerance is
    ],
)
def test_acceptance(residual, tolerance, accepted, exact, near, realization):
    vertices, faces = zoo.octahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = Embedding(metric, vertices * (1 + residual), method="given", tolerance=tolerance)
    assert surface.residual == pytest.approx(residual, rel=1e-3)
    assert (is_accepted(surface), is_exact(surface)) == (accepted, exact)
    assert (is_near(surface), is_realization(surface)) == (near, realization)
