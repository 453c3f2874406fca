"""FOLD files: closed surfaces in space, metrics without coordinates, and what is no closed surface."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import isoembed
import zoo
from damage import refusals
from isoembed import Embedding, PolyhedralMetric
from isoembed.gluing.classics import CLASSICS
from isoembed.io import FileError, mesh_writer, read_metric, read_surface, write_atomically, write_surface

CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SQUARES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.fold"


def saved(path, **document):
    path.write_text(json.dumps(document))
    return path


def refused(path, error, sentence, **document):
    with pytest.raises(error, match=sentence):
        read_metric(saved(path, **document))


def test_a_dodecahedron_is_folded_by_its_dihedral_angles(path):
    solid = isoembed.embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")
    write_surface(path, solid)
    document = json.loads(path.read_text())
    assert [len(face) for face in document["faces_vertices"]] == [5] * 12
    assert document["edges_assignment"] == ["M"] * 30  # all point outward, which is where we stand
    bend = np.degrees(np.arccos(1 / np.sqrt(5)))  # 180 degrees less 116.565
    assert document["edges_foldAngle"] == pytest.approx([-bend] * 30)
    assert document["edges_length"] == pytest.approx([1.0] * 30)
    sides = {
        tuple(sorted(side)) for f in document["faces_vertices"] for side in zip(f, f[1:] + f[:1], strict=True)
    }
    assert {tuple(edge) for edge in document["edges_vertices"]} == sides
    assert document["frame_classes"] == ["foldedForm"] and document["file_creator"].startswith("isoembed")
    assert document["vertices_isoembed:mean_curvature"] == pytest.approx(solid.mean_curvature)
    assert read_surface(path).volume == pytest.approx(solid.volume, rel=1e-12)


def test_valleys_and_flat_folds(path):
    # A cube in triangles with a pyramid pressed into its top: four valleys, and five diagonals that are flat.
    points = [*CUBE, [0.5, 0.5, 0.5]]
    top = [1, 5, 7, 3]
    faces = [[a, b, c] for s in SQUARES[:5] for a, b, c in ([s[0], s[1], s[2]], [s[0], s[2], s[3]])]
    faces += [[a, b, 8] for a, b in zip(top, [*top[1:], top[0]], strict=True)]
    write_atomically({path: mesh_writer(path, np.array(points) * 1e-160, np.array(faces))})
    document = json.loads(path.read_text())
    folds = dict(zip(map(tuple, document["edges_vertices"]), document["edges_assignment"], strict=True))
    angles = dict(zip(map(tuple, document["edges_vertices"]), document["edges_foldAngle"], strict=True))
    assert sorted(folds.values()) == ["F"] * 5 + ["M"] * 12 + ["V"] * 4
    assert all(folds[(v, 8)] == "V" for v in top)
    # Two faces of the pit, with normals (-1, 0, 1) and (0, -1, 1), include 60 degrees; its rim 135.
    assert angles[(1, 8)] == pytest.approx(60) and angles[(1, 3)] == pytest.approx(-135)
    assert document["edges_length"] == pytest.approx(
        np.linalg.norm(np.diff(np.array(points)[document["edges_vertices"]], axis=1)[:, 0], axis=1) * 1e-160
    )


def test_a_doubly_covered_polygon_is_folded_shut(path):
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    write_surface(
        path, isoembed.embed(isoembed.glue([square] * 2, corners=["abcd"] * 2), method="alexandrov")
    )
    document = json.loads(path.read_text())
    assert document["edges_foldAngle"] == [-180.0] * 4 and len(document["faces_vertices"]) == 2


def test_polygons_in_space(path):
    metric = read_metric(saved(path, vertices_coords=CUBE, faces_vertices=SQUARES))
    assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(1)


def test_a_metric_without_coordinates(path):
    edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    lengths = [4, 5, 6, 6, 5, 4]
    document = {"edges_vertices": edges, "edges_length": lengths, "faces_vertices": zoo.TETRAHEDRON.tolist()}
    metric = read_metric(saved(path, frame_attributes=["abstract"], **document))
    assert sorted(metric.lengths) == sorted(lengths)
    with pytest.raises(FileError, match="a metric without vertices: embed it first"):
        read_surface(path)
    refused(
        path,
        FileError,
        "face 0 has 4 corners, and its side lengths",
        **document | {"faces_vertices": SQUARES},
    )
    refused(path, isoembed.InvalidMetric, "edge 0 is 7, not a list", **document | {"edges_vertices": [7] * 6})


def test_the_folded_frame_of_several_is_read(path):
    sheet = [[x, y] for x, y, _ in CUBE]
    frames = [{"frame_parent": 0, "frame_inherit": True, "vertices_coords": CUBE}]
    frames.append({"frame_parent": 1, "frame_inherit": True, "faces_vertices": SQUARES})
    metric = read_metric(saved(path, vertices_coords=sheet, faces_vertices=SQUARES[:1], file_frames=frames))
    assert metric.triangulation.n_vertices == 8 and metric.lengths.max() == pytest.approx(np.sqrt(2))
    for parent in (2, 7, "a", True):
        frames[1]["frame_parent"] = parent
        refused(path, FileError, "frame 2 inherits from", vertices_coords=sheet, file_frames=frames)


def test_a_net_that_is_folded_up_is_closed_by_merging(path):
    # As origami programs write it: the sheet keeps its boundary, whose vertices come together in space.
    points = [point for face in SQUARES for point in np.array(CUBE)[face].tolist()]
    saved(path, vertices_coords=points, faces_vertices=np.arange(24).reshape(6, 4).tolist())
    with pytest.warns(isoembed.errors.MeshNote, match="16 vertices are merged"):
        metric = read_metric(path, merge=0)
    assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(1)


def test_a_form_that_is_folded_flat_is_a_surface(path):
    metric = read_metric(
        saved(path, vertices_coords=[[0, 0], [1, 0], [0, 1], [1, 1]], faces_vertices=zoo.TETRAHEDRON.tolist())
    )
    assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(0, abs=1e-12)


def test_what_is_no_closed_surface(path):
    sheet = {"vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]], "faces_vertices": [[0, 1, 2, 3]]}
    refused(path, FileError, "a flat sheet with a boundary, as from vertex 0 to 1: name its corners", **sheet)
    names = {"vertices_isoembed:corner": ["a", "b", "a", "c"]}
    refused(path, FileError, "is a net: glue it first, with isoembed.glue\\(", **sheet, **names)
    refused(path, FileError, "has no faces_vertices", vertices_coords=CUBE)
    refused(path, FileError, "file_frames are not a list", file_frames=[3], **sheet)
    refused(path, isoembed.InvalidMetric, "face 0", vertices_coords=CUBE, faces_vertices=["a"])
    refused(path, isoembed.InvalidMetric, "face", vertices_coords=CUBE, faces_vertices=7)
    refused(
        path,
        isoembed.InvalidMetric,
        "boundary|one face|only",
        vertices_coords=CUBE,
        faces_vertices=SQUARES[:5],
    )
    path.write_text("[1]")
    with pytest.raises(FileError, match="holds a JSON list"):
        read_metric(path)


def test_damaged_files(path):
    frames = [{"frame_parent": 0, "frame_inherit": True, "vertices_coords": CUBE}]
    saved(path, faces_vertices=SQUARES, vertices_coords=[[x, y] for x, y, _ in CUBE], file_frames=frames)
    assert refusals(path, path.read_bytes()) > 200
    edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    tables = {"edges_vertices": edges, "edges_length": [20] * 6, "faces_vertices": zoo.TETRAHEDRON.tolist()}
    assert refusals(path, json.dumps(tables).encode()) > 200


@pytest.mark.parametrize(
    "other", [None, 7, "a", {}, [], [None], [[]], [[None]], [["a"]], [[1.5, 2, 3]], [{}], True]
)
@pytest.mark.parametrize(
    "key", ["vertices_coords", "faces_vertices", "edges_length", "edges_vertices", "file_frames"]
)
def test_tables_of_another_kind(path, key, other):
    tables = {
        "vertices_coords": CUBE,
        "faces_vertices": SQUARES,
        "edges_length": [1] * 12,
        "edges_vertices": [],
    }
    saved(path, **tables | {key: other})
    try:
        read_metric(path)
    except (FileError, isoembed.InvalidMetric) as error:
        assert "\n" not in str(error)
    saved(path, **{k: v for k, v in tables.items() if k != "vertices_coords"} | {key: other})
    with pytest.raises((FileError, isoembed.InvalidMetric)):
        read_metric(path)


def test_bends_by_rounded_coordinates_are_no_creases(tmp_path):
    outline = np.array([[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [0, 3]])  # an L
    points = np.array([[x, y, z] for z in (0.0, 1.5) for x, y in outline])
    faces = [
        list(range(6))[::-1],
        list(range(6, 12)),
        *([k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)),
    ]
    turned = points @ Rotation.random(random_state=2).as_matrix().T
    metric = PolyhedralMetric.from_mesh(np.round(turned, 6), faces)
    found = Embedding(metric, np.round(turned, 6), method="given", tolerance=1e-10)
    write_surface(tmp_path / "l.fold", found)
    document = json.loads((tmp_path / "l.fold").read_text())
    folded = [angle for angle in document["edges_foldAngle"] if angle != 0]
    np.testing.assert_allclose(sorted(folded), [-90.0] * 17 + [90.0], atol=1e-4)
    assert document["edges_assignment"].count("F") == 12
    bend = isoembed.report(found)["input"]["precision"]["bend"]
    flat = np.abs(found.dihedral_angles) < 0.1
    assert flat.sum() == 12 and np.abs(found.dihedral_angles[flat]).max() < bend["max"] < 1e-4
