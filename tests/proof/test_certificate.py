"""Certificates of surfaces of any shape: of known ones, and of what must have none."""

import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import curved
import isoembed
import zoo
from isoembed import Embedding, PolyhedralMetric, Space, embed
from isoembed.gallery import CassiniPeanut, Ergosphere, HarmonicSurface, triangulate
from isoembed.proof import nearby_realization
from isoembed.proof.certificate import certify
from isoembed.surface.rigidity import LengthSystem, length_residuals

BENT = {
    "ergosphere": Ergosphere(0.05),
    "peanut": CassiniPeanut(),
    "saddle": HarmonicSurface(degree=2, order=2, amplitude=0.35),
    "trefoil": HarmonicSurface(degree=3, order=3, amplitude=0.3),
}


def dented(depth=0.3):
    """An octahedron whose top is pushed in below its equator."""
    vertices, faces = zoo.octahedron()
    vertices[int(np.argmax(vertices[:, 2])), 2] = -depth
    return vertices, faces


def apart(vertices, others, weights):
    """The largest distance of a vertex after the rigid motion that is best in weighted least squares."""
    w = weights[:, None] ** 2
    x, y = (p - (w * p).sum(axis=0) / w.sum() for p in (vertices, others))
    left, _, right = np.linalg.svd((w * x).T @ y)
    proper = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    return np.linalg.norm(x @ left @ proper @ right - y, axis=1).max()


@pytest.mark.parametrize("name", BENT)
def test_surfaces_with_negative_curvature(name):
    vertices, faces = triangulate(BENT[name], 150)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    found = certify(metric, vertices)
    assert found.certified and found.embedded
    assert found.radius < 1e-12
    assert found.isolation > 1e8 * found.radius
    for v in range(0, len(vertices), 40):
        moved = vertices.copy()
        moved[v] += 1e-6 * metric.mean_length * np.array([0.6, 0.48, 0.64])
        assert not certify(metric, moved).certified


@given(st.integers(0, 10**6), st.sampled_from([1e-15, 1e-12, 1e-10]))
def test_the_exact_vertices_are_within_the_radius(seed, noise):
    exact, faces = dented()
    metric = PolyhedralMetric.from_mesh(exact, faces)
    moved = exact + noise * np.random.default_rng(seed).normal(size=exact.shape)
    found = certify(metric, moved, np.spacing(metric.lengths))
    assert found.certified
    off = apart(moved, exact, np.ones(len(exact))) / metric.mean_length
    assert off <= 2 * found.radius + 1e-15
    assert found.radius < 20 * off + 1e-14


@pytest.mark.parametrize("height", [0.02, 0.1, 0.3])
def test_no_other_realization_is_nearer_than_the_isolation(height):
    """The tops of a flat pyramid, up and down, have the same lengths."""
    vertices, faces = zoo.octahedron()
    top = int(np.argmax(vertices[:, 2]))
    vertices[top, 2] = height
    below = vertices.copy()
    below[top, 2] = -height
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    weights = np.sqrt(np.bincount(metric.edges.ravel(), np.repeat(metric.lengths**-2, 2)))
    off = apart(below, vertices, weights) / metric.mean_length
    for x in (vertices, below):
        found = certify(metric, x)
        assert found.certified
        assert 0.02 * off < found.isolation < off


def test_a_surface_that_crosses_itself_is_certified_and_said_to_cross():
    vertices, faces = zoo.octahedron()
    vertices[int(np.argmax(vertices[:, 2]))] = [1.4, 0.25, -0.7]
    found = certify(PolyhedralMetric.from_mesh(vertices, faces), vertices)
    assert found.certified
    assert found.embedded is False
    assert re.search(r"; faces \[\d+, \d+\] may cross$", found.reason)


def test_a_surface_that_flexes_has_no_certificate():
    vertices, faces = zoo.octahedron()
    middle = len(vertices)
    vertices = np.vstack([vertices, vertices[faces[0]].mean(axis=0)])
    a, b, c = faces[0]
    faces = np.vstack([faces[1:], [[a, b, middle], [b, c, middle], [c, a, middle]]])
    reason = certify(PolyhedralMetric.from_mesh(vertices, faces), vertices).reason
    assert reason.startswith("not certified, because the lengths may not fix the vertices (the matrix ")
    assert f"vertex {middle} is the flattest" in reason


