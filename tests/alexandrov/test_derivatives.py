"""Derivatives of convex polyhedra by the lengths that were given: through flips, and with flat vertices."""

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import GluedMetric, PolyhedralMetric, embed
from isoembed.surface.measures import area
from scrambling import scramble
from sprinkled import box, sprinkled, tables_of


def distances(x):
    i, j = np.triu_indices(len(x), 1)
    return np.linalg.norm(x[i] - x[j], axis=1)


def distance_rates(x, v):
    i, j = np.triu_indices(len(x), 1)
    return np.einsum("ni,ni->n", x[i] - x[j], v[i] - v[j]) / distances(x)


def scrambled(vertices, faces, seed):
    """The metric of a surface on triangles that random flips made."""
    tables = tables_of(vertices, faces)
    scramble(tables, 300, np.random.default_rng(seed), thinnest=0.05)
    return GluedMetric.flipped(tables)


def with_changes(metric, changes):
    """The same triangles with other lengths: changes (n,) are those of the lower half-edges."""
    lengths, twins = np.array(metric.face_lengths).ravel(), np.asarray(metric.twins)
    lower = np.flatnonzero(np.arange(twins.size) < twins)
    lengths[lower] += changes
    lengths[twins[lower]] = lengths[lower]
    return metric.with_lengths(lengths.reshape(-1, 3))


def rates_of_lengths(metric, x, v):
    return np.einsum(
        "ei,ei->e", np.diff(x[metric.edges], axis=1)[:, 0], np.diff(v[metric.edges], axis=1)[:, 0]
    ) / (metric.lengths)


def flat_case(seed):
    """A body with vertices in its faces and on its edges, and velocities of all that keep them there."""
    corners, triangles = zoo.random_hull(14, seed)
    other = corners + np.random.default_rng(seed).normal(size=corners.shape)
    (x, faces, flat), (y, _, _) = (sprinkled(each, triangles, 12, seed) for each in (corners, other))
    return x, faces, flat, y - x


@pytest.mark.parametrize("unit", [1e-170, 1e170])
def test_units_in_which_squares_are_no_floats(unit):
    metric = scrambled(*zoo.random_hull(25, 0), 0)
    found, scaled = (embed(each, method="alexandrov") for each in (metric, metric.scaled(unit)))
    dl = np.random.default_rng(0).standard_normal(len(found.edge_paths.ends))
    rates = distance_rates(found.vertices, isoembed.Sensitivity(found).given_jvp(dl))
    assert distance_rates(
        scaled.vertices / unit, isoembed.Sensitivity(scaled).given_jvp(dl)
    ) == pytest.approx(rates, abs=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_through_flips_against_differences(seed):
    metric = scrambled(*zoo.random_hull(25, seed), seed)
    found, h = embed(metric, method="alexandrov"), 3e-7
    assert np.diff(found.edge_paths.offsets).max() > 1
    dl = np.random.default_rng(seed).standard_normal(len(found.edge_paths.ends))
    up, down = (
        distances(embed(with_changes(metric, s * h * dl), method="alexandrov").vertices) for s in (1, -1)
    )
    rates = distance_rates(found.vertices, isoembed.Sensitivity(found).given_jvp(dl))
    assert np.abs(rates - (up - down) / (2 * h)).max() < 1e-6 * np.abs(rates).max()


def test_on_its_own_triangles():
    found = embed(PolyhedralMetric.from_mesh(*zoo.random_hull(30, 3)), method="alexandrov")
    rng = np.random.default_rng(0)
    dl, g = rng.standard_normal(84), rng.standard_normal((30, 3))
    order = found.triangulation.edge_indices(found.edge_paths.ends)
    own = np.empty(84)
    own[order] = dl
    assert np.allclose(
        isoembed.Sensitivity(found).given_jvp(dl),
        isoembed.Sensitivity(found).jvp(own),
        rtol=0,
        atol=1e-10 * np.abs(isoembed.Sensitivity(found).jvp(own)).max(),
    )
    assert np.allclose(
        isoembed.Sensitivity(found).given_vjp(g),
        isoembed.Sensitivity(found).vjp(g)[order],
        rtol=0,
        atol=1e-10 * np.abs(isoembed.Sensitivity(found).vjp(g)).max(),
    )


@pytest.mark.parametrize("seed", range(3))
def test_flat_vertices_move_with_their_faces(seed):
    x, faces, flat, v = flat_case(seed)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, method="alexandrov")
    assert np.array_equal(np.sort(found.flat_vertices), np.flatnonzero(flat))
    rates = distance_rates(
        found.vertices, isoembed.Sensitivity(found).given_jvp(rates_of_lengths(metric, x, v))
    )
    expected = distance_rates(x, v)
    assert np.abs(rates - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(2))
