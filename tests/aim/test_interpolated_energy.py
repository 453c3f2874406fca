"""The energy of a coarse surface, measured on fine edges."""

import numpy as np
import pytest

import smooth_bodies
from isoembed.aim.interpolated_energy import InterpolatedEnergy
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolation import Stencils


@pytest.fixture(scope="module")
def body():
    """A metric, an ellipsoid of other lengths on its triangles, stencils, and the true positions."""
    x, faces = triangulate(Ellipsoid((1.3, 1.1, 1)), 2000)
    metric = PolyhedralMetric.from_mesh(x, faces)
    convex = x * [1.0, 1.1, 1.2] / metric.unit
    cells = VertexCells.of(metric.triangulation, metric.normalized.lengths, convex, 400)
    stencils = Stencils(cells, cells.triangulation(convex))
    return metric.normalized, convex, stencils, x / metric.unit


def test_the_true_surface_has_hardly_an_error(body):
    metric, convex, stencils, x = body
    energy = InterpolatedEnergy(metric, stencils, convex, convex)
    chosen = stencils.cells.vertices
    assert np.abs(energy.residuals(x[chosen], energy.lengths)).max() < 2e-2
    assert np.abs(energy.residuals(convex[chosen], energy.lengths)).max() > 0.2


def test_forces_are_the_gradient_of_the_errors(body):
    metric, convex, stencils, _ = body
    energy = InterpolatedEnergy(metric, stencils, convex, convex)
    z = convex[stencils.cells.vertices]
    direction = np.random.default_rng(0).normal(size=z.shape)

    def half_square(s):
        r = energy.residuals(z + s * direction, energy.lengths)
        return r @ r / 2

    forces = energy.forces(z, energy.lengths, energy.residuals(z, energy.lengths))
    slope = (half_square(1e-4) - half_square(-1e-4)) / 2e-4
    assert np.sum(forces * direction) == pytest.approx(slope, rel=1e-5)


def test_steps_lead_to_the_true_surface(body):
    metric, convex, stencils, x = body
    z, chosen, recorder = convex[stencils.cells.vertices], stencils.cells.vertices, smooth_bodies.recorder()
    energy = InterpolatedEnergy(metric, stencils, convex, convex, recorder.work)
    for _ in range(8):
        z = energy.relaxed(z, energy.lengths, 1e-5 * energy.unit**2, 0.0, recorder)
    assert smooth_bodies.misfit(z, x[chosen]) < 2e-4
    assert 0 < recorder.factorizations < recorder.iterations  # one serves several steps
