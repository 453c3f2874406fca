"""Bending energy as a quadratic form: exact on quadratics, second order on spheres."""

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric, embed
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.charts import Charts


def test_charts_of_a_flat_disc_are_its_own_coordinates():
    points, faces = discs.irregular(120)
    x = np.column_stack([points, 0 * points[:, 0]])
    charts = Charts.of(PolyhedralMetric.from_mesh(x, faces))
    found = np.linalg.norm(charts.positions, axis=1)
    true = np.linalg.norm(points[charts.neighbors] - points[charts.centers], axis=1)
    near = true < 0.9  # beyond the rim, triangles that are unfolded from two sides may be elsewhere
    np.testing.assert_allclose(found[near], true[near], rtol=1e-9)
    turned = charts.positions[:, 0] + 1j * charts.positions[:, 1]
    given = (points[charts.neighbors] - points[charts.centers]) @ [1, 1j]
    ratio = turned / given
    first = np.unique(charts.centers, return_index=True)[1]
    np.testing.assert_allclose(ratio, np.repeat(ratio[first], np.bincount(charts.centers)), rtol=1e-9)


def test_quadratics_are_exact():
    points, faces = discs.irregular(150)
    u, v = points.T
    energy = BendingEnergy(PolyhedralMetric.from_mesh(np.column_stack([points, 0 * u]), faces))
    x = np.column_stack([u * u - u * v, 3 * u * v, 0.5 * v * v + u])
    # |x_uu|^2 + 2 |x_uv|^2 + |x_vv|^2 = 4 + 2 (1 + 9) + 1
    assert energy.square_integral(x) == pytest.approx(25 * energy.area, rel=1e-9)
    assert energy.value(x) == pytest.approx(25 / 4 * energy.area, rel=1e-9)
    np.testing.assert_allclose(energy.curvature_vectors(x), np.tile([1.0, 0, 0.5], (len(x), 1)), atol=1e-8)


def test_a_round_cap_is_second_order():
    exact = 2 * np.pi * (1 - np.cos(1))
    errors = []
    for n in (6, 12):
        points, faces = discs.hexagonal(n)
        x = discs.round_cap(points, 1.0)
        energy = BendingEnergy(PolyhedralMetric.from_mesh(x, faces))
        errors.append(abs(energy.bending(x) - exact))
    assert errors[1] < 0.3 * errors[0] < 0.01


def test_the_form_is_a_smooth_function_of_the_lengths():
    """Of equal distances to the neighbors, another one is the least when a length changes."""
    points, faces = discs.hexagonal(4)
    x = discs.round_cap(points, 1.0)
    metric = PolyhedralMetric.from_mesh(np.column_stack([points, 0 * points[:, 0]]), faces)
    edge = np.zeros(len(metric.lengths))
    edge[np.flatnonzero((metric.edges == 0).any(axis=1))[0]] = 1e-5

    def value(steps):
        return BendingEnergy(metric.with_lengths(metric.lengths + steps * edge)).value(x)

    before, at, after = value(-1), value(0), value(1)
    assert abs(after - 2 * at + before) < 1e-3 * abs(after - before)


@pytest.mark.slow
def test_the_boundary_does_not_bend_less_than_its_curvature_takes():
    """|II|^2 >= 2 |K|: of a free hyperbolic disc up to the error of the mesh."""
    points, faces = discs.hexagonal(8)
    edges = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges
    metric = PolyhedralMetric(faces, discs.hyperbolic_lengths(points, 0.5, edges), edges)
    found = embed(metric, boundary="free")
    assert 0.995 * 1.604 < found.second_form_energy < 1.617  # Gemmer and Venkataramani's bounds


@pytest.mark.parametrize(
    ("points", "faces"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [2, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]),
        (
            [[0, 0, 0], [2, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]],
            [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        ),
    ],
    ids=["triangle", "two triangles", "four triangles"],
)
def test_what_is_flat_has_no_energy_where_neighbors_are_few(points, faces):
    energy = BendingEnergy(PolyhedralMetric.from_mesh(points, faces))
    x = np.array(points, dtype=float)
    assert energy.square_integral(x) < 1e-20
    assert abs(energy.value(x)) < 1e-12


def test_a_catenoid_has_little_mean_curvature():
    found = []
    for n in (24, 48):
        x, faces = discs.band(2 * n, n // 2, lambda t: (np.cosh(t - 0.5), t))
        found.append(BendingEnergy(PolyhedralMetric.from_mesh(x, faces)).bending(x))
    assert 0 < found[1] < 0.2 * found[0] < 4e-4
