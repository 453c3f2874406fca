"""Certificates in hyperbolic and spherical space: of known bodies, and of what must have none."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import curved
import zoo
from isoembed import Hyperbolic, PolyhedralMetric, Space, Spherical
from isoembed.proof.convex import certify
from isoembed.proof.length_equations import LengthEquations
from isoembed.space.models import from_model, to_model
from isoembed.surface import alignment
from isoembed.surface.curvature import dihedral_angles

SPACES = [Hyperbolic(1.0), Hyperbolic(0.01), Spherical(0.4)]


def metric_of(x, faces, space):
    ends = PolyhedralMetric.from_mesh(x, faces).edges
    lengths = space.distances(x[ends[:, 0]], x[ends[:, 1]])
    return PolyhedralMetric(faces, lengths, ends, curvature=space.curvature)


def in_space(body, space, radius=1.0):
    """A Euclidean body's projective image, with corners at most at this distance: points and faces."""
    vertices, faces = body
    r = np.array(radius)
    y = vertices * (space.sn(r) / space.cs(r) / np.linalg.norm(vertices, axis=1).max())
    return from_model(space, y, "projective"), faces


def centered_cube():
    vertices, faces = zoo.cube()
    return vertices - 0.5, faces


@pytest.mark.parametrize("k", [-1.0, -1e-7, 0.3])
@pytest.mark.parametrize("size", [0.02, 1.0, 3.0])
@pytest.mark.parametrize(("n", "aspect"), [(8, 1), (60, 10)])
def test_random_hulls(k, size, n, aspect):
    x, faces, _ = curved.body(n, 3, k, size, aspect=aspect)
    found = certify(metric_of(x, faces, Space(k)), x)
    assert found.certified
    assert found.distance < 2e-14 * size
    assert found.kantorovich < 1e-15
    angles = dihedral_angles(PolyhedralMetric.from_mesh(x, faces).triangulation, x, Space(k))
    assert 0.2 * angles.min() < found.smallest_dihedral < angles.min()


@pytest.mark.parametrize("space", SPACES, ids=repr)
@pytest.mark.parametrize("radius", [0.1, 1.4])
@pytest.mark.parametrize(("body", "flat"), [(zoo.octahedron(), 0), (centered_cube(), 6)])
def test_solids(space, radius, body, flat):
    x, faces = in_space(body, space, radius)
    found = certify(metric_of(x, faces, space), x)
    assert found.certified
    assert found.flat_edges == flat
    assert found.distance < 1e-13


@given(st.sampled_from(SPACES), st.sampled_from([0.0, 1e-15, 1e-12, 1e-9]), st.integers(0, 10**6))
def test_the_exact_vertices_are_within_the_distance(space, noise, seed):
    """Of the body at which the lengths were measured, whose rounding the certificate is told."""
    exact, faces = in_space(zoo.random_hull(12, seed % 50), space)
    metric = metric_of(exact, faces, space)
    moves = np.random.default_rng(seed).normal(size=exact.shape)
    x = exact + noise * moves / np.linalg.norm(moves, axis=1)[:, None]
    found = certify(metric, x, length_errors=4e-16 * np.ones(len(metric.lengths)))
    assert found.certified
    assert alignment.distance(x, exact, space) <= 2 * found.distance + 1e-14
    assert found.distance <= 4 * noise + 1e-12


@pytest.mark.parametrize("space", SPACES, ids=repr)
@pytest.mark.parametrize("noise", [0.0, 1e-10])
def test_the_numbers_bound_what_they_are_said_to(space, noise):
    x, faces = in_space(zoo.random_hull(25, 8), space)
    metric = metric_of(x, faces, space)
    x = x + noise * np.random.default_rng(1).normal(size=x.shape)
    found, (a, b) = certify(metric, x), metric.edges.T
    missed = np.abs(space.distances(x[a], x[b]) - metric.lengths).max() / metric.mean_length
    assert missed <= found.residual < 1.001 * missed + 1e-14
    t, unit = metric.normalized, metric.unit
    J = LengthEquations.of(t, x / unit).matrix().toarray()
    sigma = np.linalg.svd(J, compute_uv=False)[-1] / t.mean_length
    assert 0.6 * sigma < found.sigma_min < sigma


@pytest.mark.parametrize("space", SPACES, ids=repr)
@pytest.mark.parametrize("body", [zoo.octahedron(), centered_cube(), zoo.random_hull(40, 3)])
def test_a_vertex_that_was_moved_is_found_out(space, body):
    x, faces = in_space(body, space)
    metric = metric_of(x, faces, space)
    for v in range(len(x)):
        for direction in np.eye(3):
            moved = x.copy()
            moved[v] += 1e-6 * metric.mean_length * direction
            assert not certify(metric, moved).certified


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_lengths_of_another_curvature_are_found_out(space):
    x, faces = in_space(zoo.random_hull(20, 0), space)
    metric = metric_of(x, faces, space)
    other = PolyhedralMetric(faces, metric.lengths, metric.edges, curvature=1.01 * space.curvature)
    reason = certify(other, x).reason
    assert reason.startswith("not certified, because ")
    euclidean = PolyhedralMetric(faces, metric.lengths, metric.edges)
    assert "misses its length" in certify(euclidean, x).reason


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_a_body_that_is_not_convex(space):
    vertices, faces = zoo.octahedron()
    vertices[int(np.argmax(vertices[:, 2])), 2] = -0.5
    x, faces = in_space((vertices, faces), space)
    assert "is concave" in certify(metric_of(x, faces, space), x).reason


