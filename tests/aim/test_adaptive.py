"""The default method: coordinates come back from lengths; invariances, costs, refusals and diagnoses."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import rocks
import smooth_bodies
import zoo
from isoembed.aim.adaptive import Aim
from isoembed.aim.choice import smoothest
from isoembed.aim.convexification import Convexification
from isoembed.aim.problem import Problem
from isoembed.errors import NotEmbedded
from isoembed.gallery import (
    Bean,
    BentTube,
    CassiniPeanut,
    Ellipsoid,
    Ergosphere,
    HarmonicSurface,
    KerrHorizon,
    Sphere,
    triangulate,
)
from isoembed.linalg import Work
from isoembed.metric.polyhedral import PolyhedralMetric
from sprinkled import box


def recovered(vertices, faces, **parameters):
    """The embedding of a surface's lengths, and how far from the surface it is."""
    surface = isoembed.embed(PolyhedralMetric.from_mesh(vertices, faces), method=Aim(**parameters))
    return surface, smooth_bodies.misfit(surface.vertices, vertices)


@pytest.mark.parametrize(
    ("mesh", "factorizations"),
    [
        (smooth_bodies.ellipsoid, 8),  # two deficits are negative
        (partial(smooth_bodies.ellipsoid, 800), 3),
        (smooth_bodies.drum, 8),
        (partial(triangulate, Ellipsoid((5, 2, 1)), 400), 30),
        (partial(triangulate, Ellipsoid((1, 1, 4)), 300), 31),  # Newton on the lengths arrives, at a neighbor
        (partial(triangulate, KerrHorizon(), 300), 3),
    ],
    ids=["ellipsoid", "ellipsoid 800", "drum", "(5, 2, 1)", "(1, 1, 4)", "Kerr"],
)
def test_convex_bodies_come_back_from_their_lengths(mesh, factorizations):
    surface, error = recovered(*mesh())
    assert surface.residual < 1e-13  # the polish goes to the rounding floor, whatever the tolerance
    assert error < 1e-12
    assert not surface.surface.inverted_vertices.any()
    assert not surface.others
    assert sum(stage.factorizations for stage in surface.stages) <= factorizations
    if factorizations < 30:
        assert surface.stages[-1].name == "radii"


NON_CONVEX = {
    "peanut": (CassiniPeanut(), 600),
    "ergosphere": (Ergosphere(epsilon=0.1), 800),
    "saddle": (HarmonicSurface(2, 2, 0.35), 1000),  # on fewer vertices, some neighbors are as smooth
    "trefoil": (HarmonicSurface(3, 3, 0.3), 1000),
    "bean": (Bean(), 400),
    "tube": (BentTube(), 400),
}


@pytest.mark.slow
@pytest.mark.parametrize(("surface", "n"), NON_CONVEX.values(), ids=NON_CONVEX)
@pytest.mark.parametrize("irregular", [None, 1], ids=["regular", "irregular"])
def test_smooth_bodies_with_negative_curvature_come_back_too(surface, n, irregular):
    embedding, error = recovered(*triangulate(surface, n, irregular=irregular))
    assert embedding.residual < 1e-12
    assert error < 1e-6
    assert sum(stage.factorizations for stage in embedding.stages) <= 40
    for other in embedding.others:
        assert other.converged
        assert other.surface.fine_roughness > embedding.surface.fine_roughness
        assert embedding.distance(other) > 1e-7


@pytest.mark.parametrize(
    "mesh",
    [zoo.tetrahedron(), zoo.octahedron(), zoo.cube(), zoo.icosahedron(), zoo.icosphere(2)],
    ids=["tetrahedron", "octahedron", "cube", "icosahedron", "icosphere"],
)
def test_bodies_inscribed_in_a_sphere(mesh):
    surface, error = recovered(*mesh)
    assert error < 1e-9
    assert surface.volume == pytest.approx(
        isoembed.Embedding(surface.metric, mesh[0], method="", tolerance=1).volume
    )


@pytest.mark.parametrize("n", [4, 5, 6, 8, 12, 20, 30, 50])
@pytest.mark.parametrize("seed", range(3))
def test_convex_hulls_of_random_points(n, seed):
    surface, error = recovered(*zoo.random_hull(n, 100 * n + seed))
    assert error < 1e-7
    assert not surface.surface.concave_edges.any()


