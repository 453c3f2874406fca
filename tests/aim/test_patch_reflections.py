"""Realizations of metrics with dents."""

import numpy as np
import pytest

import isoembed
import smooth_bodies
from isoembed import PolyhedralMetric, embed
from isoembed.aim.patch_reflections import HarmonicPatch, reflected_realizations
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.gallery import Sphere, triangulate
from isoembed.metric.dents import dents
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.surface.rigidity import LengthSystem, length_residuals

TWO = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))


def test_a_patch_with_a_plane_rim_is_reflected_in_its_plane():
    vertices, faces = triangulate(Sphere(), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    patch = vertices[:, 2] > 0.6
    rim = ~patch & (metric.triangulation.adjacency @ patch.astype(float) > 0)
    x = np.where(rim[:, None], [1, 1, 0] * vertices + [0, 0, 0.6], vertices)
    laplacian = cotangent_laplacian(GluedMetric.of(metric)).tocsr()
    reflected = HarmonicPatch.of(laplacian, patch).reflected(faces, x)
    expected = np.where(patch[:, None], [1, 1, -1] * x + [0, 0, 1.2], x)
    assert np.abs(reflected - expected).max() < 1e-14


def test_a_patch_reflected_twice_is_as_it_was():
    vertices, faces = smooth_bodies.dimpled(400)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    (patch,) = dents(metric)
    spanned = HarmonicPatch.of(cotangent_laplacian(GluedMetric.of(metric)).tocsr(), patch)
    once = spanned.reflected(faces, vertices)
    assert once[patch, 2].mean() > vertices[patch, 2].mean() + 0.05
    assert (once[~patch] == vertices[~patch]).all()
    assert np.abs(spanned.reflected(faces, once) - vertices).max() < 1e-14


def test_a_dimple_is_found_and_pushed_out_is_another_realization():
    vertices, faces = smooth_bodies.dimpled(500, depth=0.5, width=0.5)
    surface = embed(PolyhedralMetric.from_mesh(vertices, faces))
    assert smooth_bodies.misfit(surface.vertices, vertices) < 1e-9
    assert "guided pull back" not in [stage.name for stage in surface.stages]
    pushed_out = [
        k for k, row in enumerate(isoembed.report(surface)["other_realizations"]) if row["mirrored"] == 1
    ]
    assert pushed_out
    assert surface.others[pushed_out[0]].volume > surface.volume + 0.02
    assert "a mirror choice: one dent of one is a bump of the other" in surface.message


def search(vertices, faces, factor=1.0):
    """The search among the choices of a dimpled sphere, from the sphere, and its metric and recorder."""
    given = PolyhedralMetric.from_mesh(vertices, faces)
    metric = given.with_lengths(given.lengths * factor).normalized
    start = vertices / np.linalg.norm(vertices, axis=1)[:, None] / given.unit
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, start, recorder.work)
    system = LengthSystem(metric.triangulation, work=recorder.work)
    choices = reflected_realizations(metric, system, energy, start, dents(metric), recorder)
    return choices, metric, recorder


def residual(metric, x):
    return np.abs(length_residuals(metric.triangulation, x, metric.lengths)).max()


def test_all_dimples_are_pushed_in_first_and_no_more_is_done_than_is_asked_for():
    vertices, faces = smooth_bodies.dimpled(500, TWO)
    unit = PolyhedralMetric.from_mesh(vertices, faces).unit
    choices, metric, recorder = search(vertices, faces)
    first = next(choices)
    assert residual(metric, first) < 1e-10
    assert smooth_bodies.misfit(unit * first, vertices) < 1e-9
    assert recorder.factorizations < 20
    others = list(choices)
    assert 2 <= len(others) <= 7
    for other in others:
        assert smooth_bodies.misfit(unit * other, vertices) > 1e-3


def test_lengths_that_no_choice_has_are_given_up():
    vertices, faces = smooth_bodies.dimpled(300, TWO)
    rng = np.random.default_rng(0)
    n = PolyhedralMetric.from_mesh(vertices, faces).triangulation.n_edges
    choices, metric, _ = search(vertices, faces, 1 + 1e-2 * rng.standard_normal(n))
    tried = list(choices)
    assert 1 <= len(tried) <= 2
    assert min(residual(metric, x) for x in tried) > 1e-8


def test_a_start_that_is_too_far_from_the_lengths_is_given_up_at_once():
    vertices, faces = smooth_bodies.dimpled(300, TWO)
    metric = PolyhedralMetric.from_mesh(vertices * [6.0, 1.0, 1.0], faces)
    patches = dents(PolyhedralMetric.from_mesh(vertices, faces))
    start = vertices * [1.0, 6.0, 1.0]
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, start, recorder.work)
    system = LengthSystem(metric.triangulation, work=recorder.work)
    assert not list(reflected_realizations(metric, system, energy, start, patches, recorder))
    assert recorder.factorizations < 20


@pytest.mark.slow
def test_dimples_on_an_ellipsoid_are_found():
    centers = ((0.0, 0.0, 1.0), (0.0, 0.8, -0.6), (1.0, 0.0, 0.0))
    vertices, faces = smooth_bodies.dimpled(1200, centers, depth=0.25, width=0.3)
    vertices = vertices * [1.5, 1.2, 1.0]
    surface = embed(PolyhedralMetric.from_mesh(vertices, faces))
    assert smooth_bodies.misfit(surface.vertices, vertices) < 1e-9
