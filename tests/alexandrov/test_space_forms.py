"""Polyhedra of hyperbolic and spherical space, from metrics to vertices that are put back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import zoo
from curved import apart, body, metric_in, tables_in
from isoembed import GluedMetric, InvalidMetric, NotEmbedded, PolyhedralMetric, embed
from isoembed.alexandrov import method
from isoembed.space import Space
from scrambling import scramble

CURVATURES = [-1.0, -1e-9, 1e-9, 1.0]


@settings(max_examples=15)
@given(
    st.integers(4, 30), st.integers(0, 10**6), st.sampled_from([0.01, 1.0, 2.5]), st.sampled_from(CURVATURES)
)
def test_hulls_from_scrambled_triangles(n, seed, size, k):
    x, faces, _ = body(n, seed, k, size)
    tables = tables_in(x, faces, k)
    scramble(tables, 10 * n, np.random.default_rng(seed))
    metric = GluedMetric(tables.faces, tables.twins, tables.face_lengths, curvature=k)
    found = embed(metric, method="alexandrov")
    assert apart(x, found.vertices, k) < 1e-9
    assert found.residual < 1e-10
    assert not found.surface.concave_edges.any()
    assert {frozenset(f) for f in found.faces.tolist()} == {frozenset(f) for f in faces.tolist()}


@pytest.mark.parametrize("k", [-1.0, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_flat_vertices_are_put_back_and_given_edges_measured(k, seed):
    x, faces, flat = body(20, seed, k, 2.0, flat=15)
    found = embed(metric_in(x, faces, k), method="alexandrov")
    assert found.flat_vertices.tolist() == np.flatnonzero(flat).tolist()
    assert apart(x, found.vertices, k) < 1e-11
    assert found.path_residuals.max() < 1e-12
    assert not found.surface.concave_edges.any()


@pytest.mark.parametrize("factor", [1e-150, 1e-3, 1e12])
def test_the_unit_of_length_does_not_matter(factor):
    x, faces, _ = body(20, 1, -1.0, 2.0)
    metric = metric_in(x, faces, -1.0)
    found = embed(metric.scaled(factor), method="alexandrov")
    assert found.space.radius == pytest.approx(factor)
    assert apart(x, found.vertices / factor, -1.0) < 1e-12


def test_the_limit_of_small_curvature_is_linear():
    vertices, faces = zoo.random_hull(40, 3)
    flat = PolyhedralMetric.from_mesh(vertices, faces)
    i, j = np.triu_indices(40, 1)

    def rate(k):
        x = embed(PolyhedralMetric(faces, flat.lengths, curvature=k), method="alexandrov").vertices
        return (Space(k).distances(x[i], x[j]) - Space().distances(vertices[i], vertices[j])) / k

    small = rate(1e-5)
    scale = np.abs(small).max()
    assert scale > 0.01
    # The next term of the expansion is as much smaller as the curvature.
    assert np.abs(rate(1e-3) - small).max() < 2e-3 * scale
    assert np.abs(rate(-1e-3) - small).max() < 2e-3 * scale
    assert np.abs(rate(-1e-5) - small).max() < 2e-5 * scale


def test_the_whole_sphere_is_no_polyhedron():
    octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    metric = PolyhedralMetric(octahedron, np.full(12, np.pi / 2), curvature=1.0)
    with pytest.raises(InvalidMetric, match=r"only 0 vertices have deficits above .* has at least 3$"):
        embed(metric, method="alexandrov")


def test_on_the_sphere_a_body_may_be_wider_than_a_quarter_of_a_great_circle():
    x, faces, _ = body(30, 2, 1.0, 3.0)
    found = embed(metric_in(x, faces, 1.0), method="alexandrov")
    i, j = np.triu_indices(len(x), 1)
    assert found.space.distances(found.vertices[i], found.vertices[j]).max() > 2.5
    assert apart(x, found.vertices, 1.0) < 1e-10


def test_a_metric_is_convex_in_one_space_and_not_in_another():
    # Equal lengths: the angles of hyperbolic triangles are smaller, those of spherical ones larger.
    vertices, faces = zoo.icosahedron()
    metric = PolyhedralMetric.from_mesh(vertices / np.linalg.norm(vertices[0]), faces)
    assert embed(PolyhedralMetric(faces, metric.lengths, curvature=-1.0), method="alexandrov").converged
    with pytest.raises(InvalidMetric, match="deficit"):
        embed(PolyhedralMetric(faces, metric.lengths, curvature=1.2), method="alexandrov")


@pytest.mark.parametrize("size", [8.0, 12.0, 20.0])
def test_bodies_of_hyperbolic_space_that_are_many_radii_of_curvature_wide(size):
    x, faces, _ = body(20, 1, -1.0, size)
    found = embed(metric_in(x, faces, -1.0), method="alexandrov")
    assert apart(x, found.vertices, -1.0) < 1e-11


def test_newton_on_the_lengths_takes_over_where_the_path_ends(monkeypatch):
    whole = method.follow_path
    monkeypatch.setattr(method, "follow_path", lambda *some: list(whole(*some))[:1])
    x, faces, _ = body(20, 1, 1.0, 2.9)
    assert apart(x, embed(metric_in(x, faces, 1.0), method="alexandrov").vertices, 1.0) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("k", [-1.0, 1.0])
@pytest.mark.parametrize("steps", [0, 1])
def test_an_attempt_is_in_the_space_of_the_metric(monkeypatch, k, steps):
    whole = method.follow_path
    monkeypatch.setattr(method, "follow_path", lambda *some: list(whole(*some))[:steps])
    monkeypatch.setattr(method, "relaxed_polytope", lambda *_: None)
    x, faces, _ = body(20, 1, k, 2.9, flat=5)
    with pytest.raises(NotEmbedded) as failure:
        embed(metric_in(x, faces, k), method="alexandrov")
    attempt = failure.value.embedding
    assert attempt.space.curvature == k
    assert np.isfinite(attempt.residuals).all()
    assert isoembed.report(attempt)["status"] == "not converged"