@pytest.mark.parametrize(("height", "seed"), [(1e-3, 30), (1e-4, 2), (1e-4, 10), (1e-5, 6)])
def test_of_shallow_caps_no_vertex_is_pushed_in(height, seed):
    vertices, faces = zoo.shallow_cap(10 + seed, height, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = isoembed.embed(metric)
    assert not surface.surface.concave_edges.any()
    polyhedron = isoembed.embed(metric, method="alexandrov")
    for known in (vertices, polyhedron.vertices):
        assert smooth_bodies.misfit(surface.vertices, known) < 1e-8
    assert sorted(map(sorted, polyhedron.faces)) == sorted(map(sorted, faces))


def test_of_a_convex_metric_the_convex_realization_goes_before_a_smoother_one():
    ring = np.array([[np.cos(t), np.sin(t), 0] for t in np.arange(5) * 2 * np.pi / 5])
    vertices = np.vstack([ring, [[0, 0, 0.3], [0, 0, -0.8]]])
    faces = [[i, (i + 1) % 5, 5] for i in range(5)] + [[(i + 1) % 5, i, 6] for i in range(5)]
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    problem = Problem(metric, 1e-10, "aim", Work())
    tip_in = vertices * np.where(np.arange(7) == 5, -1, 1)[:, None]  # it has the same lengths
    found = smoothest([problem.surface(tip_in), problem.surface(vertices)], problem.is_convex, False)
    assert not found.surface.concave_edges.any()
    (other,) = found.others
    assert other.surface.concave_edges.sum() == 5
    assert "from this one and not convex" in found.message


@settings(max_examples=6)
@given(
    st.integers(0, 10**6),
    st.floats(-150, 12).map(lambda e: 10.0**e),
    st.booleans(),
    st.booleans(),
)
def test_unit_numbering_mirror_and_orientation_do_not_matter(seed, scale, mirrored, reversed_):
    vertices, faces = smooth_bodies.ellipsoid(100)
    moved, others, _ = zoo.relabeled(vertices, faces, seed)
    if mirrored:
        moved = moved * [1, 1, -1]
    if reversed_:
        others = others[:, ::-1]
    surface = isoembed.embed(PolyhedralMetric.from_mesh(scale * moved, others))
    assert smooth_bodies.misfit(surface.vertices / scale, moved) < 1e-9
    # Outward by the given triangles: the volume is positive whichever way round they are.
    x = surface.vertices / scale
    a, b, c = (x[others[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0


def test_extreme_units_change_not_one_digit():
    vertices, faces = smooth_bodies.ellipsoid(100)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    plain = isoembed.embed(metric)
    for scale in (1e-300, 1e12, 1e300):
        power = 2.0 ** np.round(np.log2(scale))
        scaled = isoembed.embed(metric.with_lengths(power * metric.lengths))
        assert (scaled.vertices / power == plain.vertices).all()
        assert scaled.residual == plain.residual


def test_a_start_that_is_exact_is_left_alone():
    # Vertices inside flat faces are put back where they are: no step on the edges can better it.
    surface, error = recovered(*box(3)[:2])
    assert {stage.name: stage.factorizations for stage in surface.stages}["pull back"] == 0
    assert error < 1e-11


def test_flat_vertices_keep_their_digits():
    # Where faces are flat, lengths alone fix heights to the square root of rounding only.
    vertices, faces, flat = box(3)
    assert flat.any()
    surface, error = recovered(vertices, faces)
    assert surface.residual < 1e-12
    assert error < 1e-11


def test_another_realization_is_reported():
    surface, error = recovered(*triangulate(Bean(), 400))
    assert error < 1e-9
    (other,) = surface.others
    assert other.converged
    assert other.surface.fine_roughness > surface.surface.fine_roughness
    assert surface.distance(other) > 1e-5
    assert "these lengths have another realization too" in surface.message
    assert surface.message.endswith(
        "mean edge lengths only; isoembed.realizations(embedding) searches further"
    )
    assert isoembed.report(surface)["other_realizations"] == [
        {
            "distance": surface.distance(other),
            "roughness": other.surface.roughness,
            "fine_roughness": other.surface.fine_roughness,
            "mirrored": 0,
        }
    ]
    assert isoembed.report(surface)["uniqueness"]["evidence"] == "searched"
    assert surface.uniqueness.basis in surface.message


def noisy(amount):
    metric = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid(100))
    return metric.with_lengths(
        metric.lengths * (1 + amount * np.random.default_rng(0).normal(size=len(metric.lengths)))
    )


def test_small_noise_is_embedded():
    surface = isoembed.embed(noisy(1e-4))
    assert surface.residual < 1e-12
    assert smooth_bodies.misfit(surface.vertices, smooth_bodies.ellipsoid(100)[0]) < 1e-2


def test_an_attempt_in_fair_shape_is_left_where_noise_leaves_no_surface():
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(noisy(0.05))
    attempt = caught.value.embedding
    assert 1e-3 < attempt.residual < 0.5
    assert not attempt.converged
    last = [stage.name for stage in attempt.stages][-4:]
    assert last == ["guided pull back", "polish", "local search", "best fit"]


def test_lengths_of_no_surface():
    vertices, faces = triangulate(Sphere(), 60)
    center = vertices[faces[0]].mean(axis=0)  # of least mean square distance from the corners
    apex = len(vertices)
    turned = np.column_stack([faces[0], np.roll(faces[0], -1), np.full(3, apex)])
    metric = PolyhedralMetric.from_mesh(np.vstack([vertices, center]), np.vstack([faces[1:], turned]))
    spokes = (metric.edges == apex).any(axis=1)
    with pytest.raises(NotEmbedded):
        isoembed.embed(metric.with_lengths(np.where(spokes, 0.97, 1.0) * metric.lengths))


def test_a_loose_tolerance_does_not_make_the_answer_worse():
    vertices, faces = triangulate(CassiniPeanut(), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = isoembed.embed(metric, tolerance=0.5)  # which the convex metric's polyhedron meets
    assert smooth_bodies.misfit(surface.vertices, vertices) < 1e-9
    assert all(other.residual < 1e-9 for other in surface.others)


def test_without_a_convex_metric_it_begins_on_the_sphere(monkeypatch):
    monkeypatch.setattr(Convexification, "metric", lambda *_: None)
    surface, error = recovered(*triangulate(CassiniPeanut(), 300))
    assert "sphere" in [stage.name for stage in surface.stages]
    assert error < 1e-9


def test_flat_faces_are_found_between_unaligned_vertices():
    """A cylinder with edges across its rims: Newton steps ended at 4e-10, where J is singular."""
    directions, faces = rocks.rock(0, rough=0.0, n=800)
    u = directions / [150.0, 120.0, 100.0]
    vertices = u / np.maximum(np.hypot(u[:, 0], u[:, 1]), np.abs(u[:, 2]) / 0.7)[:, None]
    surface, misfit = recovered(vertices, faces)
    assert surface.residual < 1e-11
    assert misfit < 1e-5
