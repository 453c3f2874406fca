"""The regularized continuation: where it leads from the sphere, and that it gives up soon."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed.aim.regularized_continuation import log_linear, regularized_continuation
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.gallery import CassiniPeanut, HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import length_residuals


def normalized(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return metric.normalized, vertices / metric.unit


@pytest.mark.parametrize(
    ("surface", "irregular"),
    [(CassiniPeanut(), 5), (HarmonicSurface(2, 2, 0.2), None)],
    ids=["peanut", "saddle"],
)
def test_it_leads_from_the_sphere_to_smooth_bodies(surface, irregular):
    # From the sphere of directions, whose lengths have little to do with the body's.
    vertices, faces = triangulate(surface, 500, irregular=irregular)
    metric, x = normalized(vertices, faces)
    start = x / np.linalg.norm(x, axis=1)[:, None] * np.linalg.norm(x, axis=1).mean()
    recorder = smooth_bodies.recorder()
    found = regularized_continuation(
        RegularizedEnergy(metric, start, recorder.work), start, log_linear(metric, start), recorder
    ).vertices
    assert np.abs(length_residuals(metric.triangulation, found, metric.lengths)).max() < 1e-6
    assert smooth_bodies.misfit(found, x) < 1e-3
    assert recorder.factorizations <= 30


def test_neither_the_unit_nor_the_numbering_matters():
    vertices, faces = triangulate(CassiniPeanut(), 200)
    found = []
    for scale, seed in ((1.0, None), (0.57, None), (1.9, None), (1.0, 4)):
        moved, others, new = (
            (vertices, faces, np.arange(200)) if seed is None else zoo.relabeled(vertices, faces, seed)
        )
        metric = PolyhedralMetric.from_mesh(scale * moved, others)
        start = scale * moved / np.linalg.norm(moved, axis=1)[:, None]
        recorder = smooth_bodies.recorder()
        energy, path = RegularizedEnergy(metric, start, recorder.work), log_linear(metric, start)
        x = regularized_continuation(energy, start, path, recorder).vertices
        found.append((x[new] / scale, recorder.factorizations))
    for x, factorizations in found[1:]:
        assert factorizations == found[0][1] > 0
        assert smooth_bodies.misfit(x, found[0][0]) < 1e-9


def test_lengths_without_a_surface_are_given_up_soon():
    metric, x = normalized(*smooth_bodies.ellipsoid())
    noise = np.random.default_rng(0).uniform(-0.1, 0.1, len(metric.lengths))
    lengths = metric.lengths * (1 + noise)
    recorder = smooth_bodies.recorder()
    found = regularized_continuation(
        RegularizedEnergy(metric, x, recorder.work),
        x,
        lambda t: metric.lengths**t * lengths ** (1 - t),
        recorder,
    ).vertices
    assert np.abs(length_residuals(metric.triangulation, found, lengths)).max() > 1e-6
    assert recorder.factorizations <= 50
