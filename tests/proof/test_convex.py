"""Certificates: of bodies that are known exactly, of what must not have one, in any unit, with any labels."""

import itertools
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import isoembed
import zoo
from isoembed import PolyhedralMetric, embed
from isoembed.metric.curvature import deficits
from isoembed.proof import convex as certificate_module
from isoembed.proof import nearby_realization
from isoembed.proof.convex import certify
from isoembed.proof.nearby_hulls import prove_nearby_hulls
from isoembed.proof.nearby_realization import FARTHEST
from isoembed.surface.rigidity import edge_rows


def fibonacci(n, stretch):
    """Convex hull of n points on an ellipsoid, spread like the seeds of a sunflower."""
    k = np.arange(n) + 0.5
    z, t = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z * z)
    return zoo.outward_hull(np.column_stack([r * np.cos(t), r * np.sin(t), z]) * stretch)


def lattice(*coordinates):
    """Hull of the permutations of +-coordinates: integers."""
    points = {
        tuple(s * p for s, p in zip(signs, permuted, strict=True))
        for permuted in itertools.permutations(coordinates)
        for signs in itertools.product((1, -1), repeat=3)
    }
    return zoo.outward_hull(np.array(sorted(points), dtype=float))


CUBOCTAHEDRON = lattice(0, 1, 1)
TRUNCATED_CUBOCTAHEDRON = lattice(2, 5, 9)  # squares, rectangles, hexagons and octagons
TRUNCATED_OCTAHEDRON = lattice(0, 1, 2)
LATTICES = [lattice(0, 0, 1), lattice(1, 1, 1), CUBOCTAHEDRON, TRUNCATED_OCTAHEDRON, TRUNCATED_CUBOCTAHEDRON]


def weights(metric):
    """Roots of the sums of 1 / l^2 of the edges at each vertex."""
    return np.sqrt(np.bincount(metric.edges.ravel(), np.repeat(metric.lengths**-2, 2)))


def rigidity_matrix(metric, vertices):
    """J, its columns over the weights."""
    t = metric.triangulation
    J = np.zeros((t.n_edges, t.n_vertices, 3))
    rows = edge_rows(t, vertices, metric.lengths)
    J[np.arange(t.n_edges), t.edges[:, 0]], J[np.arange(t.n_edges), t.edges[:, 1]] = rows, -rows
    J /= weights(metric)[:, None]
    return J.reshape(t.n_edges, -1)


def certified(vertices, faces, **options):
    return certify(PolyhedralMetric.from_mesh(vertices, faces), vertices, **options)


def refused(metric, vertices, **options):
    found = certify(metric, vertices, **options)
    assert not found.certified
    assert found.distance is None
    assert found.reason.startswith("not certified, because ")
    return found


@pytest.mark.parametrize("body", [zoo.tetrahedron(), zoo.octahedron(), zoo.icosahedron()])
def test_platonic_solids_of_triangles(body):
    found = certified(*body)
    assert found.certified
    assert found.distance < 1e-15 * np.abs(body[0]).max()
    assert found.residual < 1e-15
    assert found.flat_edges == 0


@pytest.mark.parametrize(
    ("body", "flat"), [(zoo.cube(), 6), (CUBOCTAHEDRON, 6), (TRUNCATED_OCTAHEDRON, 6 + 8 * 3)]
)
def test_bodies_with_polygons(body, flat):
    found = certified(*body)
    assert found.certified
    assert found.distance < 1e-15
    assert found.flat_edges == flat


@pytest.mark.parametrize("seed", range(10))
def test_random_hulls(seed):
    found = certified(*zoo.random_hull(30 * (seed + 1), seed))
    assert found.certified
    assert found.distance < 1e-14


@pytest.mark.parametrize("n", [100, 1000, 10_000])
def test_hulls_of_ellipsoids(n):
    found = certified(*fibonacci(n, [3, 2, 1]))
    assert found.certified
    assert found.distance < 1e-14
    assert found.kantorovich < 1e-15


@pytest.mark.parametrize("stretch", [(1, 1, 0.003), (300, 1, 1)])
def test_slabs_and_needles(stretch):
    vertices, faces = fibonacci(300, stretch)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    assert certify(metric, vertices, length_errors=4e-16 * metric.lengths).certified


