"""The true faces of a polyhedron: what no diagonal changes, and the paper on it."""

import numpy as np
import pytest

import isoembed
from isoembed import PolyhedralMetric, glue
from isoembed.gluing.classics import LATIN_CROSS, regular_faces

QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
CORNERS = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])


def box(sizes, diagonals):
    """A box from triangles, each face cut along one of its two diagonals."""
    faces = []
    for (a, b, c, d), other in zip(QUADS, diagonals, strict=True):
        faces += [[a, b, d], [b, c, d]] if other else [[a, b, c], [a, c, d]]
    metric = PolyhedralMetric.from_mesh(CORNERS * sizes, faces)
    return isoembed.embed(metric, method="alexandrov")


def test_the_mean_curvature_of_a_box_depends_on_no_diagonal():
    sizes = np.array([1.0, 2.0, 3.0])
    # Each edge gives half of l (pi / 2) / 2 to a corner, and each face a quarter of its area.
    quarter = (sizes[0] * sizes[1] + sizes[1] * sizes[2] + sizes[2] * sizes[0]) / 4
    mean = np.pi / 8 * sizes.sum() / quarter
    for seed in range(4):
        found = box(sizes, np.random.default_rng(seed).integers(0, 2, 6))
        assert found.mean_curvature == pytest.approx(mean, rel=1e-12)
        assert found.surface.bending_energy == pytest.approx(mean**2 * 8 * quarter, rel=1e-12)


def test_triangles_are_measured_as_before():
    octahedron = regular_faces(
        [face for k, m in ((1, 2), (2, 3), (3, 4), (4, 1)) for face in ([0, k, m], [5, m, k])]
    )
    found = isoembed.embed(octahedron, method="alexandrov")
    own = isoembed.Embedding(found.metric, found.vertices, method="given", tolerance=1e-9)
    np.testing.assert_allclose(found.mean_curvature, own.mean_curvature, rtol=1e-13)
    assert (
        own.polygons is own.faces and own.surface.flat_faces.edges.all() and len(own.surface.seams.ends) == 0
    )


def test_sides_are_counted_without_flat_vertices():
    # A cube from six squares whose sides have a corner in the middle: outlines of eight, faces of four sides.
    square = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]
    pairs = [((0, 0), (1, 0)), ((0, 1), (2, 0)), ((0, 2), (3, 0)), ((0, 3), (4, 0)), ((1, 1), (4, 3))]
    pairs += [((2, 1), (1, 3)), ((3, 1), (2, 3)), ((4, 1), (3, 3)), ((1, 2), (5, 3)), ((2, 2), (5, 2))]
    pairs += [((3, 2), (5, 1)), ((4, 2), (5, 0))]
    runs = [((p, 2 * k, 2 * k + 2), (q, 2 * m, 2 * m + 2)) for (p, k), (q, m) in pairs]
    found = isoembed.embed(glue([square] * 6, runs), method="alexandrov")
    assert sorted(map(len, found.polygons)) == [8] * 6
    assert found.surface.flat_faces.sides.tolist() == [4] * 6
    assert found.surface.flat_faces.edges.sum() == 24 and found.volume == pytest.approx(8)


def test_the_seams_of_a_cross_are_its_sides():
    pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
    found = isoembed.embed(glue([LATIN_CROSS], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov")
    ends, faces = found.surface.seams
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(7)
    # Each piece lies in the planes of the triangles on both of its sides.
    for side in faces.T:
        a, b, c = np.moveaxis(found.vertices[found.faces[side]], 1, 0)
        normals = np.cross(b - a, c - a)
        for end in (ends[:, 0], ends[:, 1]):
            assert np.abs(((end - a) * normals).sum(axis=1)).max() < 1e-12
    assert (faces[:, 0] != faces[:, 1]).any() and (faces[:, 0] == faces[:, 1]).any()


def test_seams_outlive_scaling_and_repair():
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    sides = [((0, k), (1, 3 - k)) for k in range(4)]
    sheets = [square, [[2, 0], [3, 0], [3, 1], [2, 1]]]
    net = glue(sheets, sides)
    small = isoembed.embed(net.scaled(1e-100), method="alexandrov")
    assert len(small.surface.seams.ends) == 4 and np.ptp(small.surface.seams.ends) < 1e-99
    assert net.with_lengths(2 * net.face_lengths).seams.sum() == net.seams.sum() == 8
    metric = PolyhedralMetric.from_mesh(CORNERS[[0, 1, 2, 4]], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert len(isoembed.embed(metric, method="alexandrov").surface.seams.ends) == 0
