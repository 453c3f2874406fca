"""Bounds on what motions of vertices do to triangles, against motions drawn at random."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.proof.length_equations import NotProven
from isoembed.proof.moved_triangles import MovedTriangles
from isoembed.surface import curvature, measures
from noisy import normals


@given(st.integers(0, 10**6), st.floats(-8, -0.5))
def test_nothing_moves_farther(seed, exponent):
    rng, size = np.random.default_rng(seed), 10**exponent
    x, faces = zoo.icosahedron()
    t, x = Triangulation(faces), x * rng.uniform(0.5, 1.5, 3) + rng.uniform(-0.1, 0.1, x.shape)
    shares = rng.uniform(0.1, 1, len(x))
    steps, d = (rng.standard_normal(x.shape) for _ in range(2))
    steps *= size * rng.uniform(0, 1, (len(x), 1))
    radius = size * rng.uniform(0, 1)
    d *= radius / np.linalg.norm(d / shares[:, None])
    moved = MovedTriangles(t, x, np.linalg.norm(steps, axis=1), shares, radius)
    y = x + steps + d
    assert (np.linalg.norm(y - x, axis=1) <= moved.far + 1e-15).all()
    n, m = normals(faces, x), normals(faces, y)
    turned = np.arctan2(np.linalg.norm(np.cross(n, m), axis=1), np.einsum("ij,ij->i", n, m))
    assert (turned <= moved.turns).all()
    bent = curvature.dihedral_angles(t, y) - curvature.dihedral_angles(t, x)
    assert (np.abs(bent) <= moved.bends)[~moved.may_jump].all()
    squares = [measures.edge_lengths(t.edges, z) ** 2 for z in (x, y)]
    grown = np.abs(measures.face_areas(faces, y) - moved.areas)
    assert (grown <= moved.area_changes(np.abs(squares[1] - squares[0]) + 1e-15)).all()


def test_turns_are_nearly_attained():
    """Two corners of an equilateral triangle move up, the third one moves down."""
    x, faces = zoo.tetrahedron()
    t, [n, *_] = Triangulation(faces), normals(faces, x)
    shares = np.ones(len(x))
    moved = MovedTriangles(t, x, np.zeros(len(x)), shares, 1e-6)
    d = np.zeros_like(x)
    d[faces[0]] = np.outer([1, 1, -2], n)
    y = x + 1e-6 * d / np.linalg.norm(d)
    turned = np.linalg.norm(normals(faces, y)[0] - n)
    assert 0.999 < turned / moved.turns[0] < 1


def test_area_changes_are_nearly_attained():
    x, faces = zoo.tetrahedron()
    t = Triangulation(faces)
    lengths = measures.edge_lengths(t.edges, x)
    changes = MovedTriangles(t, x, np.zeros(4), np.ones(4), 0.0).area_changes(2e-6 * lengths**2)
    assert np.allclose(changes, 2e-6 * measures.face_areas(faces, x), rtol=1e-4)


def test_folds_may_jump_and_low_triangles_are_refused():
    x, faces = zoo.tetrahedron()
    flat = x * [1, 1, 1e-3]
    t = Triangulation(faces)
    assert MovedTriangles(t, flat, np.full(4, 0.1), np.ones(4), 0.0).may_jump.any()
    assert not MovedTriangles(t, x, np.zeros(4), np.ones(4), 1e-3).may_jump.any()
    needle = x.copy()
    needle[faces[0, 2]] = (x[faces[0, 0]] + x[faces[0, 1]]) / 2 + 1e-12
    with pytest.raises(NotProven, match=r"face \d \[.*\] is too low for floats"):
        _ = MovedTriangles(t, needle, np.zeros(4), np.ones(4), 0.0).turns
