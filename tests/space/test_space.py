"""Points of Euclidean, hyperbolic and spherical space, their isometries and models."""

import numpy as np
import pytest

from isoembed import Euclidean, Hyperbolic, InvalidParameter, Space, Spherical
from isoembed.space.models import MODELS, from_model, to_model

SPACES = [Euclidean(), Hyperbolic(1.0), Hyperbolic(0.3), Spherical(0.4), Hyperbolic(1e-14), Spherical(1e-300)]


@pytest.fixture
def points():
    return 0.4 * np.random.default_rng(0).standard_normal((20, 3))


def test_names():
    assert [repr(s) for s in SPACES[:4]] == [
        "Euclidean()",
        "Hyperbolic(1.0)",
        "Hyperbolic(0.3)",
        "Spherical(0.4)",
    ]
    assert Hyperbolic(0.25).radius == 2.0
    assert Space(-0.0) == Euclidean() and Euclidean().radius == np.inf
    assert Hyperbolic(1.0).scaled(2.0) == Hyperbolic(0.25)


@pytest.mark.parametrize("k", [0.0, -1.0, np.nan, np.inf, "1", None])
def test_no_curvature_of_this_sign(k):
    with pytest.raises(InvalidParameter, match="curvature of space"):
        Hyperbolic(k)
    with pytest.raises(InvalidParameter, match=r"not -1\.0; Hyperbolic\(k\) has the curvature -k$"):
        Hyperbolic(-1.0)
    with pytest.raises(InvalidParameter, match="curvature of space"):
        Spherical(k)


@pytest.mark.parametrize("k", [np.nan, np.inf, "1", None])
def test_no_curvature(k):
    with pytest.raises(InvalidParameter, match="not a finite number"):
        Space(k)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_distances_are_those_along_rays(space):
    u = np.array([0.6, 0.0, 0.8])
    r = np.array([0.1, 0.5, 1.4])
    x = space.sn(r)[:, None] * u
    assert np.allclose(space.distances(x, np.zeros(3)), r, rtol=1e-15)
    assert np.allclose(space.distances(x[2], x), 1.4 - r, rtol=0, atol=1e-15)
    assert np.allclose(space.distances(x[2], -x), 1.4 + r, rtol=1e-14)


def test_distances_far_out_in_hyperbolic_space():
    space, r = Hyperbolic(1.0), np.array([9.0, 8.5])
    x, y = space.sn(r)[:, None] * np.array([0.48, 0.6, 0.64])
    assert space.distances(x, y) == pytest.approx(0.5, rel=1e-11)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_translations_keep_distances(space, points):
    a = np.array([0.3, -0.2, 0.5])
    moved = space.translated(points, a)
    assert np.allclose(space.translated(np.zeros(3), a), a, rtol=1e-15)
    assert np.allclose(
        space.distances(moved[:, None], moved), space.distances(points[:, None], points), rtol=0, atol=2e-15
    )
    assert np.allclose(space.translated(moved, -a), points, rtol=0, atol=2e-15)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_points_seen_from_others(space, points):
    x, y = points[:10], points[10:]
    moved = [space.translated(b, -a) for a, b in zip(x, y, strict=True)]
    assert np.allclose(space.seen_from(x, y), moved, rtol=0, atol=1e-15)


def test_what_is_seen_beyond_the_half_of_the_sphere():
    a, b = np.array([0.9, 0.0, 0.0]), np.array([-0.9, 0.3, 0.0])
    seen = Spherical(1.0).seen_from(a, b)
    assert np.arctan2(*seen[[1, 0]]) > np.pi / 2
    assert np.linalg.norm(seen) == pytest.approx(np.sin(Spherical(1.0).distances(a, b)), rel=1e-14)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_exponential_map(space, points):
    x, y = points[:10], points[10:]
    v = space.logarithm(x, y)
    assert np.allclose(np.linalg.norm(v, axis=1), space.distances(x, y), rtol=1e-14)
    assert np.allclose(space.exponential(x, v), y, rtol=0, atol=2e-15)
    middle = space.exponential(x, v / 2)
    assert np.allclose(space.distances(x, middle), space.distances(middle, y), rtol=1e-13)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_centered(space, points):
    x = space.centered(points)
    assert np.abs(x.mean(axis=0)).max() < 1e-15
    assert np.allclose(space.distances(x[0], x), space.distances(points[0], points), rtol=0, atol=2e-15)


