"""The embedding measures itself: residuals of what is returned, the report, mirror images, any scale."""

import json
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import isoembed
import zoo
from isoembed.embedding.embedding import Embedding
from isoembed.errors import NotEmbedded
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Stage
from isoembed.surface import curvature, smoothness
from isoembed.surface.rigidity import LengthSystem


def embedding(vertices, faces, scale=1.0, **changes):
    metric = PolyhedralMetric.from_mesh(scale * vertices, faces)
    options = {"method": "test", "tolerance": 1e-10} | changes
    return Embedding(metric, scale * vertices, **options)


def test_an_exact_embedding():
    surface = embedding(*zoo.cube(), stages=[Stage("guess", 0.5, 3, 2)])
    assert surface.residual < 1e-15
    assert surface.converged
    assert surface.status == "converged"
    assert surface.message.startswith("the lengths are within the tolerance 1e-10: the largest residual is")
    assert surface.area == pytest.approx(6, rel=1e-14)
    assert surface.volume == pytest.approx(1, rel=1e-14)
    assert surface.integrated_mean_curvature == pytest.approx(3 * np.pi, rel=1e-14)
    assert surface.stages == (Stage("guess", 0.5, 3, 2),)
    assert "8 vertices" in repr(surface)
    assert "'test', converged" in repr(surface)


def test_residuals_are_differences_of_lengths_over_the_mean_length():
    vertices, faces = zoo.octahedron()  # all lengths sqrt 2
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    pulled = vertices.copy()
    tip = int(np.argmax(vertices[:, 0]))
    pulled[tip, 0] = 2.0  # its four edges become sqrt 5
    surface = Embedding(metric, pulled, method="test", tolerance=0.1)
    wrong = (surface.triangulation.edges == tip).any(axis=1)
    assert surface.residuals[wrong] == pytest.approx(5**0.5 / 2**0.5 - 1, rel=1e-14)
    assert surface.residuals[~wrong] == pytest.approx(0, abs=1e-15)
    assert surface.residual == surface.residuals.max()
    assert not surface.converged
    assert surface.status == "not converged"
    worst = int(np.argmax(wrong))
    assert surface.message == (
        "the lengths miss the tolerance 1e-01: the largest residual is 5.8e-01 of the mean edge length, "
        f"at edge {worst} {surface.metric.edges[worst].tolist()}"
    )


def test_the_tolerance_itself_is_within_the_tolerance():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    largest = Embedding(metric, 1.001 * vertices, method="test", tolerance=1.0).residual
    assert Embedding(metric, 1.001 * vertices, method="test", tolerance=largest).converged
    assert not Embedding(
        metric, 1.001 * vertices, method="test", tolerance=np.nextafter(largest, 0)
    ).converged


def test_a_mirror_image_is_turned_over():
    vertices, faces = zoo.random_hull(30, 0)
    right, mirrored = embedding(vertices, faces), embedding(vertices * [-1, 1, 1], faces)
    assert mirrored.volume == pytest.approx(right.volume, rel=1e-12)
    assert not mirrored.surface.concave_edges.any()
    assert mirrored.residual < 1e-14


def test_faces_that_are_all_reversed_are_fine():
    vertices, faces = zoo.random_hull(30, 0)
    right, reversed_ = embedding(vertices, faces), embedding(vertices, faces[:, ::-1])
    assert np.array_equal(reversed_.faces, faces[:, ::-1])
    assert reversed_.volume == pytest.approx(right.volume, rel=1e-12)
    assert reversed_.integrated_mean_curvature == pytest.approx(right.integrated_mean_curvature, rel=1e-12)
    assert not reversed_.surface.concave_edges.any()


def test_dents_are_counted():
    vertices, faces = zoo.icosphere(2)
    dented = vertices.copy()
    dented[100] *= 0.8
    surface = embedding(dented, faces)
    assert np.flatnonzero(surface.surface.inverted_vertices).tolist() == [100]
    assert isoembed.report(surface)["convexity"] == {
        "concave_edges": 6,
        "inverted_vertices": 1,
        "partially_inverted_vertices": int(surface.surface.partially_inverted_vertices.sum()),
    }
    assert isoembed.report(surface)["input"]["negative_deficits"] > 0
    partially = surface.surface.partially_inverted_vertices.sum()
    assert surface.message.endswith(
        f"; 1 inverted and {partially} partially inverted vertices: the surface may be crumpled"
    )


def test_another_message_for_the_same_embedding():
    surface = embedding(*zoo.octahedron(), stages=[Stage("guess", 0.5, 3, 2)])
    other = surface._with_message("as said")
    assert other.message == "as said"
    assert isoembed.report(other) == isoembed.report(surface) | {"message": "as said"}
    assert np.array_equal(other.vertices, surface.vertices)


