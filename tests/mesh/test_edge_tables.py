"""Edges in linear time: the tables are those of the slow way, and nothing but a sphere has any."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.mesh.checks import checked_tables
from isoembed.mesh.edge_tables import edge_tables


def bipyramid(n):
    """Two tips over a polygon: their edges are many."""
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    return np.concatenate(
        [np.stack([i, j, np.full(n, n)], axis=1), np.stack([j, i, np.full(n, n + 1)], axis=1)]
    )


def assert_joined(faces):
    found = edge_tables(faces)
    assert found is not None
    for table, expected in zip(found, checked_tables(faces), strict=True):
        assert table.dtype == expected.dtype == np.int64
        np.testing.assert_array_equal(table, expected)


@given(n=st.integers(4, 80), seed=st.integers(0, 10**6))
def test_tables_are_those_of_the_checked_way(n, seed):
    assert_joined(zoo.relabeled(*zoo.random_hull(n, seed), seed)[1])


@pytest.mark.parametrize(
    "faces", [zoo.TETRAHEDRON, np.array([[0, 1, 2], [2, 1, 0]]), bipyramid(3000)], ids=["4", "2", "hub"]
)
def test_the_smallest_spheres_and_hubs(faces):
    assert_joined(faces)


T, TORUS = zoo.TETRAHEDRON, zoo.torus()
SPHERE = zoo.icosphere(1)[1]
OCTAHEDRON = np.array([[i, j, k] for k in (4, 5) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))])
OCTAHEDRON[4:] = OCTAHEDRON[4:, ::-1]
# Two tetrahedra on one edge, in an order in which each half-edge there is followed by one of the other's.
ON_AN_EDGE = np.array(
    [[0, 1, 2], [1, 0, 4], [1, 0, 3], [0, 1, 5], [0, 2, 3], [1, 3, 2], [0, 5, 4], [1, 4, 5]]
)
NO_SPHERES = {
    "hole": SPHERE[1:],
    "face turned": np.concatenate([SPHERE[:1, ::-1], SPHERE[1:]]),
    "face twice": np.concatenate([SPHERE, SPHERE[3:4]]),
    "face twice, turned": np.concatenate([SPHERE, SPHERE[3:4, ::-1]]),
    "vertex twice": np.concatenate([SPHERE[1:], [[0, 0, 1]]]),
    "gap": np.where(SPHERE == 41, 42, SPHERE),
    "far gap": np.where(SPHERE == 41, 2**61, SPHERE),
    "fin": np.concatenate([T, [[0, 1, 4]]]),
    "torus": TORUS,
    "projective plane": zoo.projective_plane(),
    "Klein bottle": zoo.klein_bottle(),
    "pinched": np.concatenate([T, np.where(T == 0, 0, T + 3)]),
    "two components": np.concatenate([T, T + 4]),
    # These have as many vertices and faces as a sphere.
    "hole and handle": np.concatenate([TORUS[2:], [[0, 1, 20], [1, 0, 21]]]),
    "sphere and torus": np.concatenate([T, TORUS + 4]),
    "pinched twice": np.concatenate([OCTAHEDRON, np.where(OCTAHEDRON < 4, OCTAHEDRON + 6, OCTAHEDRON)]),
    "loops": np.array([[0, 0, 1], [0, 0, 2]]),
    "torus and two gaps": np.where(TORUS == 19, 21, TORUS),
    "two edges for one": ON_AN_EDGE,
    "one vertex for two": np.concatenate([SPHERE[:-1], [[0, 1, 2]]]),
}


@pytest.mark.parametrize("faces", NO_SPHERES.values(), ids=NO_SPHERES)
def test_what_is_no_sphere_is_left_to_the_checks(faces):
    assert edge_tables(np.ascontiguousarray(faces)) is None
