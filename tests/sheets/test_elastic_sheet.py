"""Elastic sheets: minima, held vertices, and steps along curved motions."""

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.elastic_sheet import ElasticSheet
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.vertex_system import HeldTriangle, HeldVertices

POINTS, FACES = discs.hexagonal(4)
X = discs.round_cap(POINTS, 1.0)
METRIC = PolyhedralMetric.from_mesh(X, FACES)
RIM = np.flatnonzero(METRIC.triangulation.boundary_vertices)


HELD = {"rim": HeldVertices.fixed(RIM), "triangle": HeldTriangle.of(X, FACES[0])}


@pytest.mark.parametrize("held", HELD.values(), ids=HELD)
def test_a_minimum(held):
    with Log().stage("elastic sheets") as recorder:
        sheet = ElasticSheet(LengthConstraints(METRIC), BendingEnergy(METRIC).form, held, recorder)
        start = X + 0.01 * np.sin(9 * X)
        start[RIM] = X[RIM]
        found = sheet.relaxed(start, 1e-3, 40, 1e-12)
    fixed = len(held.corners) > 3
    if fixed:
        np.testing.assert_allclose(found[RIM], X[RIM], atol=1e-15)
    rng = np.random.default_rng(0)
    least = sheet.value(found, 1e-3)
    for _ in range(10):
        push = rng.standard_normal(X.shape)
        if fixed:
            push[RIM] = 0.0
        up, down = (sheet.value(found + step * push, 1e-3) - least for step in (1e-4, -1e-4))
        assert min(up, down) > 0
        assert abs(up - down) < 1e-2 * (up + down)  # the slope vanishes