def test_the_report_is_the_contract():
    surface = embedding(*zoo.icosphere(1), stages=[Stage("layout", 0.25, 7, 4)], message="as asked")
    report = json.loads(json.dumps(isoembed.report(surface)))
    assert set(report) >= {
        "status", "message", "method", "version", "input", "residual", "convexity", "smoothness",
        "area", "volume", "integrated_mean_curvature", "stages",
    }  # fmt: skip
    assert report["status"] == "converged"
    assert report["message"] == "as asked"
    assert report["method"] == "test"
    assert report["version"] == isoembed.__version__
    counts = {"vertices": 42, "edges": 120, "faces": 80, "negative_deficits": 0}
    assert report["input"] == {**counts, "mean_length": surface.metric.mean_length, "precision": None}
    assert set(report["residual"]) == {"max", "mean", "std", "edge", "given_length", "length"}
    assert report["residual"]["max"] == surface.residual
    assert report["residual"]["mean"] == pytest.approx(surface.residuals.mean())
    assert report["residual"]["std"] == pytest.approx(surface.residuals.std())
    assert report["smoothness"] == {
        "bending_energy": surface.surface.bending_energy,
        "roughness": surface.surface.roughness,
        "fine_roughness": surface.surface.fine_roughness,
        "rough_edges": 0,
        "smallest_singular_value": isoembed.Sensitivity(surface).smallest_singular_value,
    }
    assert report["stages"] == [{"name": "layout", "seconds": 0.25, "iterations": 7, "factorizations": 4}]


def test_a_report_measures_its_surface_once(monkeypatch):
    counts = Counter()

    def counted(module, name):
        function = getattr(module, name)

        def count(*given):
            counts[name] += 1
            return function(*given)

        monkeypatch.setattr(module, name, count)

    counted(curvature, "folds")
    counted(smoothness, "spatial_order")
    assert isoembed.report(embedding(*zoo.icosphere(1)))["convexity"]["concave_edges"] == 0
    assert counts == {"folds": 2, "spatial_order": 1}  # once more where the neighbors expect the vertices


def test_flat_vertices_are_not_negative_deficits():
    vertices, faces = zoo.subdivided(*zoo.subdivided(*zoo.cube()))
    surface = embedding(vertices @ zoo.rotation(2).T, faces)
    assert isoembed.report(surface)["input"]["negative_deficits"] == 0


def test_mean_curvature_of_a_sphere():
    vertices, faces = zoo.icosphere(3)
    surface = embedding(vertices, faces, scale=4.0)
    assert surface.mean_curvature.mean() == pytest.approx(1 / 4, rel=5e-3)


@pytest.mark.parametrize("scale", [1e-150, 1e-12, 1e12, 1e150])
def test_any_scale(scale):
    vertices, faces = zoo.random_hull(30, 1)
    unit, scaled = embedding(vertices, faces), embedding(vertices, faces, scale)
    assert scaled.converged
    assert np.array_equal(scaled.surface.concave_edges, unit.surface.concave_edges)
    assert scaled.integrated_mean_curvature / scale == pytest.approx(
        unit.integrated_mean_curvature, rel=1e-12
    )
    assert scaled.mean_curvature * scale == pytest.approx(unit.mean_curvature, rel=1e-10)
    json.dumps(isoembed.report(scaled), allow_nan=False)
    if scale < 1e100:
        assert scaled.area == pytest.approx(unit.area * scale**2, rel=1e-12, abs=0)
    else:
        assert isoembed.report(scaled)["volume"] is None  # 1e450 is no float


def test_a_mirror_image_is_turned_over_at_any_scale():
    vertices, faces = zoo.random_hull(30, 1)
    assert not embedding(vertices * [1, -1, 1], faces, 1e-150).surface.concave_edges.any()


