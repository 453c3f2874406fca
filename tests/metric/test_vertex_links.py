"""Vertices whose angles no surface has: against Gram matrices, all odd subsets, and surfaces of any shape."""

import itertools

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import NotEmbedded, PolyhedralMetric
from isoembed.metric.inspection import inspect
from isoembed.metric.vertex_links import link_gaps, without_link

TETRAHEDRON = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]


def apex_gap(angles):
    """The gap at the tip of a pyramid whose lateral edges are 1."""
    n = len(angles)
    sides = 2 * np.sin(np.asarray(angles) / 2)
    faces = [[0, 1 + k, 1 + (k + 1) % n] for k in range(n)]
    edges = [[0, 1 + k] for k in range(n)] + [[1 + k, 1 + (k + 1) % n] for k in range(n)]
    return link_gaps(PolyhedralMetric(faces, [*[1.0] * n, *sides], edges))[0]


def test_three_angles_are_those_of_unit_vectors():
    rng, seen = np.random.default_rng(0), set()
    for _ in range(60):
        angles = rng.uniform(0.1, 3.0, 3)
        gram = np.ones((3, 3))
        for (i, j), angle in zip([(0, 1), (1, 2), (2, 0)], angles, strict=True):
            gram[i, j] = gram[j, i] = np.cos(angle)
        possible = np.linalg.det(gram) > 0
        assert (apex_gap(angles) <= 0) == possible
        seen.add(bool(possible))
    assert len(seen) == 2


@pytest.mark.parametrize("n", [4, 5])
def test_every_odd_subset(n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        angles = rng.choice([0.05, 0.4, 2.9], n)
        least = min(
            sum(np.pi - a if k in some else a for k, a in enumerate(angles))
            for odd in range(1, n + 1, 2)
            for some in map(set, itertools.combinations(range(n), odd))
        )
        assert apex_gap(angles) == pytest.approx(np.pi - least, abs=1e-9)


def test_surfaces_of_any_shape_have_links():
    vertices, faces = zoo.icosphere(1)
    for seed in range(20):
        x = vertices + np.random.default_rng(seed).normal(size=vertices.shape)
        assert (link_gaps(PolyhedralMetric.from_mesh(x, faces)) <= 0).all()


def test_what_is_impossible_is_said_and_proved():
    metric = PolyhedralMetric(TETRAHEDRON, [1.0, 1.0, 1.0, 1.0, 1.0, 1.9])
    with pytest.raises(NotEmbedded, match=r"on these triangles: at vertex \d, an angle is") as refused:
        isoembed.embed(metric)
    assert refused.value.evidence.kind == "proved"
    kinds = [warning.kind for warning in inspect(metric).warnings]
    assert "impossible_angles" in kinds and "degree_three" not in kinds
    assert "an angle is 143.61 degrees, more than the others together, 120" in without_link(metric, 0)


def test_three_angles_of_more_than_a_whole_turn():
    flat = PolyhedralMetric(TETRAHEDRON, [1.0, 1.0, 1.0, 1.8, 1.8, 1.8])
    assert "three angles sum to 384.9" in without_link(flat, int(np.argmax(link_gaps(flat))))
