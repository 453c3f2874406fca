"""Glued metrics: any gluing of triangles to a sphere is kept as it is, anything else is refused by name."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.errors import InvalidMetric
from isoembed.metric import curvature
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from scrambling import scramble

FOLDED = [[0, 0, 1], [0, 0, 2]], [3, 2, 1, 0, 5, 4], [[1.0, 1.0, 1.0]] * 2
DOUBLED = [[0, 1, 2], [0, 2, 1]], [5, 4, 3, 2, 1, 0], [[3.0, 4.0, 5.0], [5.0, 4.0, 3.0]]


def scrambled(seed, n):
    """A random convex polyhedron under triangles that know nothing of its edges; and its metric."""
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(n, seed))
    tables = GluedMetric.of(metric).half_edges()
    scramble(tables, 30 * n, np.random.default_rng(seed))
    return GluedMetric(tables.faces, tables.twins, tables.face_lengths), metric


def loops(metric):
    return int((metric.faces == np.roll(metric.faces, -1, axis=1)).sum()) // 2


# What it keeps


def test_of_a_polyhedral_metric_says_the_same():
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(20, 1))
    glued = GluedMetric.of(metric)
    assert GluedMetric.of(glued) is glued
    assert (glued.n_vertices, glued.n_edges, glued.n_faces) == (20, 54, 36)
    assert glued.mean_length == pytest.approx(metric.mean_length, rel=1e-14)
    assert glued.unit == metric.unit
    assert np.array_equal(glued.deficits, curvature.deficits(metric))
    checked = GluedMetric(glued.faces, glued.twins, glued.face_lengths)
    for name in ("faces", "twins", "face_lengths"):
        assert np.array_equal(getattr(checked, name), getattr(glued, name))
        assert not getattr(checked, name).flags.writeable
        assert not getattr(glued, name).flags.writeable
    again = glued.simplicial()
    assert np.array_equal(again.faces, metric.faces)
    assert np.array_equal(again.lengths, metric.lengths)


def test_the_arrays_given_stay_the_users():
    faces, twins, lengths = (np.array(table) for table in FOLDED)
    metric = GluedMetric(faces, twins, lengths)
    faces[0, 0], twins[0], lengths[0, 0] = 7, 7, 7.0  # still writable
    for own, first in zip((metric.faces, metric.twins, metric.face_lengths), FOLDED, strict=True):
        assert np.array_equal(own, first)


def test_a_triangle_folded_shut():
    metric = GluedMetric(*FOLDED)
    assert repr(metric) == "GluedMetric(3 vertices, 3 edges, 2 faces, mean edge length 1)"
    assert metric.deficits == pytest.approx(np.pi * np.array([2 / 3, 5 / 3, 5 / 3]), rel=1e-14)
    assert metric.triangles.areas.sum() == pytest.approx(3**0.5 / 2, rel=1e-14)


def test_glued_sides_that_differ_by_rounding_become_equal():
    faces, twins, lengths = (np.array(table) for table in DOUBLED)
    lengths[0, 1] *= 1 + 4e-16
    metric = GluedMetric(faces, twins, lengths)
    assert np.array_equal(metric.face_lengths.ravel(), metric.face_lengths.ravel()[metric.twins])


@pytest.mark.parametrize("scale", [1e-150, 1.0, 1e12, 1e150])
def test_no_length_is_too_small_or_too_large(scale):
    faces, twins, lengths = DOUBLED
    metric = GluedMetric(faces, twins, scale * np.array(lengths))
    assert metric.deficits == pytest.approx(GluedMetric(*DOUBLED).deficits, rel=1e-13)
    assert metric.mean_length == pytest.approx(4 * scale, rel=1e-14)
    assert 1 <= metric.normalized.mean_length < 2
    assert metric.normalized.normalized is metric.normalized
    simplicial = metric.simplicial()
    assert sorted(simplicial.lengths / scale)[-1] == pytest.approx(5, rel=1e-14)


# As a simplicial complex


@pytest.mark.parametrize("tables", [FOLDED, DOUBLED], ids=["folded", "doubled"])
def test_simplicial_of_the_smallest(tables):
    metric = GluedMetric(*tables)
    simplicial = metric.simplicial()
    flat = np.zeros(simplicial.triangulation.n_vertices - 3)
    assert curvature.deficits(simplicial) == pytest.approx([*metric.deficits, *flat], abs=1e-13)
    assert curvature.area(simplicial) == pytest.approx(
        metric.triangles.areas.sum() * metric.triangles.unit**2, rel=1e-14
    )


@given(seed=st.integers(0, 10**6), n=st.integers(4, 9))
def test_simplicial_keeps_the_metric(seed, n):
    metric, polyhedron = scrambled(seed, n)
    simplicial = metric.simplicial()
    new = simplicial.triangulation.n_vertices - n
    # Angles of triangles of height 1e-3 are good to about 1e-10.
    assert curvature.deficits(simplicial) == pytest.approx([*metric.deficits, *np.zeros(new)], abs=1e-8)
    assert curvature.area(simplicial) == pytest.approx(curvature.area(polyhedron), rel=1e-9)


def test_scrambling_makes_what_no_simplicial_complex_has():
    assert sum(loops(scrambled(seed, 5)[0]) for seed in range(20)) > 0


@pytest.mark.parametrize("k", [-1.0, -1e-12, 0.7])
@pytest.mark.parametrize("tables", [FOLDED, DOUBLED], ids=["folded", "doubled"])
def test_simplicial_in_curved_spaces(tables, k):
    faces, twins, lengths = tables
    metric = GluedMetric(faces, twins, np.array(lengths) / 2, curvature=k)
    assert repr(metric).endswith(f", curvature {k:g})")
    size = metric.triangles.areas.sum() * metric.triangles.unit**2
    assert metric.deficits.sum() == pytest.approx(4 * np.pi - k * size, rel=1e-14)
    simplicial = metric.simplicial()
    assert simplicial.space == metric.space
    flat = np.zeros(simplicial.triangulation.n_vertices - 3)
    assert curvature.deficits(simplicial) == pytest.approx([*metric.deficits, *flat], abs=1e-13)
    assert curvature.area(simplicial) == pytest.approx(size, rel=1e-14)


def test_units_of_curved_metrics():
    faces, twins, lengths = DOUBLED
    metric = GluedMetric(faces, twins, lengths, curvature=-0.3)
    assert metric.scaled(2.0).curvature == pytest.approx(-0.075)
    assert metric.scaled(2.0).deficits == pytest.approx(metric.deficits, rel=1e-14)
    assert metric.normalized.curvature == -0.3 * metric.unit**2
    assert metric.with_lengths(metric.face_lengths).space == metric.space
    assert GluedMetric.flipped(metric.half_edges()).space == metric.space


# What it refuses


def broken(tables, **changes):
    arrays = dict(zip(("faces", "twins", "lengths"), (np.array(table) for table in tables), strict=True))
    for name, (index, value) in changes.items():
        arrays[name].flat[index] = value
    return tuple(arrays.values())


TORUS = [[0, 0, 0], [0, 0, 0]], [4, 5, 3, 2, 0, 1], np.ones((2, 3))
TWICE = [*DOUBLED[0], [3, 4, 5], [3, 5, 4]], [*DOUBLED[1], 11, 10, 9, 8, 7, 6], DOUBLED[2] * 2
TOUCHING = [*DOUBLED[0], [0, 3, 4], [0, 4, 3]], TWICE[1], TWICE[2]


def test_sides_that_are_too_long_for_the_sphere():
    sentence = "side 0 of face 0 has length 3.0, not below 2.22144147, half of a great circle"
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        GluedMetric(*DOUBLED, curvature=2.0)


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        (broken(FOLDED, twins=(1, 1)), "side 1 of face 0 is glued to itself"),
        (
            broken(FOLDED, twins=(4, 3)),
            "side 1 of face 1 is glued to side 0 of face 1, but that is glued to side 0 of face 0",
        ),
        (broken(FOLDED, twins=(2, 9)), "side 2 of face 0 is glued to half-edge 9, but there are only 6"),
        (broken(FOLDED, twins=(2, -1)), "side 2 of face 0 is glued to half-edge -1"),
        (broken(FOLDED, lengths=(4, 0.0)), "side 1 of face 1 has length 0.0, not a positive finite number"),
        (broken(FOLDED, lengths=(4, np.nan)), "side 1 of face 1 has length nan"),
        (broken(FOLDED, lengths=(4, np.inf)), "side 1 of face 1 has length inf"),
        (
            broken(FOLDED, lengths=(1, 1.0 + 1e-11)),
            "side 1 of face 0 has length 1.00000000001, but side 2 of face 0, which is glued to it, has 1.0",
        ),
        (
            broken(FOLDED, lengths=(0, 2.0)),
            "face 0 [0, 0, 1] breaks the triangle inequality: its sides are 1.0, 1.0 and 2.0",
        ),
        (
            broken(DOUBLED, faces=(4, 1)),
            "side 1 of face 0 runs from vertex 1 to 2 and is glued to side 1 of face 1, "
            "which runs from 1 to 1, not back",
        ),
        (
            broken(DOUBLED, faces=(0, 7)),
            "vertex 3 is in no face, while face 0 refers to vertex 7",
        ),
        (TORUS, "the surface has Euler characteristic 0 (genus 1), not 2"),
        (TWICE, "the surface has several components: face 2 is not connected to face 0"),
        (TOUCHING, "the surface has several components: face 2"),
        ((FOLDED[0], FOLDED[1][:5], FOLDED[2]), "the twins have shape (5,), not (6,)"),
        ((FOLDED[0], FOLDED[1], FOLDED[2][:1]), "the lengths have shape (1, 3), not (2, 3)"),
        ((FOLDED[0], FOLDED[1], [[1.0], [1.0, 1.0]]), "the lengths are not a table of shape (2, 3)"),
        ((FOLDED[0], [0.5] * 6, FOLDED[2]), "the twins have the type float64, not whole numbers"),
        ((FOLDED[0], FOLDED[1], [["a"] * 3] * 2), "the lengths have the type <U1, not numbers"),
        (([[0, 1]], FOLDED[1], FOLDED[2]), "face 0 has 2 corners"),
    ],
)
def test_refusals_name_the_first_offender(tables, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        GluedMetric(*tables)


def test_a_vertex_of_two_fans_is_refused():
    # The octahedron with two opposite corners called by one name.
    metric = PolyhedralMetric.from_mesh(*zoo.octahedron())
    faces = metric.faces.copy()
    low, high = 0, int(np.setdiff1d(np.arange(1, 6), metric.edges[metric.edges[:, 0] == 0])[0])
    faces[faces == high] = low
    faces[faces > high] -= 1
    sentence = f"the faces around vertex {low} form more than one fan"
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        GluedMetric(faces, metric.triangulation.twins, metric.face_lengths)
