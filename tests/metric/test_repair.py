"""Repair of deficits within the noise: what it must leave, and that less would not do."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import isoembed.metric.repair as repair_module
from curved import body
from isoembed import PolyhedralMetric
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.curvature import deficits
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.repair import repaired
from scrambling import scramble
from zoo import icosphere, octahedron, random_hull


def grid_cube(n):
    """The surface of a cube, each side n x n squares cut along a diagonal; nearly all vertices are flat."""
    points = np.array([p for p in itertools.product(range(n + 1), repeat=3) if min(p) == 0 or max(p) == n])
    number = {tuple(p): k for k, p in enumerate(points.tolist())}
    faces = []
    for axis, side, a, b in itertools.product(range(3), (0, n), range(n), range(n)):
        corners = [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)]
        square = [number[(*c[:axis], side, *c[axis:])] for c in corners]
        if (side == 0) == (axis != 1):
            square.reverse()
        faces += [square[:3], [square[0], *square[2:]]]
    return PolyhedralMetric.from_mesh(points, faces)


def noisy(metric, size, seed=0):
    errors = np.random.default_rng(seed).standard_normal(metric.lengths.size)
    return metric.with_lengths(metric.lengths * (1 + size * errors))


def rounding(metric):
    return deficit_rounding(metric)


def is_convex(metric):
    return (deficits(metric) >= -rounding(metric)).all() and rounding(metric).max() < 1e-11


def pressed(metric, vertex, total):
    """Lengths at one vertex scaled until its deficit is as told, by bisection."""
    touching = (metric.edges == vertex).any(axis=1)
    low, high = 0.5, 1.0
    for _ in range(80):
        middle = (low + high) / 2
        changed = metric.with_lengths(np.where(touching, middle, 1.0) * metric.lengths)
        low, high = (middle, high) if deficits(changed)[vertex] < total else (low, middle)
    return metric.with_lengths(np.where(touching, high, 1.0) * metric.lengths)


def with_a_low_vertex(metric, deficit):
    """The same with a deficit at one flat vertex that is not noise, but near to it."""
    vertex = int(np.flatnonzero(np.abs(deficits(metric)) < 1e-9)[-1])
    touching = (metric.edges == vertex).any(axis=1)
    low, high = 1.0, 1.1
    for _ in range(60):
        middle = (low + high) / 2
        changed = metric.with_lengths(np.where(touching, middle, 1.0) * metric.lengths)
        low, high = (middle, high) if deficits(changed)[vertex] < deficit else (low, middle)
    return changed


@pytest.mark.parametrize("noise", [1e-12, 1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("n", [4, 10])
def test_noise_on_flat_faces_and_edges_goes_by_as_little(n, noise):
    metric = noisy(grid_cube(n), noise)
    before = deficits(metric)
    flat = before < 1
    result, repair = repaired(metric, 50 * noise)
    assert (~flat).sum() == 8
    assert np.abs(deficits(result))[flat].max() < 1e-12
    assert (np.abs(before) > rounding(metric))[flat].sum() == len(repair.vertices)
    assert np.array_equal(repair.deficits, before[repair.vertices])
    assert 0.1 * noise < repair.largest_factor < 20 * noise
    changes = np.abs(result.lengths / metric.lengths - 1)
    assert repair.largest_change == pytest.approx(changes.max(), rel=1e-9)
    u = repair.factors
    assert (u[~flat] == 0).all() and (u[flat] > 0).any() and (u[flat] < 0).any()
    expected = metric.lengths * np.exp(u[metric.edges].sum(axis=1) / 2)
    np.testing.assert_allclose(result.lengths, expected, rtol=1e-15)


def test_scaled_neighborhoods_are_scaled_back():
    metric = grid_cube(3)
    inside = deficits(metric) < 1
    errors = np.where(inside, 1e-7 * np.cos(np.arange(len(inside))), 0.0)
    scaled = metric.with_lengths(metric.lengths * np.exp(errors[metric.edges].sum(axis=1) / 2))
    low = np.abs(deficits(scaled))[inside].max()
    assert low > 1e-8
    result, repair = repaired(scaled, 2 * low)
    assert np.abs(deficits(result))[inside].max() < 1e-13
    np.testing.assert_allclose(result.lengths, metric.lengths, rtol=1e-13)
    assert repair.factors[inside] == pytest.approx(-errors[inside], abs=1e-13)


def double_cone(n, height):
    """Two flat cones over a regular polygon with n corners."""
    angles = 2 * np.pi * np.arange(n) / n
    rim = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    after = np.roll(np.arange(n), -1)
    faces = [[[k, after[k], n], [after[k], k, n + 1]] for k in range(n)]
    return np.vstack([rim, [[0, 0, height], [0, 0, -height]]]), np.concatenate(faces)


def test_small_positive_deficits_without_negative_ones_belong_to_the_body():
    metric = PolyhedralMetric.from_mesh(*double_cone(100, 0.01))
    tips = deficits(metric)[100:]
    assert 30 * tips.max() < deficits(metric)[:100].min()  # without its tips it would be flat, of volume 0
    result, repair = repaired(metric, 1.1 * tips.max())
    assert result is metric and repair.vertices.size == 0


def test_where_deficits_are_small_anyway_none_is_made_zero_but_negative_ones():
    # A round body: what is within the noise is its curvature.
    metric = noisy(PolyhedralMetric.from_mesh(*icosphere(2)), 1e-2)
    before = deficits(metric)
    lowest = -before.min()
    assert lowest > 0 and (np.abs(before) < 3 * lowest).sum() > 20
    result, repair = repaired(metric, 3 * lowest)
    assert is_convex(result)
    assert np.array_equal(repair.vertices, np.flatnonzero(before < 0))
    assert repair.factors.min() == 0
    after = deficits(result)
    assert after[repair.factors > 0].max() < 1e-12
    assert (after[repair.factors == 0] > 1e-6).any()


def test_of_what_flattens_the_same_vertices_the_factors_have_the_least_energy():
    metric = noisy(grid_cube(3), 1e-7, seed=2)
    _, repair = repaired(metric, 1e-5)
    H = cotangent_laplacian(GluedMetric.of(metric)).toarray()
    flat = deficits(metric) < 1
    u = repair.factors
    assert H[flat] @ u == pytest.approx(-deficits(metric)[flat], abs=1e-11)
    # Any other is u and a function that is harmonic in F.
    rng = np.random.default_rng(0)
    for _ in range(10):
        other = np.zeros_like(u)
        other[~flat] = 1e-7 * rng.normal(size=(~flat).sum())
        other[flat] = -np.linalg.solve(H[np.ix_(flat, flat)], H[np.ix_(flat, ~flat)] @ other[~flat])
        assert np.abs(H[flat] @ other).max() < 1e-20
        assert (u + other) @ H @ (u + other) > u @ H @ u


def test_one_pressed_vertex_changes_the_edges_at_it_only():
    vertices, faces = icosphere(2)
    metric = pressed(PolyhedralMetric.from_mesh(vertices, faces), 17, -1e-4)
    result, repair = repaired(metric, 2e-4)
    assert repair.vertices.tolist() == [17]
    assert repair.deficits == pytest.approx([-1e-4], rel=1e-6)
    assert np.flatnonzero(repair.factors).tolist() == [17]
    elsewhere = (metric.edges != 17).all(axis=1)
    assert np.array_equal(result.lengths[elsewhere], metric.lengths[elsewhere])
    assert deficits(result)[17] == pytest.approx(0.0, abs=1e-13)


def test_an_octahedron_pressed_in_has_a_closed_form():
    # Four isosceles triangles with sides l, l, s round a vertex are flat when sin(pi / 4) = s / (2 l).
    metric = PolyhedralMetric.from_mesh(*octahedron())
    dented = pressed(metric, 0, -1e-3)
    result, repair = repaired(dented, 1e-2)
    l = dented.lengths[(dented.edges == 0).any(axis=1)][0]
    s = dented.lengths[(dented.edges != 0).all(axis=1)][0]
    assert repair.factors[0] == pytest.approx(2 * np.log(s / (np.sqrt(2.0) * l)), rel=1e-9)
    assert repair.largest_change == pytest.approx(s / (np.sqrt(2.0) * l) - 1, rel=1e-9)
    assert deficits(result)[0] == pytest.approx(0.0, abs=1e-13)


def test_no_other_conformal_change_has_a_smaller_range():
    metric = noisy(with_a_low_vertex(grid_cube(3), 1e-6), 1e-8, seed=3)
    _, repair = repaired(metric, 5e-7)
    assert repair.factors.min() == 0
    n = metric.triangulation.n_vertices

    def after(u):
        return deficits(metric.with_lengths(metric.lengths * np.exp(u[metric.edges].sum(axis=1) / 2)))

    step = 1e-4
    slopes = np.stack([(after(e) - after(-e)) / (2 * step) for e in step * np.eye(n)], axis=1)
    # Minimize t over u and t: no deficit negative and 0 <= u <= t, in units of the noise.
    bounds = np.block([[-slopes, np.zeros((n, 1))], [np.eye(n), -np.ones((n, 1))]])
    least = linprog(
        np.append(np.zeros(n), 1.0), A_ub=bounds, b_ub=np.append(after(np.zeros(n)) / 1e-8, np.zeros(n))
    )
    assert least.status == 0
    assert repair.largest_factor == pytest.approx(1e-8 * least.fun, rel=1e-5)


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 10**6), exponent=st.floats(-12, -3), scale=st.sampled_from([1e-150, 1.0, 3e80]))
def test_any_noise_is_repaired_and_units_do_not_matter(seed, exponent, scale):
    metric = noisy(grid_cube(3), 10.0**exponent, seed)
    result, repair = repaired(metric, 1.0)
    assert is_convex(result)
    scaled, same = repaired(metric.with_lengths(scale * metric.lengths), 1.0)
    np.testing.assert_allclose(scaled.lengths, scale * result.lengths, rtol=1e-12)
    np.testing.assert_allclose(
        same.factors, repair.factors, rtol=0, atol=1e-3 * repair.largest_factor + 1e-14
    )


@pytest.mark.parametrize("noise", [1e-10, 1e-6])
def test_triangulations_that_are_not_delaunay(noise):
    metric = GluedMetric.of(noisy(grid_cube(5), noise))
    tables = metric.half_edges()
    assert scramble(tables, 300, np.random.default_rng(0), 0.05) > 30
    scrambled = GluedMetric(tables.faces, tables.twins, tables.face_lengths)
    result, repair = repaired(scrambled, 100 * noise)
    assert isinstance(result, GluedMetric)
    assert len(repair.vertices) > 30
    assert result.deficits.min() > -1e-12
    assert repair.largest_factor < 100 * noise


def test_what_is_convex_stays_as_it_is():
    for metric in (PolyhedralMetric.from_mesh(*random_hull(100, 1)), grid_cube(4)):
        result, repair = repaired(metric, 0.0)
        assert result is metric
        assert repair.vertices.size == repair.deficits.size == 0
        assert repair.largest_factor == repair.largest_change == 0.0


def test_deficits_below_the_noise_are_refused_by_name():
    metric = pressed(PolyhedralMetric.from_mesh(*icosphere(1)), 7, -1e-3)
    with pytest.raises(InvalidMetric, match=r"^vertex 7 has total angle 6\.284185\d* > 2 pi"):
        repaired(metric, 0.9e-3)
    assert repaired(metric, 1.1e-3)[1].vertices.tolist() == [7]


@pytest.mark.parametrize("noise", [-1e-9, np.nan, np.inf])
def test_noise_is_a_number_of_radians(noise):
    with pytest.raises(InvalidParameter, match=r"^the noise is .*, not a non-negative number of radians$"):
        repaired(grid_cube(1), noise)


def test_what_is_far_from_convex_cannot_be_repaired():
    rng = np.random.default_rng(0)
    vertices, faces = random_hull(60, 0)
    spiky = PolyhedralMetric.from_mesh(vertices * np.exp(rng.standard_normal(len(vertices)))[:, None], faces)
    worst = int(np.argmax(np.where(deficits(spiky) < 0, -deficits(spiky), 0)))
    sentence = rf"^vertex {worst} has total angle .* too large for repair by a conformal change$"
    with pytest.raises(InvalidMetric, match=sentence):
        repaired(spiky, 100.0)


def test_vertices_are_exchanged_one_by_one_where_blocks_do_not_help(monkeypatch):
    metric = noisy(with_a_low_vertex(grid_cube(3), 1e-4), 1e-6)
    expected = repaired(metric, 5e-5)[1].factors
    assert (expected > 0).sum() > 10
    monkeypatch.setattr(repair_module, "MAX_BLOCK_EXCHANGES", 0)
    np.testing.assert_allclose(repaired(metric, 5e-5)[1].factors, expected, rtol=1e-9, atol=1e-18)


def test_a_report_can_be_written_of_it():
    report = repaired(noisy(grid_cube(2), 1e-6), 1e-3)[1].as_json()
    assert set(report) == {"vertices", "deficits", "largest_factor", "largest_relative_length_change"}
    assert len(report["vertices"]) == len(report["deficits"]) > 0
    assert min(report["deficits"]) < 0 < report["largest_factor"]


@pytest.mark.parametrize("k", [-1.0, 0.7])
def test_noise_in_curved_spaces(k):
    x, faces, flat = body(20, 0, k, 1.5, flat=30)
    metric = noisy(PolyhedralMetric.from_mesh(x, faces, curvature=k), 1e-9)
    before = deficits(metric)
    for given_metric in (metric, GluedMetric.of(metric)):
        result, repair = repaired(given_metric, 2 * np.abs(before[flat]).max())
        after = GluedMetric.of(result).deficits
        assert result.space == metric.space
        assert np.abs(after[flat]).max() < 1e-11 < 1e-10 < np.abs(before[flat]).max()
        assert repair.largest_change < 1e-6
