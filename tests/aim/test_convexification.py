"""The convex metric near a given one: curvature that diffuses, and the conformal change that follows it."""

import numpy as np
import pytest

import curved_bodies
import smooth_bodies
import zoo
from isoembed.aim.convexification import FAR_MARGIN, NEAR_MARGIN, Convexification
from isoembed.gallery import CassiniPeanut, Ergosphere, triangulate
from isoembed.linalg import SingularMatrix
from isoembed.metric.curvature import deficits
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space


def convexified(metric, recorder):
    return Convexification(metric).metric(FAR_MARGIN, recorder)


def is_convex(metric):
    return Convexification(metric).is_convex


def glued(vertices, faces):
    return GluedMetric.of(PolyhedralMetric.from_mesh(vertices, faces).normalized)


def test_a_convex_metric_is_its_own_convexification():
    for mesh in (zoo.random_hull(20, 0), zoo.cube(), smooth_bodies.ellipsoid()):
        metric, recorder = glued(*mesh), smooth_bodies.recorder()
        assert convexified(metric, recorder) is metric
        assert recorder.factorizations == 0


@pytest.mark.parametrize("surface", [CassiniPeanut(), Ergosphere(epsilon=0.1)], ids=str)
def test_it_is_convex_with_a_margin_and_near(surface):
    metric, recorder = glued(*triangulate(surface, 400)), smooth_bodies.recorder()
    assert not is_convex(metric)
    convex = convexified(metric, recorder)
    assert is_convex(convex)
    assert recorder.factorizations <= 10
    areas = convex.triangles.areas
    share = 4 * np.pi / 3 * np.bincount(convex.faces.ravel(), np.repeat(areas / areas.sum(), 3))
    assert (convex.deficits > FAR_MARGIN / 4 * share).all()
    # Large shapes stay: the curvature of each half of the body has hardly changed.
    assert convex.deficits.sum() == pytest.approx(4 * np.pi, abs=1e-9)
    assert np.abs(convex.deficits - metric.deficits).max() < np.abs(metric.deficits).max()


def test_the_first_step_needs_no_factor():
    metric, recorder = glued(*smooth_bodies.drum()), smooth_bodies.recorder()
    convex = Convexification(metric).metric(NEAR_MARGIN, recorder)
    assert is_convex(convex)
    assert recorder.factorizations == 0


@pytest.mark.parametrize("scale", [0.3, 0.6, 1.7, 2.9])
def test_the_unit_does_not_matter(scale):
    # The curvature is positive after a short time, near the first that is tried.
    vertices, faces = zoo.random_hull(60, 3)
    dents = 1 + 0.06 * np.random.default_rng(3).normal(size=len(vertices))[:, None]
    metric = glued(vertices * dents, faces)
    assert not is_convex(metric)
    convex, scaled = (convexified(m, smooth_bodies.recorder()) for m in (metric, metric.scaled(scale)))
    assert (scaled.faces == convex.faces).all()
    np.testing.assert_allclose(scaled.face_lengths / scale, convex.face_lengths, rtol=1e-9)


def test_a_small_dent_needs_a_small_change_only():
    # The change falls off around the dent: at the far side of the sphere, the curvature stays.
    vertices, faces = zoo.icosphere(3)
    dent = vertices * (1 - 0.1 * np.exp(-np.sum((vertices - vertices[0]) ** 2, axis=1) / 0.02))[:, None]
    metric = glued(dent, faces)
    assert not is_convex(metric)
    convex = convexified(metric, smooth_bodies.recorder())
    assert is_convex(convex)
    far = vertices @ vertices[0] < -0.5
    near = np.abs(convex.deficits - metric.deficits).max()
    assert np.abs(convex.deficits - metric.deficits)[far].max() < 1e-2 * near


def test_lengths_far_from_any_surface_have_one_too():
    vertices, faces = zoo.random_hull(60, 3)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    ones = metric.with_lengths(np.ones(len(metric.lengths)))
    assert deficits(ones).min() < -2  # vertices with nine and more triangles
    assert is_convex(convexified(GluedMetric.of(ones), smooth_bodies.recorder()))


def test_where_the_laplacian_is_singular_there_is_none(monkeypatch):
    def refused(*_):
        raise SingularMatrix("triangles too thin for floats")

    metric = glued(*triangulate(Ergosphere(epsilon=0.02), 100))
    monkeypatch.setattr("isoembed.linalg.factor.Solver.factor", refused)
    assert convexified(metric, smooth_bodies.recorder()) is None


def test_a_larger_margin_goes_on_from_a_smaller_one():
    metric = glued(*triangulate(CassiniPeanut(), 300))
    both, recorders = Convexification(metric), [smooth_bodies.recorder() for _ in range(3)]
    near = both.metric(NEAR_MARGIN, recorders[0])
    far = both.metric(FAR_MARGIN, recorders[1])
    alone = Convexification(metric).metric(FAR_MARGIN, recorders[2])
    assert (far.face_lengths == alone.face_lengths).all()
    assert (far.faces == alone.faces).all()
    assert recorders[1].iterations < recorders[2].iterations
    assert 0 < near.deficits.min() <= far.deficits.min()


@pytest.mark.parametrize(("curvature", "size"), [(-1.0, 0.3), (-1.0, 1.0), (1.0, 0.3), (1.0, 0.8)])
def test_in_curved_space_it_has_a_margin_over_the_curvature_of_space_and_the_same_area(curvature, size):
    space = Space(curvature)
    x, faces = curved_bodies.smooth(space, CassiniPeanut(), 300, size)
    metric, recorder = (
        GluedMetric.of(curved_bodies.metric_of(space, x, faces).normalized),
        smooth_bodies.recorder(),
    )
    convexification = Convexification(metric)
    assert not convexification.is_convex
    convex = convexification.metric(FAR_MARGIN, recorder)
    assert convex.curvature == metric.curvature
    assert is_convex(convex)
    assert recorder.factorizations <= 5
    total = 4 * np.pi - convex.curvature * convex.triangles.areas.sum() * convex.triangles.unit**2
    assert convex.deficits.sum() == pytest.approx(total, abs=1e-9)
    areas = convex.triangles.areas
    share = total / 3 * np.bincount(convex.faces.ravel(), np.repeat(areas / areas.sum(), 3))
    assert (convex.deficits > FAR_MARGIN / 4 * share).all()
    assert np.abs(convex.deficits - metric.deficits).max() < np.abs(metric.deficits).max()


def test_of_most_of_a_sphere_it_is_that_of_a_smaller_metric():
    space = Space(1.0)
    u, faces = zoo.icosphere(2)
    waist = (1 + 0.5 * u[:, 2]) * (1 - 0.5 * np.exp(-6 * u[:, 2] ** 2)) / 2
    x = curved_bodies.carried(space, 1.3 * u * np.c_[waist, waist, np.ones(len(u))])
    metric = GluedMetric.of(curved_bodies.metric_of(space, x, faces))
    convex = convexified(metric, smooth_bodies.recorder())
    assert is_convex(convex)
    assert convex.curvature == metric.curvature
    assert convex.mean_length < 0.7 * metric.mean_length
