"""Newton's method on the lengths: from near by at once, with the deviation from its branch, or not at all."""

import numpy as np

import smooth_bodies
from isoembed.aim.acceptance import REALIZED
from isoembed.aim.newton_on_lengths import newton_on_lengths
from isoembed.aim.strategies import LENGTHS_DEVIATION
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem


def solved(share):
    """The solution from a surface that is bent by this share of an edge, and the exact vertices."""
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    metric, x = metric.normalized, vertices / metric.unit
    start = x + share * np.random.default_rng(0).normal(size=x.shape)
    recorder = smooth_bodies.recorder()
    system = LengthSystem(metric.triangulation, work=recorder.work)
    return newton_on_lengths(system, start, metric.lengths, REALIZED, recorder), x, recorder


def test_from_near_by_it_converges_on_its_branch():
    solution, x, recorder = solved(1e-3)
    assert smooth_bodies.misfit(solution.vertices, x) < 1e-9
    assert solution.branch_deviation < LENGTHS_DEVIATION
    assert recorder.factorizations == recorder.iterations <= 6


def test_an_exact_start_is_left_alone():
    solution, x, recorder = solved(0.0)
    assert solution.vertices is not None
    assert (solution.vertices == x).all()
    assert (solution.branch_deviation, recorder.iterations) == (0.0, 0)


def test_from_afar_it_does_not_converge():
    assert solved(1.0)[0] is None
