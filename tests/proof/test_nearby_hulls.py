"""What is said of the hulls of near points, against those hulls; every reason for which it is not said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.proof.nearby_hulls import NotProven, prove_nearby_hulls
from isoembed.proof.polygonal_cells import Cells
from isoembed.surface.curvature import dihedral_angles


def prism(n, height=1.0, twist=0.0):
    t = 2 * np.pi * np.arange(n) / n
    ends = [np.column_stack([np.cos(s), np.sin(s), 0 * s + z]) for s, z in ((t, 0.0), (t + twist, height))]
    return zoo.outward_hull(np.vstack(ends))


BODIES = [
    zoo.tetrahedron(),
    zoo.cube(),
    zoo.icosahedron(),
    zoo.random_hull(40, 1),
    prism(5),
    prism(24),
    prism(7, 0.3, 0.2),
]


def proven(vertices, faces, reach):
    return prove_nearby_hulls(Triangulation(faces), vertices, reach)


def refusal(vertices, faces, reach):
    with pytest.raises(NotProven) as caught:
        proven(vertices, faces, reach)
    return str(caught.value)


@given(st.sampled_from(BODIES), st.sampled_from([1e-12, 1e-8, 1e-5]), st.integers(0, 10**6))
def test_the_hulls_of_near_points_have_these_faces(body, reach, seed):
    vertices, faces = body
    triangulation = Triangulation(faces)
    hulls = proven(vertices, faces, reach)
    cells = Cells.across(triangulation, hulls.flat)
    corners = [set(faces[cells.labels == c].ravel().tolist()) for c in range(len(cells.first))]
    moves = np.random.default_rng(seed).normal(size=vertices.shape)
    near = vertices + reach * moves / np.linalg.norm(moves, axis=1)[:, None]
    hull = ConvexHull(near)
    assert len(hull.vertices) == len(vertices)
    for triangle in hull.simplices.tolist():
        assert any(set(triangle) <= polygon for polygon in corners)
    angles = dihedral_angles(triangulation, near)
    assert hulls.dihedrals.min() <= angles[~hulls.flat].min()


@given(
    st.sampled_from([zoo.cube(), prism(5), prism(24)]), st.sampled_from([1e-9, 1e-4]), st.integers(0, 10**6)
)
def test_the_faces_of_near_hulls_tilt_by_no_more_than_the_slopes(body, reach, seed):
    vertices, faces = body
    triangulation = Triangulation(faces)
    hulls = proven(vertices, faces, reach)
    labels = Cells.across(triangulation, hulls.flat).labels
    near = vertices + reach / 3**0.5 * np.random.default_rng(seed).choice([-1.0, 1.0], size=vertices.shape)
    before, after = ConvexHull(vertices), ConvexHull(near)
    for e in np.flatnonzero(hulls.flat):
        corners = set(faces[labels == labels[triangulation.edge_faces[e, 0]]].ravel().tolist())
        normals, tilted = (
            hull.equations[[set(triangle) <= corners for triangle in hull.simplices.tolist()], :3]
            for hull in (before, after)
        )
        sines = np.linalg.norm(np.cross(tilted, normals[0]), axis=1)
        assert sines.max() <= hulls.slopes[e] + 1e-14
        assert hulls.slopes[e] < 1000 * reach


@given(st.sampled_from([1e-6, 1e-4, 1e-2]), st.integers(0, 10**6))
def test_the_paths_that_replace_diagonals_are_hardly_longer(reach, seed):
    vertices, faces = zoo.cube()
    triangulation = Triangulation(faces)
    hulls = proven(vertices, faces, reach)
    near = vertices + reach / 3**0.5 * np.random.default_rng(seed).choice([-1.0, 1.0], size=vertices.shape)
    on_hull = {
        frozenset(triangle[:k] + triangle[k + 1 :])
        for triangle in ConvexHull(near).simplices.tolist()
        for k in range(3)
    }
    for e in np.flatnonzero(hulls.flat):
        ends, (c, d) = near[triangulation.edges[e]], near[zoo.edge_opposites(triangulation)[e]]
        if (
            frozenset(zoo.edge_opposites(triangulation)[e].tolist()) in on_hull
        ):  # a fold along the other diagonal
            axis = (d - c) / np.linalg.norm(d - c)
            along = (ends - c) @ axis
            aside = np.linalg.norm(ends - c - along[:, None] * axis, axis=1)
            straight = np.hypot(along[0] - along[1], aside.sum())
            chord = np.linalg.norm(ends[0] - ends[1])
            assert chord * (1 - 1e-15) <= straight <= chord * (1 + 1e-15) * np.hypot(1.0, hulls.slopes[e])


def test_the_diagonals_of_polygons_are_flat():
    assert proven(*zoo.cube(), 1e-12).flat.sum() == 6
    assert proven(*prism(24), 1e-12).flat.sum() == 24 + 2 * 21
    assert not proven(*zoo.icosahedron(), 1e-12).flat.any()


def test_bounds_on_dihedral_angles_are_their_sines_at_no_distance():
    vertices, faces = zoo.random_hull(30, 2)
    angles = dihedral_angles(Triangulation(faces), vertices)
    assert proven(vertices, faces, 0.0).dihedrals.min() == pytest.approx(np.sin(angles).min(), rel=1e-9)


@pytest.mark.parametrize("reach", [1e-12, 1e-3])
def test_a_pushed_in_vertex_is_concave(reach):
    vertices, faces = zoo.octahedron()
    top = int(np.argmax(vertices[:, 2]))
    vertices[top, 2] = -0.5
    message = refusal(vertices, faces, reach)
    assert message.startswith("edge ")
    assert f"{top}]" in message or f"[{top}," in message
    assert "is concave: its exterior angle has the sine -" in message


def test_inside_out():
    vertices, faces = zoo.icosahedron()
    assert "is concave" in refusal(vertices, faces[:, ::-1], 1e-12)


def test_across_a_polygon_that_is_hardly_dented_the_hull_has_the_other_diagonal():
    vertices, faces = prism(4)
    flat = proven(vertices, faces, 1e-12).flat
    e = int(np.argmax(flat))
    a, b = Triangulation(faces).edges[e]
    dented = vertices.copy()
    dented[a] *= 1 - 1e-6
    for reach in (1e-5, 1e-12):
        assert proven(dented, faces, reach).flat[e]
    hull = ConvexHull(dented).simplices
    assert not ((hull == a).any(axis=1) & (hull == b).any(axis=1)).any()
    dented[a] = vertices[a] * (1 - 1e-2)
    assert f"edge {e} {[int(a), int(b)]} is concave" in refusal(dented, faces, 1e-12)


def test_a_vertex_in_the_middle_of_a_face():
    vertices, faces = zoo.octahedron()
    center = len(vertices)
    vertices = np.vstack([vertices, vertices[faces[0]].mean(axis=0)])
    a, b, c = faces[0]
    faces = np.vstack([faces[1:], [[a, b, center], [b, c, center], [c, a, center]]])
    assert refusal(vertices, faces, 1e-12) == f"vertex {center} may be flat: so may all its edges"


def test_a_vertex_in_the_middle_of_an_edge():
    vertices, faces = zoo.tetrahedron()
    triangulation = Triangulation(faces)
    (a, b), (left, right) = triangulation.edges[0], triangulation.edge_faces[0]
    p, q = zoo.edge_opposites(triangulation)[0]
    middle = len(vertices)
    vertices = np.vstack([vertices, vertices[[a, b]].mean(axis=0)])
    faces = np.vstack([np.delete(faces, [left, right], axis=0),
                       [[a, middle, p], [middle, b, p], [b, middle, q], [middle, a, q]]])  # fmt: skip
    message = refusal(vertices, faces, 1e-12)
    assert message.startswith(f"vertex {middle} may be on a line with ")


def test_a_ring_of_faces_that_may_be_in_one_plane():
    message = refusal(*prism(60, 0.2, np.pi / 60), 1e-3)
    assert message.endswith("do not form a polygon")


def test_a_polygon_that_may_not_be_convex():
    points = np.random.default_rng(0).normal(size=(8, 3)) * [1, 1, 1e-3]
    assert refusal(*zoo.outward_hull(points), 1e-5).endswith("may not be convex")


def test_a_face_that_may_not_be_visible_from_within():
    assert "may not be visible from the mean of the vertices" in refusal(*prism(5, 0.2, np.pi / 5), 0.03)


def test_a_star_that_winds_twice_around_its_axis_is_convex_at_all_edges_and_still_no_hull():
    k = np.arange(5)
    t = 2 * np.pi * k / 5
    vertices = np.vstack([np.column_stack([np.cos(t), np.sin(t), 0 * t]), [[0, 0, 1], [0, 0, -1]]])
    upper = np.column_stack([5 + 0 * k, k, (k + 2) % 5])
    lower = np.column_stack([6 + 0 * k, (k + 2) % 5, k])
    faces = np.vstack([upper, lower])
    assert dihedral_angles(Triangulation(faces), vertices).min() > 0.1
    assert "may lie before or behind face" in refusal(vertices, faces, 1e-12)


@given(st.integers(0, 10**6), st.sampled_from([1e-10, 1e-6]))
def test_rigid_motions_and_labels_do_not_matter(seed, reach):
    vertices, faces = prism(6)
    expected = proven(vertices, faces, reach)
    moved, relabeled, _ = zoo.relabeled(vertices @ zoo.rotation(seed).T + 3.0, faces, seed)
    found = proven(moved, relabeled, reach)
    assert found.flat.sum() == expected.flat.sum()
    assert found.dihedrals.min() == pytest.approx(expected.dihedrals.min(), abs=1e-12)
