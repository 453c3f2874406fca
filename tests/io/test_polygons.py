"""Polyhedra in files: true faces where the format can hold them, and every vertex in a face."""

import json

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.gluing.classics import CLASSICS
from isoembed.io import InputFile, mesh_writer, read_surface, write_atomically, write_surface
from isoembed.io.registry import FORMATS
from isoembed.io.surface import polygon_faces

ENDINGS = [ending for ending, known in FORMATS.items() if known.holds_polygons]


@pytest.fixture(scope="module")
def dodecahedron():
    return isoembed.embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")


@pytest.fixture(scope="module")
def tetrahedron():
    """From the Latin cross, with four flat vertices, of which some lie inside faces."""
    return isoembed.embed(CLASSICS["latin-cross"].make()[0][1], method="alexandrov")


def as_lists(faces):
    """Faces from their lowest corner on, in order."""
    return sorted(
        min([*f[k:], *f[:k]] for k in range(len(f))) for f in (np.asarray(g).tolist() for g in faces)
    )


def written(surface, ending, path):
    """The faces of a file, by another reader where there is one."""
    write_surface(path, surface)
    if ending == ".obj":
        lines = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("f ")]
        return [[int(word) - 1 for word in line] for line in lines]
    if ending == ".off":
        return [list(map(int, line.split()[1:])) for line in path.read_text().splitlines()[-12:]]
    if ending == ".fold":
        return json.loads(path.read_text())["faces_vertices"]
    if ending == ".vtp":
        with InputFile(path) as file:
            return list(FORMATS[ending].read(file)["faces"])
    meshio = pytest.importorskip("meshio")
    return [face for block in meshio.read(path).cells for face in block.data]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_dodecahedron_has_pentagons(dodecahedron, ending, tmp_path):
    found = written(dodecahedron, ending, tmp_path / f"a{ending}")
    assert [len(face) for face in found] == [5] * 12
    assert as_lists(found) == as_lists(dodecahedron.polygons)


def test_arrays_stay_triangles(dodecahedron, tmp_path):
    write_surface(tmp_path / "a.npz", dodecahedron)
    with np.load(tmp_path / "a.npz") as archive:
        np.testing.assert_array_equal(archive["faces"], dodecahedron.faces)


def test_faces_with_flat_vertices_inside_stay_triangles(tetrahedron):
    outlined = set(np.concatenate(tetrahedron.polygons).tolist())
    inside = set(range(8)) - outlined
    assert len(tetrahedron.polygons) == 4 and inside
    faces = polygon_faces(tetrahedron)
    assert set(np.concatenate(faces).tolist()) == set(range(8))
    assert {len(face) for face in faces if not inside & set(face.tolist())} == {4}
    assert all(len(face) == 3 for face in faces if inside & set(face.tolist()))
    # A closed surface: every side once in each direction.
    sides = [(a, b) for f in (g.tolist() for g in faces) for a, b in zip(f, [*f[1:], f[0]], strict=True)]
    assert len(set(sides)) == len(sides) and {(b, a) for a, b in sides} == set(sides)


def test_a_face_may_have_more_corners_than_a_byte_counts(tmp_path):
    n = 257
    angles = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    disc = isoembed.glue([ring, ring], [((0, k), (1, n - 1 - k)) for k in range(n)])
    write_surface(tmp_path / "a.ply", isoembed.embed(disc, method="alexandrov"))
    assert b"property list int int vertex_indices" in (tmp_path / "a.ply").read_bytes()


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_written_polyhedron_is_read_as_its_metric(dodecahedron, tetrahedron, ending, tmp_path):
    for surface in (dodecahedron, tetrahedron):
        write_surface(tmp_path / f"a{ending}", surface)
        again = isoembed.embed(isoembed.io.read_metric(tmp_path / f"a{ending}"), method="alexandrov")
        assert again.volume == pytest.approx(surface.volume, rel=1e-9)
        np.testing.assert_allclose(again.given.deficits, surface.given.deficits, atol=1e-9)


def test_a_polyhedron_that_is_read_knows_its_faces(dodecahedron, tetrahedron, tmp_path):
    for surface, sides in ((dodecahedron, [5] * 12), (tetrahedron, [3] * 4)):
        for ending in (".off", ".npz"):
            write_surface(tmp_path / f"a{ending}", surface)
            again = read_surface(tmp_path / f"a{ending}")
            assert as_lists(again.polygons) == as_lists(surface.polygons)
            assert again.surface.flat_faces.sides.tolist() == sides
            np.testing.assert_allclose(again.mean_curvature, surface.mean_curvature, rtol=1e-9, atol=1e-12)
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    disc = isoembed.glue([square] * 2, corners=["abcd"] * 2)
    write_surface(tmp_path / "a.off", isoembed.embed(disc, method="alexandrov"))
    assert read_surface(tmp_path / "a.off").surface.flat_faces.sides.tolist() == [4, 4]


def test_other_surfaces_that_are_read_stay_triangles(tmp_path):
    vertices, faces = zoo.icosphere(1)
    for stretched in (vertices, vertices * np.where(np.arange(42) == 0, 0.5, 1)[:, None]):
        write_atomically({tmp_path / "a.off": mesh_writer(tmp_path / "a.off", stretched, faces)})
        again = read_surface(tmp_path / "a.off")
        assert again.polygons is again.faces
