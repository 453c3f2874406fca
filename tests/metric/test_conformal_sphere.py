"""The conformal layout on the sphere: cross ratios, Moebius maps, a spheroid's closed form, odd cases."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import smooth_bodies
import zoo
from isoembed.metric.conformal_sphere import conformal_factors, conformal_sphere
from isoembed.metric.curvature import face_areas
from isoembed.metric.delaunay import delaunay
from isoembed.metric.polyhedral import PolyhedralMetric


def layout(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return metric, conformal_sphere(metric, smooth_bodies.recorder())


def length_cross_ratios(metric, lengths):
    """l_ik l_jm / (l_im l_jk) of the edges ij with k to the left and m to the right."""
    t = metric.triangulation
    (i, j), (k, m) = t.edges.T, zoo.edge_opposites(t).T

    def length(a, b):
        return lengths[t.edge_indices(np.column_stack([a, b]))]

    return length(i, k) * length(j, m) / (length(i, m) * length(j, k))


def cross_ratios(metric, x):
    """The complex cross ratios of the same four points of the sphere: all that Moebius maps preserve."""
    turned = x @ zoo.rotation(3)  # no vertex at the pole
    z = (turned[:, 0] + 1j * turned[:, 1]) / (1 - turned[:, 2])
    (i, j), (k, m) = metric.triangulation.edges.T, zoo.edge_opposites(metric.triangulation).T
    return (z[i] - z[k]) * (z[j] - z[m]) / ((z[i] - z[m]) * (z[j] - z[k]))


def center(metric, x):
    weights = np.bincount(metric.faces.ravel(), np.repeat(face_areas(metric), 3))
    return weights @ x / weights.sum()


def points_on_the_sphere(n, seed):
    x = np.random.default_rng(seed).normal(size=(n, 3))
    return zoo.outward_hull(x / np.linalg.norm(x, axis=1)[:, None])


SMOOTH = [smooth_bodies.ellipsoid(), smooth_bodies.drum(), zoo.icosphere(2)]


@pytest.mark.parametrize("mesh", SMOOTH)
def test_the_chords_of_the_layout_are_conformal_to_the_metric(mesh):
    metric, sphere = layout(*mesh)
    assert sphere.exact
    a, b = metric.edges.T
    chords = np.linalg.norm(sphere.points[a] - sphere.points[b], axis=1)
    u = conformal_factors(metric, sphere)
    assert metric.lengths * np.exp((u[a] + u[b]) / 2) == pytest.approx(chords, rel=1e-8)
    wanted = length_cross_ratios(metric, metric.lengths)
    assert length_cross_ratios(metric, chords) == pytest.approx(wanted, rel=1e-8)


@pytest.mark.parametrize("mesh", [*SMOOTH, zoo.cube(), zoo.random_hull(40, 1)])
def test_on_the_unit_sphere_and_centered(mesh):
    metric, sphere = layout(*mesh)
    assert np.linalg.norm(sphere.points, axis=1) == pytest.approx(1, abs=1e-14)
    assert np.abs(center(metric, sphere.points)).max() < 1e-11


@given(st.integers(0, 10**6), st.integers(4, 40))
def test_an_inscribed_polyhedron_comes_back_up_to_a_moebius_map(seed, n):
    # Also where the pole is a vertex of degree n - 1, and where nothing is left inside.
    x, faces = points_on_the_sphere(n, seed)
    metric, sphere = layout(x, faces)
    assert sphere.exact
    wanted, found = cross_ratios(metric, x), cross_ratios(metric, sphere.points)
    error = min(np.abs(found / wanted - 1).max(), np.abs(found.conj() / wanted - 1).max())
    assert error < 1e-6


@pytest.mark.parametrize(
    "mesh", [zoo.tetrahedron(), zoo.octahedron(), zoo.cube(), zoo.icosahedron(), zoo.icosphere(2)]
)
def test_an_inscribed_polyhedron_with_its_center_at_the_origin_comes_back(mesh):
    vertices, faces = mesh
    metric, sphere = layout(vertices, faces)
    assert sphere.exact
    x = vertices - vertices.mean(axis=0)
    x = x / np.linalg.norm(x[0])
    # The cube's diagonals weigh its corners unequally: centered, they are moved.
    if np.abs(center(metric, x)).max() < 1e-12:
        assert smooth_bodies.misfit(sphere.points, x) < 1e-10
    else:
        assert len(faces) == 12


def bipyramid(n, height):
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return zoo.outward_hull(np.vstack([rim, [[0, 0, height], [0.1, 0, -height / 2]]]))


@pytest.mark.parametrize("n", [3, 4, 5, 9])
@pytest.mark.parametrize("height", [0.3, 1.0, 3.0])
def test_bipyramids(n, height):
    metric, sphere = layout(*bipyramid(n, height))
    assert sphere.exact
    a, b = metric.edges.T
    chords = np.linalg.norm(sphere.points[a] - sphere.points[b], axis=1)
    if delaunay(metric) is metric:
        wanted = length_cross_ratios(metric, metric.lengths)
        assert length_cross_ratios(metric, chords) == pytest.approx(wanted, rel=1e-8)
    assert chords.min() > 1e-3


@given(st.integers(0, 10**6))
def test_four_vertices_have_one_cross_ratio(seed):
    metric, sphere = layout(*zoo.random_hull(4, seed))
    assert sphere.exact
    a, b = metric.edges.T
    chords = np.linalg.norm(sphere.points[a] - sphere.points[b], axis=1)
    # Opposite edges are (0, 5), (1, 4) and (2, 3); ideal tetrahedra obey Ptolemy's inequality strictly.
    if delaunay(metric) is metric:
        products, wanted = (l[:3] * l[:2:-1] for l in (chords, metric.lengths))
        assert products / products[0] == pytest.approx(wanted / wanted[0], rel=1e-8)


def spheroid_on_the_sphere(directions, c):
    """The closed-form conformal map of the spheroid x^2 + y^2 + z^2 / c^2 = 1 onto the unit sphere.

    By the isothermal latitude q = int ds / r, the height on the sphere is tanh q.
    """

    def height(theta):
        q, _ = quad(lambda s: np.hypot(np.cos(s), c * np.sin(s)) / np.sin(s), np.pi / 2, theta)
        return -np.tanh(q)

    z = np.array([height(theta) for theta in np.arccos(directions[:, 2])])
    radius = np.hypot(directions[:, 0], directions[:, 1])
    return np.column_stack([directions[:, :2] * (np.sqrt(1 - z**2) / radius)[:, None], z])


@pytest.mark.parametrize("c", [2.0, 0.5])
def test_second_order_convergence_to_the_conformal_map_of_a_spheroid(c):
    errors = []
    for level in (1, 2, 3):
        directions, faces = zoo.icosphere(level)
        directions = directions @ zoo.rotation(0)
        metric = delaunay(PolyhedralMetric.from_mesh(directions * [1, 1, c], faces))
        points = conformal_sphere(metric, smooth_bodies.recorder()).points
        errors.append(smooth_bodies.misfit(points, spheroid_on_the_sphere(directions, c)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 3e-3
    assert (rates > 1.6).all()


@pytest.mark.parametrize("scale", [1e-150, 1e12])
def test_any_unit_and_any_numbering(scale):
    vertices, faces = zoo.random_hull(50, 4)
    _, sphere = layout(vertices, faces)
    moved, others, new = zoo.relabeled(vertices, faces, 0)
    metric = PolyhedralMetric.from_mesh(scale * moved, others[:, ::-1])
    points = conformal_sphere(metric, smooth_bodies.recorder()).points
    assert smooth_bodies.misfit(points[new], sphere.points) < 1e-7


def test_where_there_is_no_layout_tuttes_embedding_stands_in():
    vertices, faces = zoo.random_hull(60, 1)
    metric, sphere = layout(vertices * [1, 1, 100], faces)
    assert not sphere.exact
    assert np.linalg.norm(sphere.points, axis=1) == pytest.approx(1, abs=1e-14)
    a, b = metric.edges.T
    assert np.linalg.norm(sphere.points[a] - sphere.points[b], axis=1).min() > 1e-12


def test_steps_and_factorizations_are_counted():
    recorder = smooth_bodies.recorder()
    conformal_sphere(PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid()), recorder)
    assert 2 <= recorder.iterations <= 6  # quadratic convergence
    assert recorder.factorizations == recorder.iterations + 2  # with the first guess and the layout


@pytest.mark.parametrize("k", [-1.0, 0.7])
def test_spheres_in_curved_spaces_are_their_own_layout(k):
    points, faces = points_on_the_sphere(50, 1)
    metric = PolyhedralMetric.from_mesh(1.1 * points, faces, curvature=k)
    sphere = conformal_sphere(metric, smooth_bodies.recorder())
    assert sphere.exact
    ratios = cross_ratios(metric, points).conj()  # the layout is a mirror image
    assert np.abs(cross_ratios(metric, sphere.points) / ratios - 1).max() < 1e-8
    a, b = metric.edges.T
    u = conformal_factors(metric, sphere)
    chords = metric.space.chord(metric.lengths) * np.exp((u[a] + u[b]) / 2)
    assert chords == pytest.approx(np.linalg.norm(sphere.points[a] - sphere.points[b], axis=1), rel=1e-8)
