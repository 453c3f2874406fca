"""Realizations beside one that was found at once, and another one on request."""

from pathlib import Path

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import Aim, Embedding, PolyhedralMetric
from isoembed.aim.acceptance import are_identical
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.gallery import Cone, Ellipsoid, Ergosphere, triangulate
from isoembed.io import read_metric, read_surface

NUMBERS = Path(__file__).parents[3] / "shared" / "trials" / "numbers"


def schoenhardt(degrees):
    """An antiprism of two triangles whose sides are cut along the concave diagonals."""
    below, turn = 2 * np.pi * np.arange(3) / 3, np.radians(degrees)
    x = np.array(
        [(np.cos(a), np.sin(a), 0) for a in below]
        + [(np.cos(a + turn), np.sin(a + turn), 1.2) for a in below]
    )
    sides = [face for i, j in ((0, 1), (1, 2), (2, 0)) for face in ((i, j, 3 + j), (i, 3 + j, 3 + i))]
    return x, [(0, 2, 1), (3, 4, 5), *sides]


def cube(height=0.05):
    """A cube with a flat pyramid on a face, out or in."""
    corners = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
    faces = [each for a, b, c, d in squares for each in ((a, b, c), (a, c, d))]
    faces += [(a, b, 8) for a, b in ((1, 5), (5, 7), (7, 3), (3, 1))]
    return np.vstack([corners, [0.5, 0.5, 1 + height]]), faces


@pytest.mark.parametrize("degrees", [26.0, 28.0, 29.5, 31.0, 34.0])
def test_others_has_the_twin_of_a_schoenhardt_polyhedron(degrees):
    x, faces = schoenhardt(degrees)
    found = isoembed.embed(PolyhedralMetric.from_mesh(x, faces))
    [twin] = found.others
    assert twin.residual < 1e-12
    near = [each for each in isoembed.realizations(found).surfaces if each.distance(found) > 1e-6]
    assert [twin.distance(each) for each in near] == pytest.approx([0], abs=1e-9)
    assert found.uniqueness.kind == "searched"


def test_approximations_of_a_double_root_are_one_realization():
    x, faces = schoenhardt(30.0)  # rigid, with an infinitesimal flex
    found = isoembed.embed(PolyhedralMetric.from_mesh(x, faces))
    assert found.distance(x) < 1e-4
    assert found.others == ()
    assert len(isoembed.realizations(found).surfaces) == 1
    assert "a motion of the vertices may change no length to first order" in isoembed.certify(found).reason
    x, faces = schoenhardt(30.01)
    found = isoembed.embed(PolyhedralMetric.from_mesh(x, faces))
    [twin] = found.others
    assert 1e-5 < twin.distance(found) < 1e-2


def test_residuals_of_fits_do_not_make_surfaces_identical():
    x, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(x, faces)
    exact = Embedding(metric, x, method="known", tolerance=1e-10)
    fit = Embedding(metric, x * (1 + 1e-3 * np.sign(x[:, :1])), method="known", tolerance=1e-2)
    assert fit.residual > 1e-4
    assert not are_identical(exact, fit)
    assert are_identical(exact, exact)


def test_convex_bodies_are_not_searched():
    found = isoembed.embed(PolyhedralMetric.from_mesh(*zoo.random_hull(40, 1)))
    assert "neighbors" not in {stage.name for stage in found.stages}


def test_without_effort_nothing_is_searched():
    """Nor is it for the start of a band, whose holes are filled."""
    x, faces = schoenhardt(29.0)
    metric = PolyhedralMetric.from_mesh(x, faces)
    assert "neighbors" in {stage.name for stage in isoembed.embed(metric).stages}
    found = isoembed.embed(metric, method=Aim(effort=0))
    assert not found.others and "neighbors" not in {stage.name for stage in found.stages}
    vertices, faces = triangulate(Cone(), 60)
    band = isoembed.embed(PolyhedralMetric.from_mesh(vertices, faces), boundary="free")
    assert band.converged and "neighbors" not in {stage.name for stage in band.stages}


def test_the_smoothest_and_the_nearest_on_request():
    x, faces = schoenhardt(29.0)
    metric = PolyhedralMetric.from_mesh(x, faces)
    default = isoembed.embed(metric)
    [twin] = default.others
    smooth = isoembed.embed(metric, method=Aim(which="smoothest"))
    assert smooth.surface.fine_roughness == min(default.surface.fine_roughness, twin.surface.fine_roughness)
    for wanted, other in ((default, twin), (twin, default)):
        near = isoembed.embed(metric, method=Aim(which=7.0 * wanted.vertices))
        assert near.distance(wanted) < 1e-9
        assert min(each.distance(other) for each in near.others) < 1e-9