@given(st.sampled_from(LATTICES), st.sampled_from([0.0, 1e-15, 1e-12, 1e-9]), st.integers(0, 10**6))
def test_the_exact_vertices_are_within_the_distance(body, noise, seed):
    exact, faces = body
    a, b = PolyhedralMetric.from_mesh(exact, faces).edges.T
    lengths = np.sqrt(((exact[a] - exact[b]) ** 2).sum(axis=1))  # rounded once: from integers
    metric = PolyhedralMetric(faces, lengths)
    moves = np.random.default_rng(seed).normal(size=exact.shape)
    vertices = exact + noise * moves / np.linalg.norm(moves, axis=1)[:, None]
    found = certify(metric, vertices, length_errors=np.spacing(lengths) / 2)
    assert found.certified
    # The best fit has the least sum of squares, so it has no larger one than the fit of the certificate.
    left, _, right = np.linalg.svd(vertices.T @ exact)
    off = np.linalg.norm(vertices @ left @ right - exact, axis=1)
    assert np.sqrt(np.mean(off**2)) <= found.distance + 2e-15
    assert found.distance <= 2 * noise + 1e-13


@given(st.integers(0, 10**6))
def test_the_numbers_bound_what_they_are_said_to(seed):
    vertices, faces = zoo.random_hull(25, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    vertices = vertices + 1e-10 * np.random.default_rng(seed).normal(size=vertices.shape)
    found = certify(metric, vertices)
    sigma = np.linalg.svd(rigidity_matrix(metric, vertices), compute_uv=False)[-1] / metric.mean_length
    assert 0.6 * sigma < found.sigma_min < sigma
    a, b = metric.edges.T
    missed = np.abs(np.linalg.norm(vertices[a] - vertices[b], axis=1) - metric.lengths).max()
    assert found.residual == pytest.approx(missed / metric.mean_length, rel=1e-4)


@pytest.mark.parametrize(
    "body", [zoo.tetrahedron(), zoo.octahedron(), zoo.cube(), zoo.icosahedron(), zoo.random_hull(50, 3)]
)
@pytest.mark.parametrize("direction", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0.48, 0.64]])
def test_a_vertex_that_was_moved_is_found_out(body, direction):
    vertices, faces = body
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    for v in range(len(vertices)):
        moved = vertices.copy()
        moved[v] += 1e-6 * metric.mean_length * np.array(direction)
        refused(metric, moved)


def test_a_vertex_that_was_moved_outward_hardly_changes_lengths_and_is_found_out():
    vertices, faces = fibonacci(3000, [1, 1, 1])
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    moved = vertices.copy()
    moved[1234] += 1e-6 * metric.mean_length * vertices[1234]
    a, b = metric.edges.T
    assert (
        np.abs(np.linalg.norm(moved[a] - moved[b], axis=1) - metric.lengths).max() < 1e-7 * metric.mean_length
    )
    moved = vertices.copy()
    moved[1234] += 1e-7 * metric.mean_length * vertices[1234]
    assert "the exact vertices may be 1.0e-07 mean edge lengths away" in refused(metric, moved).reason


def test_a_length_that_is_missed_is_named():
    vertices, faces = zoo.octahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    lengths = metric.lengths.copy()
    lengths[4] *= 1 + 1e-6
    reason = refused(metric.with_lengths(lengths), vertices).reason
    assert f"edge 4 {metric.edges[4].tolist()} misses its length by 1.0e-06 of the mean edge length" in reason


def test_errors_of_the_lengths_widen_the_distance():
    vertices, faces = zoo.random_hull(60, 0)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    distances = [certify(metric, vertices, length_errors=e * metric.lengths).distance for e in (1e-14, 1e-12)]
    assert distances[1] == pytest.approx(100 * distances[0], rel=0.1)
    wide = refused(metric, vertices, length_errors=1e-9 * metric.lengths)
    assert "mean edge lengths away, more than 1.0e-08" in wide.reason
    assert wide.kantorovich < 0.5
    wider = refused(metric, vertices, length_errors=1e-3 * metric.lengths)
    assert "the residuals are too large: h = 2 K rho / sigma^2 is" in wider.reason


@pytest.mark.parametrize("body", [zoo.octahedron(), zoo.cube(), zoo.random_hull(40, 4)])
def test_the_distance_covers_the_worst_errors_of_the_lengths(body):
    vertices, faces = body
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    errors = 1e-12 * metric.lengths
    found = certify(metric, vertices, length_errors=errors)
    left, sigma, right = np.linalg.svd(rigidity_matrix(metric, vertices), full_matrices=False)
    worst = errors * np.sign(left[:, -1])
    step = (right.T @ ((left.T @ worst) / sigma)).reshape(-1, 3) / weights(metric)[:, None]
    assert np.linalg.norm(step, axis=1).max() < found.distance < 15 * np.linalg.norm(step)


