"""Polynomials fitted to neighbors: dense least squares, what they reproduce, and where there are too few."""

import numpy as np
import pytest
from scipy.sparse import csr_array

import smooth_bodies
import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.local_fit import HUB_DEGREE, FitResiduals, neighborhoods
from isoembed.surface.normal_fits import TWO_RINGS

POWERS = [(i, degree - i) for degree in range(6) for i in range(degree + 1)]


def scattered(counts, seed=0):
    """Neighborhoods of so many points, and charts at random: (indptr, indices), charts."""
    rng = np.random.default_rng(seed)
    n = max(counts) + 1
    counts = np.concatenate([counts, np.zeros(n - len(counts), dtype=int)])
    indices = [np.delete(np.arange(n), v)[:count] for v, count in enumerate(counts)]
    indptr = np.concatenate([[0], np.cumsum(counts)])
    return (indptr, np.concatenate(indices)), rng.uniform(-2, 2, size=(indptr[-1], 2))


def graph(triangulation):
    return triangulation.adjacency.indptr, triangulation.adjacency.indices


def fit_residual_operator(near, charts, degree=3):
    n = len(near[0]) - 1
    return FitResiduals.of(0, near, charts, degree).matrix(n)


def fitted_weights(chart, degree):
    """The weights of the points in the constant term of a fit, by dense least squares."""
    x, y = chart.T
    root = 1 / np.sqrt(0.5 + x**2 + y**2)
    columns = np.stack([x**i * y**j for i, j in POWERS if i + j <= degree], axis=1)
    return np.linalg.pinv(columns * root[:, None])[0] * root


def test_neighborhoods_are_two_rings():
    triangulation = Triangulation(smooth_bodies.ellipsoid()[1])
    indptr, indices = neighborhoods(graph(triangulation))
    n = triangulation.n_vertices
    found = csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n)).toarray()
    A = triangulation.adjacency.toarray()
    assert np.array_equal(found, ((A + A @ A) > 0) & ~np.eye(n, dtype=bool))


def test_too_few_neighbors_are_joined_by_a_third_ring():
    triangulation = Triangulation(zoo.icosphere(1)[1])
    A = triangulation.adjacency.toarray()
    two = ((A + A @ A) > 0).sum(axis=1) - 1
    three = ((A + A @ A + A @ A @ A) > 0).sum(axis=1) - 1
    assert two.min() < 16 <= two.max()
    assert np.array_equal(np.diff(neighborhoods(graph(triangulation), 16)[0]), np.where(two < 16, three, two))


def test_no_paths_through_hubs():
    """On a bipyramid over an n-gon all vertices are two edges apart, by way of the tips."""
    n = 3 * HUB_DEGREE
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    faces = np.concatenate(
        [np.stack([i, j, np.full(n, n)], axis=1), np.stack([j, i, np.full(n, n + 1)], axis=1)]
    )
    counts = np.diff(neighborhoods(graph(Triangulation(faces)))[0])
    assert (counts[:n] == 3 * 2 + 2).all()  # three on each side, and the tips
    assert (counts[n:] == n + 1).all()


@pytest.mark.parametrize(
    ("count", "most", "degree"),
    [
        *[
            (3, 3, 0),
            (5, 3, 0),
            (6, 3, 1),
            (8, 3, 1),
            (9, 3, 2),
            (12, 3, 2),
            (13, 3, 3),
            (18, 3, 3),
            (40, 3, 3),
        ],
        *[(17, 5, 3), (23, 5, 4), (36, 5, 5), (40, 4, 4)],
    ],
)
def test_weights_are_those_of_dense_least_squares(count, most, degree):
    near, charts = scattered([count])
    row = fit_residual_operator(near, charts, most).toarray()[0]
    assert row[0] == 1
    assert -row[near[1]] == pytest.approx(fitted_weights(charts, degree), abs=1e-10)


def test_cubics_leave_nothing():
    near, charts = scattered([TWO_RINGS, 18, 30], 1)
    operator = fit_residual_operator(near, charts)
    for v in range(3):
        mine = slice(near[0][v], near[0][v + 1])
        values = np.zeros(operator.shape[0])
        for i, j in POWERS[:10]:
            values[near[1][mine]] = charts[mine, 0] ** i * charts[mine, 1] ** j
            values[v] = i + j == 0
            assert abs((operator @ values)[v]) < 1e-12


def test_a_rotated_chart_is_the_same_chart():
    near, charts = scattered([20], 2)
    turned = charts @ zoo.rotation(0)[:2, :2]
    assert not np.allclose(turned @ turned.T, charts @ charts.T)  # no rotation of the plane
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    first, second = (fit_residual_operator(near, c).toarray() for c in (charts, charts @ turn))
    assert second == pytest.approx(first, abs=1e-12)


def test_points_on_a_line_are_fitted_along_it():
    near, charts = scattered([18], 3)
    on_line = charts[:, :1] * [[0.6, 0.8]]
    row = fit_residual_operator(near, on_line).toarray()[0]
    t = charts[:, 0]
    root = 1 / np.sqrt(0.5 + t**2)
    cubic = np.linalg.pinv(np.stack([t**k for k in range(4)], axis=1) * root[:, None])[0] * root
    assert -row[near[1]] == pytest.approx(cubic, abs=1e-6)


def test_points_on_one_side_are_not_extrapolated_by_cubics():
    """Seen from outside, neighbors say little about the origin: a high degree would follow their noise."""
    near, charts = scattered([18], 4)
    row = fit_residual_operator(near, charts * 0.5 + [3.0, 0.0]).toarray()[0]
    assert np.abs(row[near[1]]).sum() < 10
    assert np.abs(fitted_weights(charts * 0.5 + [3.0, 0.0], 3)).sum() > 100


def test_points_on_top_of_the_vertex_have_their_mean():
    near, charts = scattered([18, 0])
    row = fit_residual_operator(near, 0 * charts).toarray()[0]
    assert -row[near[1]] == pytest.approx(1 / 18, rel=1e-14)


def test_rows_sum_to_zero():
    near, charts = scattered(list(range(1, 30)), 5)
    sums = np.asarray(fit_residual_operator(near, charts).sum(axis=1))
    assert np.abs(sums[:29]).max() < 1e-13