@pytest.mark.parametrize("space", SPACES, ids=repr)
@pytest.mark.parametrize("model", MODELS)
def test_models_and_back(space, model, points):
    assert np.allclose(from_model(space, to_model(space, points, model), model), points, rtol=0, atol=1e-15)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_lines_are_straight_in_projective_coordinates(space, points):
    x, y = points[:10], points[10:]
    path = [space.exponential(x, t * space.logarithm(x, y)) for t in (0.0, 0.3, 1.0)]
    a, b, c = (to_model(space, p, "projective") for p in path)
    assert np.abs(np.cross(b - a, c - a)).max() < 1e-15


def test_conformal_coordinates_measure_angles():
    space, x = Hyperbolic(1.0), np.array([0.5, 0.2, -0.3])
    steps = 1e-5 * np.eye(3)
    p = to_model(space, space.exponential(x, steps), "conformal") - to_model(space, x, "conformal")
    gram = p @ p.T
    assert np.allclose(gram / gram[0, 0], np.eye(3), atol=1e-4)


def test_flat_limit(points):
    off = [
        np.abs(
            Space(k).distances(points[:10], points[10:]) - np.linalg.norm(points[:10] - points[10:], axis=1)
        )
        for k in (-1e-2, -1e-3, 1e-3, -1e-14)
    ]
    assert 9 < off[0].max() / off[1].max() < 11
    assert off[2].max() < 1e-3 and off[3].max() < 1e-14


def test_no_such_model():
    with pytest.raises(
        InvalidParameter, match="the model is 'klein', none of conformal, projective, ambient"
    ):
        from_model(Hyperbolic(1.0), np.zeros((1, 3)), "klein")


def test_outside_of_the_ball_or_the_half_sphere():
    with pytest.raises(InvalidParameter, match=r"point 1 is 2\.5 from the center of the conformal model"):
        from_model(Hyperbolic(1.0), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.5]]), "conformal")
    with pytest.raises(InvalidParameter, match=r"point 0 is .*, which is not finite"):
        from_model(Hyperbolic(1.0), np.array([[0.0, 0.0, np.nan]]), "projective")
    with pytest.raises(InvalidParameter, match="point 1 is moved out of the half"):
        Spherical(1.0).translated(np.array([[0.0, 0, 0], [0.9, 0, 0]]), np.array([0.9, 0, 0]))


def test_a_curvature_that_has_lost_its_digits_is_none():
    assert Space(-5e-324) == Euclidean() == Hyperbolic(1e-200).scaled(1e80)
    assert Hyperbolic(1e-300).scaled(1e-3).curvature == pytest.approx(-1e-294, rel=1e-15)
    with pytest.raises(InvalidParameter, match="True, not a finite number"):
        Space(True)
    with pytest.raises(InvalidParameter, match=r"point 0 is \[nan, 0\.0, 0\.0\], which is not finite"):
        from_model(Hyperbolic(1.0), np.array([[np.nan, 0.0, 0.0]]), "ambient")


@pytest.mark.parametrize("method", ["aim", "alexandrov"])
def test_an_embedding_is_in_the_space_of_its_metric(method):
    import isoembed

    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    metric = isoembed.PolyhedralMetric(faces, [1e-12] * 6, curvature=-3e-300)
    found = isoembed.embed(metric, method=method)
    assert found.space == metric.space
    assert found.area == pytest.approx(np.sqrt(3) * 1e-24, rel=1e-12)
