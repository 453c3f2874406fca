"""Generalized polytopes: closed forms, finite differences, and bodies whose radii are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from curved import body, tables_in
from isoembed import PolyhedralMetric
from isoembed.alexandrov.polytope import Polytope
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.metric.glued import GluedMetric
from isoembed.space import Space
from scrambling import scramble

CENTER = np.array([0.05, -0.1, 0.02])


def tables_of(vertices, faces, scrambled=0):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    tables = GluedMetric.of(metric).half_edges()
    scramble(tables, scrambled, np.random.default_rng(0))
    return tables


@given(st.integers(6, 40), st.integers(0, 10**6))
def test_a_body_has_no_curvature_around_an_inner_point(n, seed):
    vertices, faces = zoo.random_hull(n, seed)
    vertices = vertices - vertices.mean(axis=0)
    radii = np.linalg.norm(vertices, axis=1)
    p = Polytope.over(tables_of(vertices, faces, 10 * n), radii)
    assert p is not None
    # Flips went back to the faces of the hull.
    assert {frozenset(f) for f in p.tables.faces.tolist()} == {frozenset(f) for f in faces.tolist()}
    assert np.abs(p.curvatures).max() < 1e-9
    # Moving the apex changes no curvature.
    scale = np.abs(p.coupling).max()
    assert np.abs(p.times_jacobian(vertices / radii[:, None])).max() < 1e-9 * max(scale, 1)


def test_the_signature_at_a_solution():
    vertices, faces = zoo.random_hull(30, 1)
    p = Polytope.over(tables_of(vertices, faces), np.linalg.norm(vertices - CENTER, axis=1))
    eigenvalues = np.linalg.eigvalsh(p.jacobian().toarray())
    small = np.abs(eigenvalues) < 1e-10 * np.abs(eigenvalues).max()
    assert (small.sum(), (eigenvalues[~small] > 0).sum()) == (3, 1)


def test_equal_radii_around_a_regular_body():
    # Around each of the 6 axes stand 4 pyramids with edges R, R, R over a triangle of side s.
    s, R = np.sqrt(2.0), 3.0
    p = Polytope.over(tables_of(*zoo.octahedron()), np.full(6, R))
    half = s / 2 / R  # sine of half the angle at the apex
    beta = 2 * np.arcsin(half)
    dihedral = np.arccos(np.cos(beta) / (1 + np.cos(beta)))
    assert p.curvatures == pytest.approx(np.full(6, 2 * np.pi - 4 * dihedral), abs=1e-13)
    assert p.lowest == pytest.approx((R**2 - s**2 / 3) / R**2, rel=1e-13)


@given(st.integers(6, 40), st.integers(0, 10**6), st.sampled_from([-4.0, -1.0, -1e-9, 1e-9, 1.0]))
def test_a_body_in_a_space_form_has_no_curvature_around_an_inner_point(n, seed, k):
    x, faces, _ = body(n, seed, k, 1.4)
    space, tables = Space(k), tables_in(x, faces, k)
    scramble(tables, 10 * n, np.random.default_rng(0))
    x = space.centered(x)
    radii = space.distances(x, np.zeros_like(x))
    p = Polytope.over(tables, radii)
    assert p is not None
    assert {frozenset(f) for f in p.tables.faces.tolist()} == {frozenset(f) for f in faces.tolist()}
    assert np.abs(p.curvatures).max() < 1e-9
    scale = np.abs(p.coupling).max()
    assert np.abs(p.times_jacobian(x / np.linalg.norm(x, axis=1)[:, None])).max() < 1e-9 * max(scale, 1)


@pytest.mark.parametrize("k", [-1.0, 1.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_derivative_in_a_space_form(k, scale):
    k /= scale**2
    x, faces, _ = body(25, 4, k, 1.6 * scale)
    tables, radii = tables_in(x, faces, k), 1.1 * Space(k).distances(x, np.zeros_like(x))
    p = Polytope.over(tables, radii)
    v = np.random.default_rng(0).normal(size=25) * radii
    step = 1e-6
    ahead, behind = (Polytope.on(p.tables, radii + sign * step * v) for sign in (1, -1))
    difference = (ahead.curvatures - behind.curvatures) / (2 * step)
    assert p.times_jacobian(v) == pytest.approx(difference, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(("k", "expected"), [(-1.0, -0.476136273196), (1.0, -0.319529495541)])
def test_the_change_of_a_dihedral_angle(k, expected):
    # Computed apart, from cot(theta) / (sn(l) sin(rho) sin(rho')), and by differences.
    lengths = np.array([0.5, 0.55, 0.45])
    faces, twins = np.array([[0, 1, 2], [0, 2, 1]]), np.array([5, 4, 3, 2, 1, 0])
    tables = HalfEdges.of(faces, twins, np.stack([lengths, lengths[::-1]]), k)
    p = Polytope.on(tables, np.array([0.7, 0.8, 0.75]))
    # Both pyramids have that angle, and the curvature is what they leave of a full turn.
    assert -p.coupling[0] / 2 == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("k", [-1e-6, -1e-12, 1e-12, 1e-6])
def test_polytopes_tend_to_those_of_euclidean_space(k):
    tables = tables_of(*zoo.random_hull(25, 4))
    radii = 2.0 * np.linalg.norm(zoo.random_hull(25, 4)[0] - CENTER, axis=1)
    flat, curved = Polytope.on(tables, radii), Polytope.on(tables._replace(curvature=k), radii)
    assert np.abs(curved.curvatures - flat.curvatures).max() < 10 * abs(k) + 1e-14
    assert np.abs(curved.coupling / flat.coupling - 1).max() < 1e3 * abs(k) + 1e-12


def test_a_polytope_that_was_kept_is_in_its_space():
    x, faces, _ = body(12, 0, -1.0, 1.4)
    p = Polytope.over(tables_in(x, faces, -1.0), np.full(12, 2.0))
    again = Polytope.of_arrays({name: np.asarray(value) for name, value in p.arrays().items()})
    assert again.space == Space(-1.0)
    assert (again.curvatures == p.curvatures).all()


def test_radii_beyond_the_antipode_or_the_floats():
    for k, radius in ((1.0, 3.2), (-1.0, 1e4)):
        x, faces, _ = body(12, 0, k, 1.4)
        assert Polytope.over(tables_in(x, faces, k), np.full(12, radius)) is None


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_derivative_is_that_of_the_curvatures(scale):
    vertices, faces = zoo.random_hull(25, 4)
    radii = 1.2 * np.linalg.norm(vertices - CENTER, axis=1) * scale
    tables = tables_of(vertices * scale, faces)
    p = Polytope.over(tables, radii)
    v = np.random.default_rng(0).normal(size=25) * radii
    step = 1e-6
    ahead, behind = (Polytope.on(p.tables, radii + sign * step * v) for sign in (1, -1))
    difference = (ahead.curvatures - behind.curvatures) / (2 * step)
    assert p.times_jacobian(v) == pytest.approx(difference, abs=1e-7)
    assert p.jacobian() @ v == pytest.approx(p.times_jacobian(v), abs=1e-12)
    assert p.times_jacobian(np.column_stack([v, 2 * v]))[:, 1] == pytest.approx(
        2 * p.times_jacobian(v), abs=1e-12
    )


def test_the_derivative_on_loops_and_repeated_edges():
    # A doubly covered polygon has few edges, which repeat when they are scrambled.
    outline = np.array([[0.0, 0], [3, 0], [2, 1], [0.5, 1.5]])
    tables = HalfEdges.of(*zoo.doubly_covered(outline))
    scramble(tables, 20, np.random.default_rng(3))
    pairs = np.sort(np.stack([tables.corners, tables.corners[tables.twins]], axis=1), axis=1)
    assert len(np.unique(pairs, axis=0)) < 6  # some edge repeats another or is a loop
    radii = np.array([40.0, 40.1, 39.9, 40.0])
    p = Polytope.on(tables, radii)
    v, step = np.array([0.3, -1.0, 0.5, 0.8]), 1e-6
    ahead, behind = (Polytope.on(tables, radii + sign * step * v) for sign in (1, -1))
    difference = (ahead.curvatures - behind.curvatures) / (2 * step)
    assert p.times_jacobian(v) == pytest.approx(difference, abs=1e-7)
    assert p.jacobian() @ v == pytest.approx(p.times_jacobian(v), abs=1e-13)


def test_what_is_no_polytope():
    vertices, faces = zoo.octahedron()
    tables = tables_of(vertices, faces)
    assert Polytope.over(tables, np.full(6, 0.5)) is None  # too short to reach over a triangle
    assert Polytope.over(tables, np.full(6, -2.0)) is None
    assert (
        Polytope.over(tables, np.array([9.0, 1, 1, 1, 1, 1])) is None
    )  # longer than the triangle inequality
    assert Polytope.over(tables, np.full(6, np.nan)) is None


def curvatures_by_cosines(tables, radii):
    """Those of the law of cosines, corner by corner."""

    def cosine(a, b, across):
        return (a * a + b * b - across * across) / (2 * a * b)

    kappa = np.full(radii.size, 2 * np.pi)
    for face, sides in zip(tables.faces, tables.face_lengths, strict=True):
        for c in range(3):
            i, j, k = np.roll(face, -c)
            a, b, third = np.roll(sides, -c)  # ij, jk, ki
            here, left, right = (
                cosine(a, third, b),
                cosine(radii[i], a, radii[j]),
                cosine(radii[i], third, radii[k]),
            )
            kappa[i] -= np.arccos((here - left * right) / np.sqrt((1 - left**2) * (1 - right**2)))
    return kappa


@pytest.mark.parametrize("n", [3, 7, 60, 700])
def test_angles_add_up_however_many_they_are(n):
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    tables = tables_of(*zoo.outward_hull(np.vstack([ring, [[0, 0, 0.4], [0, 0, -0.3]]])))
    radii = np.random.default_rng(n).uniform(3.0, 3.0 + 0.1 / n, n + 2)
    p = Polytope.on(tables, radii)
    assert p.curvatures == pytest.approx(curvatures_by_cosines(tables, radii), abs=1e-9)


def test_more_than_a_full_turn():
    tables = tables_of(*zoo.icosphere(2))
    lengths = np.ones(tables.corners.size)  # of six triangles, and of twelve after flips, about a vertex
    h = int(np.argmax(np.bincount(tables.corners)[tables.corners]))
    v = tables.corners[h]
    far = (tables.corners != v) & (tables.corners[tables.twins] != v)
    lengths[far & np.repeat((tables.faces == v).any(axis=1), 3)] = 1.5
    lengths = np.maximum(lengths, lengths[tables.twins])
    tables, radii = tables._replace(lengths=lengths), np.full(tables.corners.max() + 1, 5.0)
    p = Polytope.on(tables, radii)
    assert p.curvatures.min() < -0.5
    assert p.curvatures == pytest.approx(curvatures_by_cosines(tables, radii), abs=1e-12)