def test_the_transpose(seed):
    x, faces, _, v = flat_case(seed)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found, dl = embed(metric, method="alexandrov"), rates_of_lengths(metric, x, v)
    g = np.random.default_rng(seed).standard_normal((2, *x.shape))
    forward, backward = (
        np.sum(isoembed.Sensitivity(found).given_jvp(dl) * g, axis=(1, 2)),
        isoembed.Sensitivity(found).given_vjp(g) @ dl,
    )
    assert np.allclose(forward, backward, rtol=1e-9)


def test_a_box_that_grows_keeps_its_faces():
    x, faces, _ = box(3)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, method="alexandrov")
    v = isoembed.Sensitivity(found).given_jvp(
        [rates_of_lengths(metric, x, x), rates_of_lengths(metric, x, x * [0.5, 1.0, 2.0])]
    )
    for velocity, expected in zip(v, (x, x * [0.5, 1.0, 2.0]), strict=True):
        assert np.allclose(distance_rates(found.vertices, velocity), distance_rates(x, expected), atol=1e-9)
    assert np.isclose(area(found.faces, found.vertices), 6)


def test_faces_that_break_to_first_order():
    # On both sides alike: which diagonal a square breaks along is seen in second order.
    metric = PolyhedralMetric.from_mesh(*zoo.cube())
    found, h = embed(metric, method="alexandrov"), 1e-5
    dl = np.random.default_rng(0).standard_normal(len(metric.lengths))
    rates = distance_rates(found.vertices, isoembed.Sensitivity(found).given_jvp(dl))
    for s in (1, -1):
        there = embed(metric.with_lengths(metric.lengths + s * h * dl), method="alexandrov")
        slope = s * (distances(there.vertices) - distances(found.vertices)) / h
        assert np.abs(rates - slope).max() < 1e-3 * np.abs(rates).max()


def test_a_flat_vertex_that_does_not_remain_flat():
    metric = PolyhedralMetric.from_mesh(*box(2)[:2])
    found = embed(metric, method="alexandrov")
    with pytest.raises(isoembed.InvalidParameter, match=r"vertex \d+, which is flat, a deficit at the rate"):
        isoembed.Sensitivity(found).given_jvp(np.arange(len(metric.lengths)) == 0)


def test_a_vertex_inside_a_face_that_breaks():
    x, faces, flat = box(2)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, method="alexandrov")
    said = r"vertex \d+ is inside a face with more than three corners, which may break"
    corner = int(np.argmin(flat))
    on_edges = np.abs(x - x[corner]).sum(axis=1) == 0.5
    v = np.where(np.arange(len(x)) == corner, 1.0, 0.5 * on_edges)[:, None] * (x[corner] - 0.5)
    with pytest.raises(isoembed.InvalidParameter, match=said):
        isoembed.Sensitivity(found).given_jvp(rates_of_lengths(metric, x, v))
    inside = ((x > 0) & (x < 1)).sum(axis=1) == 2
    far = int(np.argmax(np.linalg.norm(x - x[corner], axis=1)))
    g = np.zeros_like(x)  # of the diagonal, which grows with the lengths
    g[far] = found.vertices[far] - found.vertices[corner]
    g[corner] = -g[far]
    assert np.isclose(isoembed.Sensitivity(found).given_vjp(g) @ metric.lengths, 3)
    with pytest.raises(isoembed.InvalidParameter, match=said):
        isoembed.Sensitivity(found).given_vjp(inside[:, None] * found.vertices)


def test_a_doubly_covered_polygon_is_refused():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    found = embed(GluedMetric(*zoo.doubly_covered(square)), method="alexandrov")
    with pytest.raises(isoembed.InvalidParameter, match="a doubly covered polygon, which has no derivatives"):
        isoembed.Sensitivity(found).given_jvp(np.ones(len(found.edge_paths.ends)))


def test_curved_space_is_refused():
    x, faces = zoo.random_hull(10, 0)
    metric = PolyhedralMetric.from_mesh(0.2 * x, faces, curvature=-1.0)
    found = embed(metric, method="alexandrov")
    with pytest.raises(isoembed.InvalidParameter, match=r"polyhedra in R\^3, not in Hyperbolic\(1\.0\)"):
        isoembed.Sensitivity(found).given_jvp(np.ones(len(metric.lengths)))