def test_the_unit_does_not_matter():
    space = Hyperbolic(0.5)
    x, faces = in_space(zoo.random_hull(30, 1), space)
    expected = certify(metric_of(x, faces, space), x)
    for scale in (2.0**-300, 2.0**300):
        found = certify(metric_of(x, faces, space).scaled(scale), scale * x)
        assert found.certified
        assert found.distance == pytest.approx(scale * expected.distance, rel=1e-12)
        assert found.sigma_min == expected.sigma_min


def test_curvature_to_zero():
    x, faces = in_space(zoo.random_hull(30, 2), Space(0.0))
    flat = certify(metric_of(x, faces, Space(0.0)), x)
    off = []
    for k in (-1e-4, -1e-5, 1e-300):
        found = certify(metric_of(x, faces, Space(k)), x)
        off.append(found.sigma_min - flat.sigma_min)
    assert off[0] / off[1] == pytest.approx(10, rel=1e-2)
    assert off[2] == pytest.approx(0, abs=1e-12)
    assert found.smallest_dihedral == pytest.approx(flat.smallest_dihedral, rel=1e-9)
    assert found.isolation == pytest.approx(flat.isolation / 3, rel=1e-6)


def test_edges_that_are_too_long():
    x, faces = in_space(zoo.tetrahedron(), Hyperbolic(1.0), 8.0)
    reason = certify(metric_of(x, faces, Hyperbolic(1.0)), x).reason
    assert "is longer than 10 radii of curvature" in reason


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_the_matrix_is_the_derivative_and_the_rest_is_bounded(space):
    x, faces = in_space(zoo.random_hull(20, 5), space)
    metric = metric_of(x, faces, space).normalized
    equations = LengthEquations.of(metric, x / metric_of(x, faces, space).unit)
    J, rng = equations.matrix().toarray(), np.random.default_rng(0)

    def value(d):
        return equations.residuals(d)[0]

    for size in (1.0, 0.01):
        for one in range(20):
            d = size * equations.room * rng.normal(size=x.shape) / 10
            if one % 2:
                d *= (np.arange(len(x)) == one)[:, None]  # nearly the worst
            weighted = equations.weights[:, None] * d
            rest = value(d) - value(0 * d) - J @ weighted.ravel()
            farthest = np.linalg.norm(d, axis=1).max()
            allowed = 2**0.5 * farthest * np.linalg.norm(weighted) + 1e-12 * size * equations.room
            assert np.linalg.norm(rest) <= allowed
            assert np.linalg.norm(J @ weighted.ravel()) > 100 * np.linalg.norm(rest)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_angles_change_no_more_than_is_said(space):
    """Dihedral angles in space against those of the projective coordinates."""
    x, faces = in_space(zoo.random_hull(40, 6), space, 1.3)
    metric = metric_of(x, faces, space).normalized
    equations = LengthEquations.of(metric, x / metric_of(x, faces, space).unit)
    t = metric.triangulation
    straight = np.sin(dihedral_angles(t, to_model(space, x, "projective")))
    ratios = np.sin(dihedral_angles(t, x, space)) / straight
    assert (equations.dihedral_shares() <= ratios).all()
    assert ratios.max() <= equations._distortion
    w = space.heights(x)
    assert equations._distortion == pytest.approx(max(w.max(), (1 / w).max()) ** 2, rel=1e-3)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_detours_are_bounded(space):
    """Of a triangle over an edge, which is the longest way of its slope in projective coordinates."""
    x, faces = in_space(zoo.random_hull(20, 7), space)
    unit = metric_of(x, faces, space).unit
    metric = metric_of(x, faces, space).normalized
    equations = LengthEquations.of(metric, x / unit)
    slope, space = 1e-4, metric.space
    flat, none = np.ones(len(metric.edges), dtype=bool), np.zeros(len(metric.edges))
    bounds = equations.detours(flat, np.full(len(flat), slope), 0.0, none)
    y = to_model(space, x / unit, "projective")
    for e, (a, b) in enumerate(metric.edges):
        across = np.cross(y[b] - y[a], [0.3, 0.5, 0.8])
        top = (y[a] + y[b]) / 2 + slope * np.linalg.norm(y[b] - y[a]) / 2 * across / np.linalg.norm(across)
        p, q, r = from_model(space, np.array([y[a], top, y[b]]), "projective")
        L, l = space.distances(p, q) + space.distances(q, r), metric.lengths[e]
        m = equations.densities
        longer = (space.chord(L) ** 2 - space.chord(l) ** 2) * m[a] * m[b] / (2 * equations.divisors[e])
        assert 0 < longer <= bounds[e] < 200 * longer


def test_fractions_of_the_equations_vanish_at_exact_points():
    """Conformal coordinates that are floats, at distances whose squared chords are known."""
    p = np.array([[0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.5], [-0.25, -0.25, -0.25]])
    k = -1.0
    m = [1 + Fraction(k) / 4 * sum(Fraction(c) ** 2 for c in point) for point in p]
    x = np.array([[float(Fraction(c) / w) for c in point] for point, w in zip(p, m, strict=True)])
    metric = metric_of(x, np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]), Hyperbolic(1.0))
    for e, (a, b) in enumerate(metric.edges):
        square = sum((Fraction(c) - Fraction(d)) ** 2 for c, d in zip(p[a], p[b], strict=True)) / (
            m[a] * m[b]
        )
        assert metric.space.chord(metric.lengths[e]) == pytest.approx(float(square) ** 0.5, rel=1e-14)
    assert certify(metric, x).certified
