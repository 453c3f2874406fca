"""Dents found by lengths alone."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed import embed
from isoembed.gallery import CassiniPeanut, Ergosphere, HarmonicSurface, Sphere, triangulate
from isoembed.metric.curvature import deficits
from isoembed.metric.dents import dents
from isoembed.metric.polyhedral import PolyhedralMetric

TWO = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
"""Directions of two dimples."""


def angles(vertices, center):
    return np.arccos(vertices @ np.array(center) / np.linalg.norm(vertices, axis=1))


@pytest.mark.parametrize(("depth", "width"), [(0.3, 0.4), (0.4, 0.4), (0.3, 0.3)])
def test_the_rim_of_a_dimple_is_where_its_plane_touches(depth, width):
    vertices, faces = smooth_bodies.dimpled(1500, depth=depth, width=width)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    (patch,) = dents(metric)
    theta = np.linspace(0, 1.5, 10_000)
    heights = np.cos(theta) * (1 - depth * np.exp((np.cos(theta) - 1) / width**2))
    rim, edge = theta[np.argmax(heights)], metric.mean_length
    away = angles(vertices, (0, 0, 1))
    assert patch[away < rim - edge].all()
    assert not patch[away > rim + edge].any()
    assert abs(deficits(metric)[patch].sum()) < 0.2 * deficits(metric)[patch].clip(0).sum()


def test_dimples_whose_rings_have_grown_together_are_told_apart():
    close = (TWO[0], (0.0, np.sin(1.2), np.cos(1.2)))
    vertices, faces = smooth_bodies.dimpled(1500, close, depth=0.35, width=0.4)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    negative = deficits(metric) < 0
    between = angles(vertices, (0.0, np.sin(0.6), np.cos(0.6))) < 0.12
    assert negative[between].all()
    patches = dents(metric)
    assert len(patches) == 2
    assert not (patches[0] & patches[1]).any()
    for center in close:
        at_it = angles(vertices, center) < 0.3
        assert max(patch[at_it].mean() for patch in patches) == 1


def test_a_cap_that_is_nearly_flat_is_no_dent():
    vertices, faces = smooth_bodies.dimpled(600, depth=0.174, width=0.4)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    cap = angles(vertices, (0, 0, 1)) < 0.2
    assert 1e-3 < deficits(metric)[cap].clip(0).sum() < 3e-3
    assert dents(metric) == []
    assert smooth_bodies.misfit(embed(metric).vertices, vertices) < 1e-9


def horn_and_dimple(n):
    """A sphere with a dimple and a horn whose rings of K < 0 have grown together."""
    u, faces = triangulate(Sphere(), n)
    dimple = 0.22 * np.exp((u @ (0.0, 0.0, 1.0) - 1) / 0.3**2)
    horn = 0.45 * np.exp((u @ (0.0, np.sin(1.0), np.cos(1.0)) - 1) / 0.25**2)
    return u * (1 - dimple + horn)[:, None], faces


def test_a_horn_beside_a_dimple_is_no_part_of_it():
    vertices, faces = horn_and_dimple(600)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    (patch,) = dents(metric)
    away = angles(vertices, (0.0, 0.0, 1.0))
    assert patch[away < 0.25].all()
    assert not patch[away > 0.55].any()
    surface = embed(metric)
    assert smooth_bodies.misfit(surface.vertices, vertices) < 1e-9


@pytest.mark.parametrize(
    "surface", [CassiniPeanut(), Ergosphere(), HarmonicSurface(), HarmonicSurface(degree=2, order=2)]
)
def test_necks_saddles_and_bands_are_no_dents(surface):
    assert dents(PolyhedralMetric.from_mesh(*triangulate(surface, 400))) == []


def test_convex_bodies_have_no_dents():
    assert dents(PolyhedralMetric.from_mesh(*zoo.random_hull(60, 0))) == []


def test_names_and_units_do_not_matter():
    vertices, faces = smooth_bodies.dimpled(500, TWO)
    rng = np.random.default_rng(0)
    order = rng.permutation(len(vertices))
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    other = PolyhedralMetric.from_mesh(1e-100 * vertices[order], rng.permutation(np.argsort(order)[faces]))
    first = {frozenset(np.flatnonzero(patch)) for patch in dents(metric)}
    second = {frozenset(order[np.flatnonzero(patch)]) for patch in dents(other)}
    assert len(first) == 2
    assert first == second


def test_rough_bodies_have_no_dents():
    u, faces = triangulate(Sphere(), 400)
    rough = u * (1 + 0.05 * np.random.default_rng(0).standard_normal(len(u)))[:, None]
    metric = PolyhedralMetric.from_mesh(rough, faces)
    assert np.mean(deficits(metric) < 0) > 0.3
    assert dents(metric) == []
