"""Flexible surfaces: a family of them, one that flexes to first order only, and rigid ones."""

import numpy as np
import pytest

import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.certificate import certify
from isoembed.proof.flexibility import described_flex
from isoembed.space import EUCLIDEAN
from isoembed.surface.projected import Projected

OCTAHEDRON = [(0, 1, 2), (0, 2, 4), (0, 4, 5), (0, 5, 1), (3, 2, 1), (3, 4, 2), (3, 5, 4), (3, 1, 5)]


def described(x, faces):
    metric = PolyhedralMetric.from_mesh(x, faces)
    return described_flex(Triangulation(faces), Projected.of(EUCLIDEAN, x), metric.lengths)


@pytest.mark.parametrize("seed", range(4))
def test_bricards_octahedra_are_flexible(seed):
    half = np.random.default_rng(seed).standard_normal((3, 3))
    x = np.vstack([half, half * [-1, -1, 1]])  # symmetric about an axis: Bricard's first type
    assert "a motion was followed until a vertex had moved by" in described(x, OCTAHEDRON)
    assert "the surface is flexible" in certify(PolyhedralMetric.from_mesh(x, OCTAHEDRON), x).reason
    x[0, 0] += 1e-3
    assert described(x, OCTAHEDRON) is None


def test_an_octahedron_twisted_by_30_degrees_flexes_to_first_order_only():
    below = 2 * np.pi * np.arange(3) / 3
    above = below + np.pi / 6
    x = np.array([(np.cos(a), np.sin(a), 0) for a in below] + [(np.cos(a), np.sin(a), 1.2) for a in above])
    sides = [face for i, j in ((0, 1), (1, 2), (2, 0)) for face in ((i, j, 3 + j), (i, 3 + j, 3 + i))]
    assert "could not be followed" in described(x, [(0, 2, 1), (3, 4, 5), *sides])


def test_convex_surfaces_do_not_flex():
    assert described(*zoo.random_hull(30, 2)) is None


def test_large_surfaces_are_not_decomposed():
    assert described(*zoo.icosphere(3)) is None