def quadratic_bound(metric):
    """The K of the theorem."""
    return 2 / weights(metric).min()


@pytest.mark.parametrize("seed", range(3))
def test_the_quadratic_part_of_the_residuals_is_bounded(seed):
    vertices, faces = zoo.random_hull(40, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    a, b = metric.edges.T
    d = np.random.default_rng(seed).normal(size=(100, *vertices.shape))
    d[50:] *= (np.arange(len(vertices)) == np.argmin(weights(metric)))[:, None]  # nearly the worst
    quadratic = np.linalg.norm(((d[:, a] - d[:, b]) ** 2).sum(axis=2) / (2 * metric.lengths), axis=1)
    weighted = np.linalg.norm(weights(metric)[:, None] * d, axis=(1, 2))
    farthest = np.linalg.norm(d, axis=2).max(axis=1)
    for allowed in (quadratic_bound(metric) / 2 * weighted**2, 2**0.5 * farthest * weighted):
        assert 0.1 < (quadratic / allowed).max() <= 1


def in_its_unit(vertices, faces):
    """A metric in its own unit, and the vertices in it."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return metric.normalized, vertices / metric.unit


def test_the_kantorovich_number():
    metric, vertices = in_its_unit(*zoo.random_hull(40, 1))
    errors = 1e-11 * metric.lengths
    found = certify(metric, vertices, length_errors=errors)
    expected = (
        2 * quadratic_bound(metric) * np.linalg.norm(errors) / (found.sigma_min * metric.mean_length) ** 2
    )
    assert found.kantorovich == pytest.approx(expected, rel=1e-5)


def test_the_kantorovich_number_allows_for_the_step_of_newtons_method():
    metric, vertices = in_its_unit(*fibonacci(300, [1000, 1, 1]))
    K, errors = quadratic_bound(metric), 1e-14 * metric.lengths
    moved = vertices + 1e-9 * np.random.default_rng(0).normal(size=vertices.shape)
    found = certify(metric, moved, length_errors=errors)
    sigma = found.sigma_min * metric.mean_length
    assert found.kantorovich > 1.002 * 2 * K * np.linalg.norm(errors) / sigma**2


def tilt(monkeypatch, slope):
    """Have the faces of the cube tilted."""

    def tilted(*arguments):
        return replace(prove_nearby_hulls(*arguments), slopes=np.full(18, slope))

    monkeypatch.setattr(certificate_module, "prove_nearby_hulls", tilted)


def test_detours_must_not_lead_out_of_reach(monkeypatch):
    metric, vertices = in_its_unit(*zoo.cube())
    assert certify(metric, vertices).certified
    tilt(monkeypatch, 1e-5)
    assert "the exact vertices may be " in refused(metric, vertices).reason


def test_the_kantorovich_number_allows_for_detours(monkeypatch):
    slope = 1e-6
    tilt(monkeypatch, slope)
    metric, vertices = in_its_unit(*zoo.cube())
    errors = 1e-12 * metric.lengths
    found = certify(metric, vertices, length_errors=errors)
    detours = np.sqrt(6) * metric.lengths.max() * slope**2 / 2
    rho = np.linalg.norm(errors) + detours
    assert found.kantorovich == pytest.approx(
        2 * quadratic_bound(metric) * rho / (found.sigma_min * metric.mean_length) ** 2, rel=1e-5
    )


def test_convexity_is_proven_as_far_as_the_distance(monkeypatch):
    reaches = []

    def spy(triangulation, vertices, reach):
        reaches.append(reach)
        return prove_nearby_hulls(triangulation, vertices, reach)

    monkeypatch.setattr(certificate_module, "prove_nearby_hulls", spy)
    vertices, faces = zoo.random_hull(40, 0)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    for errors in (None, 1e-13 * metric.lengths):
        found = certify(metric, vertices, length_errors=errors)
        assert found.distance <= metric.unit * reaches.pop() < 4 * found.distance + 1e-14


@pytest.mark.parametrize("decimals", [9, 11, 13])
def test_diagonals_that_rounding_has_bent_do_not_count(decimals):
    """A turned box with rounded coordinates: its edges are right angles, whatever the six diagonals are."""
    x, faces = zoo.outward_hull(np.array(list(itertools.product((0.0, 3.0), (0.0, 2.0), (0.0, 1.0)))))
    x = np.round(x @ zoo.rotation(0).T, decimals)
    found = embed(PolyhedralMetric.from_mesh(x, faces), method="alexandrov")
    proof = isoembed.certify(found)
    assert proof.certified and proof.flat_edges == 6
    assert 0.99 < proof.smallest_dihedral < np.pi / 2
    assert "but across 6 diagonals of polygons that are flat up to rounding" in proof.reason


def test_a_realization_that_is_not_convex():
    vertices, faces = zoo.octahedron()
    top = int(np.argmax(vertices[:, 2]))
    vertices[top, 2] = -0.5
    reason = refused(PolyhedralMetric.from_mesh(vertices, faces), vertices).reason
    assert "is concave" in reason


def test_the_wrong_diagonals():
    vertices, faces = zoo.random_hull(20, 5)
    t = PolyhedralMetric.from_mesh(vertices, faces).triangulation
    e = next(e for e in range(t.n_edges) if t.edge_indices(zoo.edge_opposites(t)[e][None])[0] < 0)
    (a, b), (c, d) = t.edges[e], zoo.edge_opposites(t)[e]
    flipped = np.vstack([np.delete(faces, t.edge_faces[e], axis=0), [[c, d, b], [d, c, a]]])
    metric = PolyhedralMetric.from_mesh(vertices, flipped)
    reason = refused(metric, vertices).reason
    assert f"{sorted((int(c), int(d)))} is concave" in reason


def test_a_flat_vertex():
    vertices, faces = zoo.octahedron()
    center = len(vertices)
    vertices = np.vstack([vertices, vertices[faces[0]].mean(axis=0)])
    a, b, c = faces[0]
    faces = np.vstack([faces[1:], [[a, b, center], [b, c, center], [c, a, center]]])
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    reason = refused(metric, vertices).reason
    assert reason.startswith("not certified, because the lengths may not fix the vertices (the matrix ")
    assert f"vertex {center} is the flattest, with a deficit of {deficits(metric)[center]:.1e}" in reason


def test_too_many_vertices(monkeypatch):
    monkeypatch.setattr(nearby_realization, "MAX_VERTICES", 11)
    vertices, faces = zoo.icosahedron()
    found = refused(PolyhedralMetric.from_mesh(vertices, faces), vertices)
    assert found.reason == "not certified, because there are more than 11 vertices"
    assert certified(*zoo.octahedron()).certified


@pytest.mark.parametrize("scale", [1e-150, 1e-12, 1e150])
def test_the_unit_does_not_matter(scale):
    vertices, faces = zoo.random_hull(50, 1)
    expected, found = certified(vertices, faces), certified(scale * vertices, faces)
    assert found.certified
    assert 0 < found.distance < 1e-14 * scale
    assert found.sigma_min == pytest.approx(expected.sigma_min, rel=1e-9)
    assert found.smallest_dihedral == pytest.approx(expected.smallest_dihedral, rel=1e-9)
    moved = scale * vertices
    moved[0] *= 1 + 1e-6
    refused(PolyhedralMetric.from_mesh(scale * vertices, faces), moved)


def test_a_power_of_two_as_the_unit_changes_nothing_but_the_distance():
    vertices, faces = zoo.cube()
    expected, found = certified(vertices, faces), certified(2.0**40 * vertices, faces)
    assert found.distance == pytest.approx(2.0**40 * expected.distance, rel=1e-12)
    assert found.kantorovich == expected.kantorovich


@given(st.integers(0, 10**6))
def test_motions_and_labels_do_not_matter(seed):
    vertices, faces = zoo.random_hull(30, 7)
    moved, relabeled, _ = zoo.relabeled(vertices @ zoo.rotation(seed).T + 1.0, faces, seed)
    expected, found = certified(vertices, faces), certified(moved, relabeled)
    assert found.certified
    assert found.distance < 1e-14
    assert found.sigma_min == pytest.approx(expected.sigma_min, rel=0.1)
    assert found.smallest_dihedral == pytest.approx(expected.smallest_dihedral, rel=1e-6)


def test_reports():
    vertices, faces = zoo.icosahedron()
    found = certified(vertices, faces).as_json()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["certified"] is True and found["evidence"] == "proved"
    assert found["basis"].endswith("Alexandrov's theorem (1941)")
    within, angle = (float(number) for number in re.findall(r"\d\.\de[+-]\d+", found["reason"]))
    assert found["distance"] < within < 1.2 * found["distance"]
    assert 0.8 * found["smallest_dihedral"] < angle < found["smallest_dihedral"]
    assert 0 < found["distance"] < FARTHEST
    assert 0 < found["kantorovich"] < 1e-20
    moved = vertices.copy()
    moved[3, 0] += 1e-3
    found = certify(PolyhedralMetric.from_mesh(vertices, faces), moved).as_json()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["certified"] is False
    assert found["sigma_min"] is None
