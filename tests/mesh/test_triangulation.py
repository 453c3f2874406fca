"""Triangulations: the incidence tables, and one clear sentence for everything that is no sphere."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.errors import InvalidMetric, MeshNote
from isoembed.mesh.triangulation import Triangulation

T = zoo.TETRAHEDRON.tolist()


def with_last(face):
    return [*T[:3], face]


# ---------------------------------------------------------------- tables


def test_tetrahedron_by_hand():
    t = Triangulation(T)
    assert t.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    assert t.face_edges.tolist() == [[0, 3, 1], [1, 5, 2], [2, 4, 0], [4, 5, 3]]
    assert t.edge_halfedges[0].tolist() == [0, 8]  # 0 -> 1 in face 0, 1 -> 0 in face 2
    assert t.edge_faces[0].tolist() == [0, 2]
    assert zoo.edge_opposites(t)[0].tolist() == [2, 3]
    assert t.degrees.tolist() == [3, 3, 3, 3]
    assert (t.adjacency.toarray() == 1 - np.eye(4)).all()
    assert repr(t) == "Triangulation(4 vertices, 6 edges, 4 faces)"


@given(n=st.integers(5, 60), seed=st.integers(0, 10**6))
def test_tables_agree_with_loops_over_the_faces(n, seed):
    _, faces = zoo.random_hull(n, seed)
    t = Triangulation(faces)
    assert (t.n_vertices, t.n_edges, t.n_faces) == (n, 3 * n - 6, 2 * n - 4)
    number = {tuple(edge): k for k, edge in enumerate(t.edges.tolist())}
    assert list(number) == sorted(number)
    neighbors = [set() for _ in range(n)]
    for f, face in enumerate(faces.tolist()):
        for c in range(3):
            i, j, k = face[c], face[(c + 1) % 3], face[(c + 2) % 3]
            e, side = number[min(i, j), max(i, j)], int(i > j)
            assert t.face_edges[f, c] == e
            assert t.edge_halfedges[e, side] == 3 * f + c
            assert t.edge_faces[e, side] == f
            assert zoo.edge_opposites(t)[e, side] == k
            neighbors[i].add(j)
    assert t.degrees.tolist() == [len(around) for around in neighbors]
    for i, around in enumerate(neighbors):
        row = t.adjacency.indices[t.adjacency.indptr[i] : t.adjacency.indptr[i + 1]]
        assert set(row.tolist()) == around


@given(seed=st.integers(0, 10**6))
def test_relabeling_renames_and_nothing_else(seed):
    vertices, faces = zoo.random_hull(30, seed)
    _, other, new = zoo.relabeled(vertices, faces, seed)
    t, s = Triangulation(faces), Triangulation(other)
    assert np.array_equal(np.unique(np.sort(new[t.edges], axis=1), axis=0), s.edges)
    assert np.array_equal(t.degrees, s.degrees[new])
    index = s.edge_indices(new[t.edges])
    assert np.array_equal(
        np.sort(new[zoo.edge_opposites(t)], axis=1), np.sort(zoo.edge_opposites(s)[index], axis=1)
    )


def test_reversed_orientation_exchanges_left_and_right():
    _, faces = zoo.icosphere(1)
    t, s = Triangulation(faces), Triangulation(faces[:, ::-1])
    assert np.array_equal(t.edges, s.edges)
    assert np.array_equal(t.edge_faces, s.edge_faces[:, ::-1])
    assert np.array_equal(zoo.edge_opposites(t), zoo.edge_opposites(s)[:, ::-1])


def test_edge_indices_of_pairs_in_any_order_and_of_strangers():
    t = Triangulation(zoo.octahedron()[1])
    backward = t.edges[:, ::-1]
    assert np.array_equal(t.edge_indices(backward), np.arange(t.n_edges))
    opposite = [v for v in range(1, 6) if [0, v] not in t.edges.tolist()]
    assert t.edge_indices(np.array([[0, opposite[0]], [3, 3], [2, 10**18]])).tolist() == [-1, -1, -1]


@pytest.mark.parametrize(
    "faces",
    [
        np.array(T, dtype=float),
        np.array(T, dtype=np.uint8),
        np.asfortranarray(T),
        tuple(map(tuple, T)),
        [np.array(face) for face in T],
    ],
    ids=["whole floats", "uint8", "fortran", "tuples", "list of arrays"],
)
def test_other_containers_and_number_types_are_fine(faces):
    t = Triangulation(faces)
    assert t.faces.dtype == np.int64
    assert t.faces.tolist() == T


def test_tables_are_read_only_and_the_input_is_left_alone():
    faces = np.array(T)
    t = Triangulation(faces)
    for table in (
        t.faces,
        t.edges,
        t.face_edges,
        t.edge_halfedges,
        t.edge_faces,
        t.degrees,
    ):
        with pytest.raises(ValueError, match="read-only"):
            table[0] = 0
    faces[0, 0] = 3
    assert t.faces.tolist() == T
    with pytest.raises(AttributeError):
        t.faces = faces


# ---------------------------------------------------------------- refusals

FLIPPED = zoo.icosphere(1)[1].copy()
FLIPPED[7] = FLIPPED[7][::-1]
OPEN = np.delete(zoo.icosphere(1)[1], 11, axis=0)

REFUSALS = {
    "empty": ([], "there are no faces"),
    "empty array": (np.empty((0, 3)), "there are no faces"),
    "quads": ([[0, 1, 2, 3]] * 3, "face 0 has 4 corners [0, 1, 2, 3], not 3"),
    "quads in an array": (np.arange(8).reshape(2, 4), "face 0 has 4 corners [0, 1, 2, 3], not 3"),
    "ragged": ([[0, 1, 2], [0, 2, 3], [0, 3]], "face 2 has 2 corners [0, 3], not 3"),
    "one-dimensional": (np.arange(6), "the faces have shape (6,), not (n, 3)"),
    "negative": (with_last([1, 3, -2]), "face 3 refers to vertex -2: vertex indices must not be negative"),
    "fraction": (with_last([1, 2.5, 3]), "face 3 refers to vertex 2.5: vertex indices must be whole numbers"),
    "nan": (with_last([1, float("nan"), 3]), "face 3 refers to vertex nan: vertex indices must be whole"),
    "inf": (with_last([1, float("inf"), 3]), "face 3 refers to vertex inf: vertex indices must be whole"),
    "huge": (
        with_last([1, 10**18, 3]),
        "vertex 4 is in no face, while face 3 refers to vertex 1000000000000000000",
    ),
    "strings": ([["0", "1", "2"]] * 4, "face 0 refers to vertex '0': vertex indices must be whole numbers"),
    "string in a later row": (
        with_last([1, "3", 2]),
        "face 3 refers to vertex '3': vertex indices must be whole numbers",
    ),
    "beyond int64": (with_last([1, 10**30, 3]), f"face 3 refers to vertex {10**30}: the index is too large"),
    "a number": (5, "the faces"),
    "nothing": (None, "the faces"),
    "repeated corner": (with_last([1, 3, 3]), "face 3 [1, 3, 3] repeats a vertex"),
    "repeated face": ([*T, T[1]], "face 4 [0, 2, 3] repeats face 1"),
    "repeated face, turned and reversed": ([*T, [3, 2, 0]], "face 4 [3, 2, 0] repeats face 1"),
    "gap": (np.where(zoo.TETRAHEDRON == 2, 5, T), "vertex 2 is in no face, while face 0 refers to vertex 5"),
    "numbered from one": (zoo.TETRAHEDRON + 1, "vertex 0 is in no face, while face 1 refers to vertex 4"),
    "three faces at an edge": ([*T, [0, 1, 4]], "edge [0, 1] is in 3 faces [0, 2, 4], not in 2"),
    "projective plane": (zoo.projective_plane(), "the surface cannot be oriented (it is one-sided)"),
    "Klein bottle": (zoo.klein_bottle(), "the surface cannot be oriented (it is one-sided)"),
    "two components": (
        np.vstack([T, zoo.TETRAHEDRON + 4]),
        "the surface has 2 components, which must be embedded separately: vertex 4 is not connected to",
    ),
    "pinched": (
        np.vstack([T, np.array([4, 5, 6, 2])[zoo.TETRAHEDRON]]),
        "the faces around vertex 2 form more than one fan: the surface is not a manifold",
    ),
    "two pinches": (  # Euler characteristic 2, yet no sphere
        np.vstack([zoo.torus(), np.where(zoo.TETRAHEDRON == 0, 3, zoo.TETRAHEDRON + 19)]),
        "the faces around vertex 3 form more than one fan: the surface is not a manifold",
    ),
}


@pytest.mark.parametrize(("faces", "sentence"), REFUSALS.values(), ids=REFUSALS.keys())
def test_refusals_name_the_first_offender(faces, sentence):
    with pytest.raises(InvalidMetric, match=re.escape(sentence)) as refusal:
        Triangulation(faces)
    assert isinstance(refusal.value, ValueError)
    assert "\n" not in str(refusal.value)


def test_a_face_that_runs_the_other_way_is_turned_over():
    with pytest.warns(MeshNote, match=r"^1 of 80 faces are reversed.* the first is face 7 \["):
        turned = Triangulation(FLIPPED)
    whole = Triangulation(zoo.icosphere(1)[1])
    assert [set(face) for face in turned.faces.tolist()] == [set(face) for face in whole.faces.tolist()]
    assert np.array_equal(turned.edges, whole.edges)
    assert np.array_equal(np.sort(turned.edge_faces), np.sort(whole.edge_faces))


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
@pytest.mark.parametrize("seed", range(5))
def test_any_orientations_are_those_of_face_0(seed):
    faces = zoo.icosphere(1)[1]
    flip = np.random.default_rng(seed).random(len(faces)) < 0.5
    turned = Triangulation(np.where(flip[:, None], faces[:, ::-1], faces)).faces
    expected = faces[:, ::-1] if flip[0] else faces

    def cycles(table):
        return sorted(tuple(np.roll(face, -np.argmin(face))) for face in table)

    assert cycles(turned) == cycles(expected)


def test_given_faces_are_not_changed():
    faces = FLIPPED.copy()
    with pytest.warns(MeshNote):
        Triangulation(faces)
    assert np.array_equal(faces, FLIPPED)


def test_surfaces_with_boundary_and_handles_are_no_spheres():
    disc, torus, holed = Triangulation(T[:3]), Triangulation(zoo.torus()), Triangulation(OPEN)
    assert [t.is_sphere for t in (disc, torus, holed, Triangulation(T))] == [False, False, False, True]
    assert [t.genus for t in (disc, torus, holed)] == [0, 1, 0]
    assert [t.euler_characteristic for t in (disc, torus, holed)] == [1, 0, 1]
    assert [loop.tolist() for loop in disc.boundaries] == [[1, 2, 3]]
    assert torus.boundaries == ()
    assert disc.boundary_vertices.tolist() == [False, True, True, True]
    sentence = r"edge \[1, 2\] is in face 0 only \(3 such boundary edges\): the surface is not closed"
    for refused in (disc.check_sphere, lambda: disc.twins, lambda: disc.edge_faces):
        with pytest.raises(InvalidMetric, match=sentence):
            refused()
    with pytest.raises(InvalidMetric, match="Euler characteristic 0 \\(genus 1\\), not 2: not a sphere"):
        torus.check_sphere()
    with pytest.raises(InvalidMetric, match="3 such boundary edges"):
        holed.check_sphere()


@pytest.mark.parametrize(
    ("missing", "clause"),
    [
        ([11], r"; the face \[0, 5, 2\] may be missing"),
        ([11, 12], r"; 2 faces may be missing .*\[0, 5, 2, 4\], with the edge \[0, 2\] or \[5, 4\]"),
        ([11, 12, 10], r"; 3 faces may be missing between the vertices \[0, 5, 2, 4, 8\]"),
        ([10, 11, 12, 13], ""),  # a boundary along half of the vertices
    ],
)
def test_small_holes_may_be_missing_faces(missing, clause):
    faces = np.delete(zoo.icosahedron()[1], missing, axis=0)
    with pytest.raises(InvalidMetric, match=rf"the surface is not closed{clause}$"):
        Triangulation(faces).check_sphere()


def test_sides_of_a_boundary():
    disc = Triangulation(T[:3])
    assert (disc.edge_sides < 0).sum() == 3
    assert (disc.sides_across < 0).sum() == 3
    inner = np.flatnonzero(disc.sides_across >= 0)
    np.testing.assert_array_equal(disc.sides_across[disc.sides_across[inner]], inner)
    assert (disc.edge_flanks >= 0).all()


@given(seed=st.integers(0, 10**6))
def test_any_single_corner_changed_is_refused(seed):
    _, faces = zoo.random_hull(20, seed)
    rng = np.random.default_rng(seed)
    spoiled = faces.copy()
    f, c = rng.integers(len(faces)), rng.integers(3)
    spoiled[f, c] = (spoiled[f, c] + rng.integers(1, 20)) % 20
    with pytest.raises(InvalidMetric):
        Triangulation(spoiled)