@given(seed=st.integers(0, 10**6))
def test_rigid_motions_change_no_measure(seed):
    vertices, faces = zoo.random_hull(20, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    here = Embedding(metric, vertices, method="test", tolerance=1e-10)
    there = Embedding(metric, vertices @ zoo.rotation(seed).T + [4, -5, 6], method="test", tolerance=1e-10)
    assert there.residual < 1e-13
    assert there.area == pytest.approx(here.area, rel=1e-12)
    assert there.volume == pytest.approx(here.volume, rel=1e-11)
    assert there.integrated_mean_curvature == pytest.approx(here.integrated_mean_curvature, rel=1e-9)


def test_vertices_are_copied_and_read_only():
    vertices, faces = zoo.tetrahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = Embedding(metric, vertices, method="test", tolerance=1e-10)
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices[0] = 0
    with pytest.raises(AttributeError):
        surface.method = "other"
    before = surface.vertices.copy()
    vertices[0] = 0
    assert np.array_equal(surface.vertices, before)


def test_the_vertices_come_back_as_they_were_given():
    vertices, faces = zoo.random_hull(30, 2)
    assert embedding(vertices, faces).vertices == pytest.approx(vertices, rel=1e-15, abs=0)


def test_refusals():
    vertices, faces = zoo.tetrahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with pytest.raises(ValueError, match=r"the vertices have shape \(3, 3\), not \(4, 3\)"):
        Embedding(metric, vertices[:3], method="test", tolerance=1e-10)
    vertices[2, 1] = np.inf
    with pytest.raises(
        ValueError, match=r"vertex 2 has the coordinates \[-1.0, inf, -?1.0\], which are not finite"
    ):
        Embedding(metric, vertices, method="test", tolerance=1e-10)


def test_a_failure_carries_the_best_attempt():
    surface = embedding(*zoo.tetrahedron())
    failure = NotEmbedded("the pull-back stopped at t = 0.5", surface)
    assert str(failure) == "the pull-back stopped at t = 0.5"
    assert failure.embedding is surface


def test_edges_normals_and_angles_of_a_cube():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    cube = embedding(corners, [half for q in quads for half in (q[:3], [q[0], *q[2:]])])
    assert (cube.edges == cube.metric.edges).all()
    assert cube.lengths == pytest.approx(cube.metric.lengths, rel=1e-15)
    assert sorted(map(tuple, np.abs(cube.normals))) == sorted(4 * [(0, 0, 1), (0, 1, 0), (1, 0, 0)])
    middles = cube.vertices[cube.faces].mean(axis=1) - cube.vertices.mean(axis=0)
    assert (np.einsum("fi,fi->f", cube.normals, middles) > 0).all()
    bent = np.abs(cube.dihedral_angles) > 1e-9
    assert bent.sum() == 12
    assert cube.dihedral_angles[bent] == pytest.approx(np.pi / 2)


def test_lengths_are_those_of_the_surface_and_not_those_asked_for():
    x, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(3 * x, faces)
    surface = Embedding(metric, x, method="given", tolerance=1e-10)
    assert surface.lengths == pytest.approx(metric.lengths / 3)
    assert surface.residual == pytest.approx(2 / 3 * metric.lengths.max() / metric.mean_length)


def test_distance_of_vertices_inside_out():
    """As an embedding of them, they are mirrored."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    inward = PolyhedralMetric.from_mesh(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert isoembed.embed(inward).distance(corners) < 1e-14


def test_distance_from_vertices_is_that_from_a_surface():
    one = embedding(*zoo.icosphere(1), 2.0)
    moved = one.vertices @ zoo.rotation(1).T + [5.0, 0, 0]
    moved[3] *= 1.01
    other = Embedding(one.metric, moved, method="given", tolerance=1.0)
    assert one.distance(moved) == one.distance(moved.tolist()) == one.distance(other) > 0
    with pytest.raises(ValueError, match=r"the vertices have shape \(5, 3\), not \(42, 3\)"):
        one.distance(moved[:5])


def test_gaussian_curvature_has_a_unit_and_is_that_of_a_sphere():
    small, large = (embedding(*zoo.icosphere(3), scale).gaussian_curvature for scale in (1.0, 7.0))
    assert small == pytest.approx(1, rel=0.01)
    assert large == pytest.approx(small / 49, rel=1e-12)
    given = PolyhedralMetric.from_mesh(*zoo.icosphere(1))
    assert isoembed.embed(given.scaled(7)).gaussian_curvature == pytest.approx(
        isoembed.embed(given).gaussian_curvature / 49, rel=1e-12
    )


def test_normals_are_of_flat_space():
    metric = PolyhedralMetric.from_mesh(*zoo.icosphere(1)).in_space(isoembed.Hyperbolic())
    with pytest.raises(isoembed.InvalidParameter, match="normals need surfaces in R"):
        isoembed.embed(metric).normals  # noqa: B018


def test_singular_values_are_computed_once(monkeypatch):
    computed = []
    values = LengthSystem.smallest_singular_values
    monkeypatch.setattr(
        LengthSystem, "smallest_singular_values", lambda *given: computed.append(1) or values(*given)
    )
    surface = isoembed.embed(zoo.random_hull(30, seed=1))
    computed.clear()
    once = isoembed.Sensitivity(surface).smallest_singular_value
    assert isoembed.report(surface)["smoothness"]["smallest_singular_value"] == once > 0
    assert isoembed.report(surface._with_message("known"))["smoothness"]["smallest_singular_value"] == once
    assert len(computed) == 1


@pytest.mark.parametrize(
    "function",
    [isoembed.certify, isoembed.report, isoembed.Sensitivity, lambda one: isoembed.compare(one, one)],
)
def test_what_is_no_embedding_is_refused(function):
    surface = isoembed.embed(zoo.random_hull(30, seed=1))
    for wrong, kind in (
        ("surface.ply", "str"),
        (surface.metric, "PolyhedralMetric"),
        (surface.surface, "Surface"),
    ):
        with pytest.raises(isoembed.InvalidParameter, match=f"the embedding is a {kind}: give a result"):
            function(wrong)


def test_many_other_realizations_are_summarized():
    x, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(x, faces)
    ball = Embedding(metric, x, method="known", tolerance=1e-10)
    dents = [
        x * np.where(np.arange(len(x)) == v, size, 1.0)[:, None] for v, size in enumerate((0.9, 0.8, 0.7))
    ]
    others = [Embedding(metric, each, method="known", tolerance=1e-10) for each in dents]
    said = ball._with_others(others).message
    near, far = (format(ball.distance(other), ".1g") for other in (others[0], others[-1]))
    assert said.count("realization") == 1
    assert f"these lengths have 3 other realizations too, {near} to {far} mean edge lengths from" in said
    assert said.endswith("this one: 1 rougher, 2 not convex")