def test_the_nearest_may_be_one_that_was_not_met():
    x, faces = cube(-0.05)
    metric = PolyhedralMetric.from_mesh(x, faces)
    assert not isoembed.embed(metric).surface.concave_edges.any()
    dented = isoembed.embed(metric, method=Aim(which=x + 1e-3))
    again = isoembed.embed(metric, method=Aim(which=x @ zoo.rotation(1).T - 2.0))
    np.testing.assert_allclose(again.vertices, dented.vertices, rtol=0, atol=1e-9)  # wherever x stands
    assert dented.volume == pytest.approx(1 - 0.05 / 3, abs=1e-12)
    assert not isoembed.embed(metric, method=Aim(which="convex")).surface.concave_edges.any()


def test_no_convex_one_is_a_proof_or_the_end_of_a_search():
    x, faces = schoenhardt(29.0)
    with pytest.raises(NotEmbedded, match="none of the 2 realizations found is convex") as refused:
        isoembed.embed(PolyhedralMetric.from_mesh(x, faces), method=Aim(which="convex"))
    assert refused.value.evidence.kind == "searched"
    assert 'no deficit is negative, and method="alexandrov" finds' in str(refused.value)
    attempt = refused.value.embedding
    assert attempt.residual < 1e-10 and attempt.message == str(refused.value)
    assert attempt.status == isoembed.report(attempt)["status"] == "not found" and not attempt.is_answer
    x, faces = zoo.icosphere(1)
    x = x + np.where(np.arange(len(x)) == 20, 0.5, 0.0)[:, None] * x  # a spike, with deficits < 0 around it
    with pytest.raises(NotEmbedded, match="no convex surface has these lengths: the deficit of") as refused:
        isoembed.embed(PolyhedralMetric.from_mesh(x, faces), method=Aim(which="convex"))
    assert refused.value.evidence.kind == "proved"
    assert not refused.value.embedding.converged  # there is a surface, which was not searched for


@pytest.mark.parametrize("error", [1e-6, 1e-3])
def test_a_convex_fit_is_refused_where_edges_are_concave(error):
    """Errors bend no edge of the hull the wrong way; other triangles of its vertices have concave ones."""
    x, faces = triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60)
    noise = np.random.default_rng(0).normal(scale=error, size=3 * len(x) - 6)
    metrics = [PolyhedralMetric.from_mesh(x, triangles) for triangles in (faces, zoo.outward_hull(x)[1])]
    bent, convex = (metric.with_lengths(metric.lengths + noise) for metric in metrics)
    found = isoembed.embed(convex, method=Aim(which="convex"), length_errors=error)
    assert found.is_requested and not found.surface.concave_edges.any()
    with pytest.raises(
        NotEmbedded, match=r"within their errors is not convex: edge \d+ \[.*\] is concave"
    ) as told:
        isoembed.embed(bent, method=Aim(which="convex"), length_errors=error)
    attempt = told.value.embedding
    assert attempt.status == "not found" and attempt.message == str(told.value)
    assert told.value.evidence.kind == "searched"


@pytest.mark.parametrize(
    ("which", "said"),
    [
        ("flat", 'which is \'flat\', not "convex", "smoothest" or vertices'),
        (np.zeros((4, 2)), r"which has the shape \(4, 2\)"),
        (np.full((6, 3), np.nan), "not finite"),
        (np.zeros((4, 3)), "has 4 vertices, but the metric 6"),
        (np.ones((6, 3)), "coincide"),
    ],
)
def test_other_wishes_are_refused(which, said):
    with pytest.raises(InvalidParameter, match=said):
        isoembed.embed(PolyhedralMetric.from_mesh(*schoenhardt(29.0)), method=Aim(which=which))


@pytest.mark.shared
@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-3, 0.3])
def test_steffens_flexible_surface_is_found_near_a_pose_and_named(noise):
    metric = read_metric(NUMBERS / "04_steffen.json")
    pose = read_surface(NUMBERS / "04_steffen_flexible_pose.json").vertices
    rough = pose + noise * np.random.default_rng(0).standard_normal(pose.shape)
    found = isoembed.embed(metric, method=Aim(which=rough))
    assert found.volume == pytest.approx(17 * 11 * 41.5**0.5 / 6, abs=1e-6)
    assert "the surface is flexible, as far as floats tell" in isoembed.certify(found).reason


@pytest.mark.shared
def test_steffens_lengths_have_a_rigid_surface_that_is_found_without_a_pose():
    assert isoembed.certify(isoembed.embed(read_metric(NUMBERS / "04_steffen.json"))).certified


def test_others_lie_on_the_answer():
    # The tails of the two are as heavy on either side but for what they differ by: their axes point apart.
    surface = isoembed.embed(PolyhedralMetric.from_mesh(*triangulate(Ergosphere(), 200)))
    assert surface.others
    for other in surface.others:
        apart = np.linalg.norm(other.vertices - surface.vertices, axis=1).max()
        assert apart == pytest.approx(other.distance(surface) * surface.metric.mean_length)