@pytest.mark.parametrize("k", [-1.0, 0.3])
def test_hyperbolic_and_spherical_space(k):
    x, faces, _ = curved.body(60, 3, k, 1.0)
    space, ends = Space(k), PolyhedralMetric.from_mesh(x, faces).edges
    top = int(np.argmax(x[:, 2]))
    x[top] *= 0.6  # a dent
    lengths = space.distances(x[ends[:, 0]], x[ends[:, 1]])
    metric = PolyhedralMetric(faces, lengths, ends, curvature=k)
    found = certify(metric, x)
    assert found.certified and found.embedded
    assert found.radius < 1e-12
    assert found.isolation > 1e4 * found.radius
    x[0, 0] += 1e-6 * metric.mean_length
    assert not certify(metric, x).certified


@pytest.mark.parametrize("scale", [1e-150, 1e150])
def test_the_unit_does_not_matter(scale):
    vertices, faces = dented()
    expected = certify(PolyhedralMetric.from_mesh(vertices, faces), vertices)
    found = certify(PolyhedralMetric.from_mesh(scale * vertices, faces), scale * vertices)
    assert found.certified
    assert found.isolation == pytest.approx(expected.isolation, rel=1e-6)
    assert found.sigma_min == pytest.approx(expected.sigma_min, rel=1e-6)


def tetrahelix(n):
    """Regular tetrahedra in a row (Boerdijk and Coxeter): vertices on a helix, edges of length 1, faces."""
    turn, k = np.arccos(-2 / 3), np.arange(n)
    radius, rise = 3 * np.sqrt(3) / 10, 1 / np.sqrt(10)
    vertices = np.column_stack([radius * np.cos(turn * k), radius * np.sin(turn * k), rise * k])
    sides = {}
    for i in range(n - 3):
        for left_out in range(4):
            face = tuple(i + j for j in range(4) if j != left_out)
            sides[face] = None if face in sides else i + left_out  # shared ones are inside
    faces = []
    for (a, b, c), d in sides.items():
        if d is not None:
            outward = np.linalg.det(vertices[[b, c, d]] - vertices[a]) < 0
            faces.append((a, b, c) if outward else (a, c, b))
    return vertices, np.array(faces)


@pytest.mark.parametrize("n", [8, 10, 20])
def test_equilateral_triangles_that_are_not_convex(n):
    vertices, faces = tetrahelix(n)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    assert metric.lengths == pytest.approx(1)
    found = certify(metric.with_lengths(np.ones(3 * n - 6)), vertices)
    assert found.certified and found.embedded
    assert found.radius < 1e-14 and found.isolation > 1e-4
    surface = embed(metric)
    assert isoembed.certify(surface).certified


def test_too_many_vertices(monkeypatch):
    monkeypatch.setattr(nearby_realization, "MAX_VERTICES", 5)
    vertices, faces = dented()
    found = certify(PolyhedralMetric.from_mesh(vertices, faces), vertices)
    assert found.reason == "not certified, because there are more than 5 vertices"


def test_too_little_memory(monkeypatch):
    def refused(*_):
        raise MemoryError

    monkeypatch.setattr(nearby_realization, "prove_row_rank", refused)
    vertices, faces = dented()
    found = certify(PolyhedralMetric.from_mesh(vertices, faces), vertices)
    assert found.reason == "not certified, because there is not enough memory for the factors of J J^T"


def embedding(vertices, faces, lengths_of):
    metric = PolyhedralMetric.from_mesh(lengths_of, faces)
    return Embedding(metric, vertices, method="test", tolerance=1e-10)


def test_an_embedding_has_its_certificate_in_the_report():
    vertices, faces = dented()
    surface = embedding(vertices, faces, vertices)
    assert isoembed.certify(surface).certified
    found = isoembed.report(surface)["certificate"]
    assert json.loads(json.dumps(found, allow_nan=False)) == found == isoembed.certify(surface).as_json()
    assert isoembed.certify(surface._in_unit_of(surface.metric.scaled(3.0))) is isoembed.certify(surface)
    missed = isoembed.report(embedding(vertices, faces, dented(0.2)[0]))["certificate"]
    assert missed["reason"] == "not certified, because the lengths miss the tolerance"
    assert missed["certified"] is False and missed["radius"] is None
    assert found["evidence"] == "proved" and "evidence" not in missed


def test_a_step_of_newtons_method_makes_a_certificate_of_an_approximation():
    vertices, faces = triangulate(CassiniPeanut(), 200)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    near = vertices + 1e-7 * metric.mean_length * np.random.default_rng(0).normal(size=vertices.shape)
    assert not certify(metric, near).certified
    residuals = length_residuals(metric.triangulation, near, metric.lengths)
    system = LengthSystem(metric.triangulation)
    near = near - system.step(near, metric.lengths, residuals)
    assert certify(metric, near).certified
