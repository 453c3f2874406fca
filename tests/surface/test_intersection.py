"""Self-intersections: known cases, a linear program as the second opinion, invariances, cost."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

import zoo
from isoembed.surface.intersection import self_intersections


def by_linear_program(faces, vertices):
    """Maximize the weight that a common point puts on the corners of face i that face j does not have."""
    found = []
    for i in range(len(faces)):
        for j in range(i + 1, len(faces)):
            own = ~np.isin(faces[i], faces[j])
            equal = np.zeros((5, 6))  # sum lambda a = sum mu b, sum lambda = sum mu = 1
            equal[:3] = np.hstack([vertices[faces[i]].T, -vertices[faces[j]].T])
            equal[3, :3] = equal[4, 3:] = 1
            goal = np.concatenate([-own.astype(float), np.zeros(3)])
            best = linprog(goal, A_eq=equal, b_eq=[0, 0, 0, 1, 1], bounds=(0, None))
            if best.status == 0 and (own.all() or -best.fun > 1e-7):
                found.append((i, j))
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def areas(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


@pytest.mark.parametrize("seed", range(4))
def test_random_tangles_against_linear_programs(seed):
    _, faces = zoo.random_hull(12, seed)
    vertices = np.random.default_rng([seed, 1]).normal(size=(12, 3))
    expected = by_linear_program(faces, vertices)
    assert len(expected) > 10
    assert np.array_equal(self_intersections(faces, vertices), expected)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 6])
def test_tangles_on_a_grid_with_contacts_and_coplanar_triangles(seed):
    _, faces = zoo.random_hull(12, seed)
    rng = np.random.default_rng(seed)
    vertices = rng.integers(-2, 3, size=(12, 3)).astype(float)
    while areas(vertices, faces).min() == 0:
        vertices = rng.integers(-2, 3, size=(12, 3)).astype(float)
    expected = by_linear_program(faces, vertices)
    assert np.array_equal(self_intersections(faces, vertices), expected)
    turned = vertices @ zoo.rotation(seed).T  # contact stays contact where coordinates are rounded
    assert np.array_equal(self_intersections(faces, turned), expected)


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [zoo.tetrahedron(), zoo.cube(), zoo.icosphere(2), zoo.random_hull(300, 0)],
    ids=["tetrahedron", "cube", "icosphere", "random hull"],
)
def test_convex_surfaces_have_none(vertices, faces):
    assert self_intersections(faces, vertices).shape == (0, 2)


def test_flat_subdivided_faces_have_none():
    vertices, faces = zoo.subdivided(*zoo.subdivided(*zoo.cube()))
    assert len(self_intersections(faces, vertices @ zoo.rotation(3).T)) == 0


@pytest.mark.parametrize(("radius", "meet"), [(1.5, False), (1.15, True)])
def test_a_sausage_bent_into_a_ring(radius, meet):
    sphere, faces = zoo.icosphere(3)
    x, y, z = (sphere * [4, 0.5, 0.5]).T
    distance = radius + z
    bent = np.column_stack([distance * np.sin(x / radius), y, distance * np.cos(x / radius)])
    pairs = self_intersections(faces, bent)
    assert (len(pairs) > 10) == meet
    ends = sphere[faces].mean(axis=1)[:, 0][pairs]
    assert (ends.min(axis=1) < -0.8).all()  # one end with the other
    assert (ends.max(axis=1) > 0.8).all()


def test_a_vertex_pulled_through_the_far_side():
    vertices, faces = zoo.icosphere(2)
    vertices[0] *= -1.5
    pairs = self_intersections(faces, vertices)
    spike = (faces == 0).any(axis=1)
    assert len(pairs) > 0
    assert spike[pairs].any(axis=1).all()


def test_triangles_that_share_one_corner():
    base = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    faces = [[0, 1, 2], [0, 3, 4]]
    for others, meets in [
        ([[0.3, 0.3, -1], [0.3, 0.3, 1]], True),  # through
        ([[3, 3, -9], [3, 3, 9]], True),  # through, the far edge misses
        ([[-1, -1, -1], [-1, -1, 1]], False),  # behind
        ([[0.3, 0.3, 1], [0.3, 0.3, 2]], False),  # above
        ([[0.5, 0.5, 0], [0.5, 0.5, 1]], True),  # standing on it
        ([[2, 0, 0], [1, -1, 0]], True),  # coplanar, along an edge
        ([[0.2, 0.5, 0], [-1, 1, 0]], True),  # coplanar, overlapping
        ([[-1, 0, 0], [0, -1, 0]], False),  # coplanar, edges in line
        ([[-1, 0, 0], [-1, 0, 1]], False),  # an edge in line, out of the plane
    ]:
        vertices = np.vstack([base, others])
        assert len(self_intersections(faces, vertices)) == meets, others
        assert len(self_intersections(faces[::-1], vertices)) == meets, others


def test_triangles_that_share_an_edge_only_meet_when_folded_flat():
    faces = [[0, 1, 2], [1, 0, 3]]
    for apex, folded in [([0.9, 0.2, 0], True), ([0.9, 0.2, 1e-6], False), ([0.5, -1, 0], False)]:
        vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0.2, 1, 0], apex]) @ zoo.rotation(0).T
        assert len(self_intersections(faces, vertices)) == folded, apex


def test_a_doubly_covered_polygon():
    angle = 2 * np.pi * np.arange(5) / 5
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    vertices = np.vstack([rim, [[0.0, 0, 0], [0.1, 0.05, 0]]]) @ zoo.rotation(1).T
    fans = [[[i, (i + 1) % 5, 5], [(i + 1) % 5, i, 6]] for i in range(5)]
    faces = np.concatenate(fans)
    assert np.array_equal(self_intersections(faces, vertices), by_linear_program(faces, vertices))


def test_the_same_triangle_twice_and_no_triangle():
    vertices = np.eye(3)
    assert self_intersections([[0, 1, 2], [1, 0, 2]], vertices).tolist() == [[0, 1]]
    assert self_intersections([[0, 1, 2]], vertices).shape == (0, 2)
    assert self_intersections(np.empty((0, 3), int), vertices).shape == (0, 2)


def test_long_needles_do_not_meet():
    for seed in range(3):
        vertices, faces = zoo.random_hull(2000, seed)
        vertices[0] *= 50  # still star-shaped
        assert len(self_intersections(faces, vertices)) == 0


@given(seed=st.integers(0, 10**6), exponent=st.integers(-200, 200))
def test_rigid_motions_scales_mirrors_and_labels_change_nothing(seed, exponent):
    _, faces = zoo.random_hull(20, seed)
    vertices = np.random.default_rng([seed, 1]).normal(size=(20, 3))
    pairs = self_intersections(faces, vertices)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    moved = vertices @ zoo.rotation(seed).T + [5.0, -3.0, 11.0]
    assert np.array_equal(self_intersections(faces, moved), pairs)
    assert np.array_equal(self_intersections(faces, vertices * [1, 1, -1] * 10.0**exponent), pairs)
    points, other, new = zoo.relabeled(vertices, faces, seed)
    corners = {frozenset(new[face]): k for k, face in enumerate(faces)}
    old = np.array([corners[frozenset(face)] for face in other])
    back = np.sort(old[self_intersections(other, points)], axis=1)
    assert {tuple(pair) for pair in back} == {tuple(pair) for pair in pairs}


def test_memory_stays_bounded_on_a_large_surface_with_one_huge_spike():
    vertices, faces = zoo.random_hull(6000, 0)
    vertices[0] *= -50
    tracemalloc.start()
    pairs = self_intersections(faces, vertices)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    spike = (faces == 0).any(axis=1)
    assert len(pairs) > 0
    assert spike[pairs].any(axis=1).all()
    assert peak < 300e6


def test_a_reach_counts_as_contact():
    lower = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    upper = lower + np.array([0, 0, 1e-3])
    vertices, faces = np.vstack([lower, upper]), [[0, 1, 2], [3, 4, 5]]
    assert len(self_intersections(faces, vertices)) == 0
    assert len(self_intersections(faces, vertices, 0.49e-3)) == 0
    assert self_intersections(faces, vertices, 0.51e-3).tolist() == [[0, 1]]


@given(st.integers(0, 10**6), st.sampled_from([1e-9, 1e-4, 1e-2]))
def test_what_does_not_intersect_within_reach_does_not_after_moves(seed, reach):
    """Pairs that share no corner, one or two, some of them nearly folded."""
    rng = np.random.default_rng(seed)
    for shared in range(3):
        vertices = rng.normal(size=(6 - shared, 3)) * [1, 1, 10.0 ** -rng.integers(0, 5)]
        faces = [[0, 1, 2], [[3, 4, 5], [0, 3, 4], [1, 0, 3]][shared]]
        if len(self_intersections(faces, vertices, reach)):
            continue
        for _ in range(20):
            moves = rng.normal(size=vertices.shape)
            moves *= reach / np.linalg.norm(moves, axis=1, keepdims=True)
            assert len(self_intersections(faces, vertices + moves)) == 0
