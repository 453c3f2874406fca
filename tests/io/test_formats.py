"""Files: round trips in every format, and one sentence for everything that a file can do wrong."""

from __future__ import annotations

import io
import json
import os
import re
import stat
import struct
import sys
from dataclasses import replace

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import Embedding, InvalidMetric, PolyhedralMetric
from isoembed.io import (
    METRIC_ENDINGS,
    SURFACE_ENDINGS,
    FileError,
    check_output,
    mesh_writer,
    read_metric,
    read_surface,
    write_metric,
    write_report,
    write_surface,
)
from isoembed.io.input_file import InputFile
from isoembed.io.registry import FORMATS
from places import SHARED

SPHERE = zoo.icosphere(1)
ZOO = {
    "sphere": SPHERE,
    "ellipsoid": (SPHERE[0] * [3, 2, 1], SPHERE[1]),
    "hull": zoo.random_hull(60, seed=3),
    "tiny": (SPHERE[0] * 1e-150, SPHERE[1]),
    "large": (SPHERE[0] * 1e12, SPHERE[1]),
}
FILES = SHARED / "cases"


def read_by(ending, path):
    """What the reader of an ending makes of a file."""
    with InputFile(path) as file:
        return FORMATS[ending].read(file)


def exact(vertices, faces):
    return Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)


@pytest.fixture(params=ZOO.values(), ids=ZOO)
def embedding(request):
    return exact(*request.param)


def sphere():
    return exact(*SPHERE)


@pytest.mark.parametrize("ending", METRIC_ENDINGS)
def test_metrics_survive_a_round_trip_exactly(embedding, ending, tmp_path):
    path = tmp_path / f"metric{ending}"
    write_metric(path, embedding.metric)
    again = read_metric(path)
    np.testing.assert_array_equal(again.faces, embedding.metric.faces)
    np.testing.assert_array_equal(again.lengths, embedding.metric.lengths)


@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_surfaces_come_back_as_their_metrics(embedding, ending, tmp_path):
    path = tmp_path / f"surface{ending.upper()}"
    write_surface(path, embedding)
    again = read_metric(path)
    # STL knows no vertices: theirs are numbered anew, so the sorted lengths are compared.
    np.testing.assert_allclose(np.sort(again.lengths), np.sort(embedding.metric.lengths), rtol=1e-14)
    if ending != ".stl":
        np.testing.assert_array_equal(again.faces, embedding.faces)


@pytest.mark.parametrize("ending", [".ply", ".vtk", ".vtu"])
def test_meshes_carry_curvature_and_residual(ending, tmp_path):
    meshio = pytest.importorskip("meshio")
    true = sphere()
    metric = true.metric.with_lengths(true.metric.lengths * (1 + 1e-3 * (true.metric.edges[:, 0] == 0)))
    embedding = Embedding(metric, true.vertices, method="attempt", tolerance=1e-10)
    write_surface(tmp_path / f"surface{ending}", embedding)
    mesh = meshio.read(tmp_path / f"surface{ending}")
    np.testing.assert_array_equal(mesh.points, embedding.vertices)
    np.testing.assert_array_equal(mesh.point_data["mean_curvature"], embedding.mean_curvature)
    touched = np.zeros(42, dtype=bool)
    touched[metric.edges[metric.edges[:, 0] == 0]] = True
    np.testing.assert_array_equal(mesh.point_data["residual"] > 1e-4, touched)


@pytest.mark.parametrize("ending", [".ply", ".vtk", ".vtu"])
def test_meshes_carry_vectors(ending, tmp_path):
    meshio = pytest.importorskip("meshio")
    surface, path = sphere(), tmp_path / f"surface{ending}"
    v = 2.0 * surface.vertices
    mesh_writer(path, surface.vertices, surface.faces, v=v)(path)
    data = meshio.read(path).point_data
    found = np.column_stack([data[f"v_{axis}"] for axis in "xyz"]) if ending == ".ply" else data["v"]
    np.testing.assert_array_equal(found, v)


def test_arrays_carry_curvature_and_residual(tmp_path):
    embedding = sphere()
    write_surface(tmp_path / "s.npz", embedding)
    write_surface(tmp_path / "s.json", embedding)
    document = json.loads((tmp_path / "s.json").read_text())
    with np.load(tmp_path / "s.npz") as archive:
        for name in ("vertices", "faces", "mean_curvature", "residual"):
            np.testing.assert_array_equal(archive[name], document[name])
        assert archive["mean_curvature"] == pytest.approx(embedding.mean_curvature)


def test_edges_may_be_left_out_and_come_in_any_order(tmp_path):
    metric = sphere().metric
    order = np.random.default_rng(0).permutation(len(metric.edges))
    np.savez(tmp_path / "a.npz", faces=metric.faces, lengths=metric.lengths)
    np.savez(
        tmp_path / "b.npz", faces=metric.faces, edges=metric.edges[order, ::-1], lengths=metric.lengths[order]
    )
    for name in ("a.npz", "b.npz"):
        np.testing.assert_array_equal(read_metric(tmp_path / name).lengths, metric.lengths)


def test_standard_input_is_json(monkeypatch):
    metric = sphere().metric
    text = json.dumps({"faces": metric.faces.tolist(), "lengths": metric.lengths.tolist(), "edges": None})
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"\xef\xbb\xbf" + text.encode())))
    np.testing.assert_array_equal(read_metric("-").lengths, metric.lengths)


TETRAHEDRON_OBJ = """# colors, textures, relative indices, a continued line
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 0 1 0 0 0 1 # red, green, blue
v 0 0 1 1 1 1
vt 0 0
g group
f 1/1 3/1 2/1
f 1/1/1 2//1 \\
4
s off
f -3 -2 -1
f 1 4 3
"""
TETRAHEDRON_OFF = """COFF 4 4 6   # all in one line
0 0 0 255 0 0 255

1 0 0  0 255 0 255
0 1 0  0 0 255 255
0 0 1  9 9 9 255
3   0 2 1  255 0 0
3 0 1 3
3 1 2 3
3 0 3 2
"""
TETRAHEDRON_PLY = """ply
format ascii 1.0
comment colors, names and elements as they come
element vertex 4
property uchar red
property float z
property float x
property float y
element edge 1
property int vertex1
property int vertex2
element face 4
property uchar flag
property list uchar uint vertex_index
property uchar blue
end_header
9 0 0 0
9 0 1 0
9 0 0 1
9 1 0 0
0 1
1 3 0 2 1 7
1 3 0 1 3 7
1 3 1 2 3 7
1 3 0 3 2 7
"""


@pytest.mark.parametrize(
    ("name", "text"), [("t.obj", TETRAHEDRON_OBJ), ("t.off", TETRAHEDRON_OFF), ("t.ply", TETRAHEDRON_PLY)]
)
def test_meshes_as_others_write_them(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    lengths = read_metric(tmp_path / name).lengths
    np.testing.assert_allclose(lengths, [1, 1, 1, np.sqrt(2), np.sqrt(2), np.sqrt(2)], rtol=1e-15)


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_ply_with_properties_between_the_lists(order, tmp_path):
    sign = "<" if order == "little" else ">"
    head = (
        f"ply\nformat binary_{order}_endian 1.0\nelement vertex 4\n"
        "property float x\nproperty double y\nproperty float z\nproperty uchar red\n"
        "element face 4\nproperty list ushort int vertex_indices\nproperty short quality\nend_header\n"
    )
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    body = b"".join(struct.pack(sign + "fdfB", *p, 200) for p in points)
    body += b"".join(struct.pack(sign + "Hiiih", 3, *f, -5) for f in faces)
    path = tmp_path / "t.ply"
    path.write_bytes(head.encode() + body)
    np.testing.assert_allclose(read_metric(path).lengths, [1, 1, 1, *[np.sqrt(2)] * 3], rtol=1e-15)
    path.write_bytes(head.encode() + body[:-1])
    with pytest.raises(FileError, match="cut short in face 3 of 4"):
        read_metric(path)


# Everything below must be refused in one sentence.


def refusal(path):
    with pytest.raises((FileError, InvalidMetric)) as caught:
        read_metric(path)
    message = str(caught.value)
    assert message
    assert "\n" not in message
    return message


QUADS_VTK = """# vtk DataFile Version 3.0
cube
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0 1 0 0 1 1 0 0 1 0
CELLS 1 {n}
{cell}
CELL_TYPES 1
{kind}
"""


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.xyz", "", "not one of .npz .json .ply .obj .stl .off .fold .vtk .vtu .vtp"),
        ("noending", "", "has no ending"),
        ("a.npz", "", "is not an npz archive"),
        ("a.npz", "hello", "is not an npz archive"),
        ("a.json", "", "is not JSON"),
        ("a.json", '{"faces": [', "is not JSON: .* line 1 column"),
        ("a.json", b"\xff\xfe", "not UTF-8"),
        ("a.json", "[1, 2]", "holds a JSON list"),
        ("a.json", "[" * 100_000, "nested too deeply"),
        ("a.json", '{"points": [], "cells": []}', "holds points, cells: a metric needs faces and lengths"),
        ("a.json", "{}", "holds nothing: a metric needs"),
        ("a.json", '{"faces": 5, "lengths": []}', "faces is 5, not a list"),
        ("a.json", '{"faces": [5], "lengths": []}', "face 0 is 5, not a list of numbers"),
        ("a.json", '{"faces": [[0, 1, [2]]], "lengths": []}', "entry 2 of face 0 is .*, not a number"),
        ("a.json", '{"faces": [[0, 1, true]], "lengths": []}', "entry 2 of face 0 is true"),
        ("a.json", '{"faces": [[0, 1, 2]], "lengths": ["1"]}', 'length 0 is "1", not a number'),
        ("a.json", f'{{"faces": [[0, 1, {10**400}]], "lengths": []}}', "whole numbers"),
        ("a.json", '{"faces": [[0, 1, 2]], "vertices": [[0, 1, 2], [1]]}', "vertex 1 has 1 coordinates"),
        ("a.obj", "", "there are no faces"),
        ("a.obj", "v 1 2\n", "line 1: cannot understand 'v 1 2'"),
        ("a.obj", "v 0 0 0\nf 1 0 1\n", "line 2: cannot understand"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", "4 such boundary edges"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "there are no faces"),
        ("a.off", "PLY", "does not begin with OFF"),
        ("a.off", "OFF BINARY\n", "is not an OFF text file"),
        ("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n", "line 4: cannot understand"),
        ("a.off", "OFF\n2 0 0\n0 0 0\n", "promises 2 vertices and 0 faces, but has 1 and 0"),
        ("a.off", "OFF\nmany\n", "line 2: cannot understand 'many'"),
        ("a.ply", "ply\nformat ascii 1.0\n", "no header from 'ply' to 'end_header'"),
        ("a.ply", "ply\nformat ascii 1.0\nelement face x\nend_header\n", "'element face x'"),
        ("a.ply", "ply\nend_header\n", "nothing of its format"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "no x, y and z",
        ),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement face 1\nproperty list int int vertex_indices\nend_header\n-1\n",
            "a list of -1 numbers",
        ),
        ("a.stl", "solid\n", "there are no faces"),
        ("a.stl", "solid\nfacet normal 0 0 x\n", "is not a readable STL file"),
        ("a.vtk", "hello", "is not a readable VTK file: Illegal VTK header"),
        ("a.vtk", QUADS_VTK.format(n=5, cell="4 0 1 2 3", kind=9), "4 such boundary edges"),
        ("a.vtk", QUADS_VTK.format(n=3, cell="2 0 1", kind=3), "cell 0 is a line, not a triangle"),
        ("a.vtu", "<VTKFile>", "is not a readable VTU file"),
    ],
)
def test_malformed_files(name, content, sentence, tmp_path, capfd):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert re.search(sentence, refusal(path))
    assert capfd.readouterr() == ("", "")


def test_files_that_cannot_be_opened(tmp_path):
    assert refusal(tmp_path / "no.npz").startswith("there is no file")
    (tmp_path / "folder.json").mkdir()
    assert "is a folder" in refusal(tmp_path / "folder.json")
    (tmp_path / "loop.json").symlink_to(tmp_path / "loop.json")
    assert refusal(tmp_path / "loop.json").startswith("cannot read")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_file_without_permission(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("{}")
    path.chmod(0)
    assert "Permission denied" in refusal(path)


@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_files_cut_short(ending, tmp_path):
    path = tmp_path / f"surface{ending}"
    write_surface(path, sphere())
    whole = path.read_bytes()
    for share in (0.1, 0.5, 0.9):
        path.write_bytes(whole[: int(share * len(whole))])
        refusal(path)


def test_archives_of_something_else(tmp_path):
    path = tmp_path / "a.npz"
    ones = np.ones(6)
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    np.savez(path, faces=np.array([[0, 1, 2], None], dtype=object), lengths=ones)
    assert "cannot read faces" in refusal(path)
    np.savez(path, faces=faces, lengths=ones + 1j)
    assert "lengths has the type complex128, not numbers" in refusal(path)
    np.savez(path, faces=faces, lengths=3.0)
    assert "lengths is the single value 3.0" in refusal(path)
    np.savez(path, faces=7, lengths=ones)
    assert "faces is the single value 7" in refusal(path)
    np.savez(path, faces=faces, lengths=ones[:, None])
    assert "shape (6, 1)" in refusal(path)
    np.save(tmp_path / "b", ones)
    (tmp_path / "b.npy").rename(path)
    assert "is not an npz archive" in refusal(path)


def icosahedron():
    metric = PolyhedralMetric.from_mesh(*zoo.icosahedron())
    return {name: getattr(metric, name).tolist() for name in ("faces", "edges", "lengths")}


def spoil(**changes):
    """An icosahedron with some tables changed by functions."""
    document = icosahedron()
    for name, change in changes.items():
        document[name] = change(document[name])
    return document


def put(index, value):
    return lambda rows: [value if k == index else row for k, row in enumerate(rows)]


BAD_METRICS = {
    "empty": {"faces": [], "edges": [], "lengths": []},
    "open boundary": spoil(faces=lambda f: f[1:]),
    "repeated triangle": spoil(faces=lambda f: [*f, f[5]]),
    "repeated vertex": spoil(faces=lambda f: put(1, [f[1][0], f[1][0], f[1][2]])(f)),
    "quad": spoil(faces=lambda f: put(3, [*f[3], 11])(f)),
    "not whole": spoil(faces=lambda f: put(2, [f[2][0] + 0.5, *f[2][1:]])(f)),
    "out of range": spoil(faces=lambda f: put(2, [1_000_000, *f[2][1:]])(f)),
    "negative index": spoil(faces=lambda f: put(2, [-1, *f[2][1:]])(f)),
    "fin": spoil(faces=lambda f: [*f, [f[0][0], f[0][1], 12]]),
    "two components": spoil(faces=lambda f: [*f, *[[a + 12, b + 12, c + 12] for a, b, c in f]]),
    "missing edge": spoil(edges=lambda e: e[:-1], lengths=lambda x: x[:-1]),
    "extra edge": spoil(edges=lambda e: [*e, [0, 99]], lengths=lambda x: [*x, 1.0]),
    "conflicting": spoil(edges=lambda e: [*e, e[0]], lengths=lambda x: [*x, 1.5 * x[0]]),
    "length count": spoil(lengths=lambda x: x[:-2]),
    "zero": spoil(lengths=put(3, 0.0)),
    "negative": spoil(lengths=put(3, -1.0)),
    "infinite": spoil(lengths=put(3, float("inf"))),
    "nan": spoil(lengths=put(3, float("nan"))),
    "triangle inequality": spoil(lengths=put(7, 4.5)),
}


@pytest.mark.parametrize("document", BAD_METRICS.values(), ids=BAD_METRICS)
def test_what_is_not_a_metric(document, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(document))
    with pytest.raises(InvalidMetric):
        read_metric(path)


@pytest.mark.shared
@pytest.mark.parametrize("name", sorted(path.name for path in FILES.glob("bad_*")))
def test_shared_bad_cases(name):
    path = FILES / name
    if path.stem == "bad_two_triangles":
        pytest.skip("a flat surface, not an error")
    refusal(path)


def test_a_surface_comes_back_from_its_file(tmp_path, monkeypatch):
    path = tmp_path / "surface.npz"
    given = sphere()
    m = given.metric
    np.savez(path, vertices=2.0 * given.vertices, faces=m.faces, edges=m.edges, lengths=m.lengths)
    reads = []
    read = FORMATS[".npz"].read
    counting = replace(FORMATS[".npz"], read=lambda file: reads.append(file.path) or read(file))
    monkeypatch.setitem(FORMATS, ".npz", counting)
    found = read_surface(path)
    assert reads == [path]  # once
    np.testing.assert_array_equal(found.vertices, 2.0 * given.vertices)
    np.testing.assert_array_equal(found.metric.lengths, given.metric.lengths)
    assert found.residuals == pytest.approx(given.metric.lengths / given.metric.mean_length, rel=1e-6)
    with pytest.raises(FileError, match="is a metric without vertices: embed it first"):
        write_metric(path, given.metric)
        read_surface(path)


# The fast ways and the careful ones.


def careful(monkeypatch, ending, path):
    """What the reader of an ending makes of a file without its fast way."""
    skipped = {
        ".obj": ("isoembed.io.obj._read_plain", lambda data: None),
        ".off": ("isoembed.io.off._read_plain", lambda data: None),
        ".ply": ("isoembed.io.ply._rows_together", lambda element, source: None),
        ".json": ("isoembed.io.json._usual_tables", lambda document: None),
    }
    with monkeypatch.context() as patch:
        patch.setattr(*skipped[ending])
        return read_by(ending, path)


def fast(monkeypatch, ending, path):
    """What it makes of the file without the careful way."""
    careful_ways = {
        ".obj": "isoembed.io.obj._read_any",
        ".off": "isoembed.io.off._read_any",
        ".ply": "isoembed.io.ply._rows",
        ".json": "isoembed.io.json._any_tables",
    }
    with monkeypatch.context() as patch:
        patch.delattr(careful_ways[ending])
        return read_by(ending, path)


def assert_same(one, other):
    for key in ("vertices", "faces"):
        np.testing.assert_array_equal(one[key], other[key])
        kinds = [np.asarray(tables[key]).dtype.kind.replace("u", "i") for tables in (one, other)]
        assert kinds[0] == kinds[1]


@pytest.mark.parametrize("ending", [".obj", ".off", ".ply", ".json"])
def test_the_fast_way_is_taken_and_reads_the_same(embedding, ending, tmp_path, monkeypatch):
    path = tmp_path / f"surface{ending}"
    write_surface(path, embedding)
    assert_same(fast(monkeypatch, ending, path), careful(monkeypatch, ending, path))


PLAIN_OBJ = """# a comment  \r
o thing
v\t0 0 0 0.5 # a weight
  v 1e-3 -2.5E+1 .5\r
v 0 1 +0
vn 0 0 1
v 0 0 1#near
f 1/1 3/2/1 2//1

f 1 2 4  # faces\r
vt 0 0
usemtl f 1 2
f 2 3 4
f 1 4 3"""
PLAIN_OFF = """STOFF\r
4 4  6 \r
# a comment
0 0 0 255
  1e-3 -2.5E+1 .5 # near
0 1 +0

0 0 1
3 0 2 1 255 0 0
3 0 1 3
 3 1 2 3#
3 0 3 2"""


@pytest.mark.parametrize(("ending", "text"), [(".obj", PLAIN_OBJ), (".off", PLAIN_OFF)])
def test_plain_text_may_have_comments_blanks_and_more(ending, text, tmp_path, monkeypatch):
    path = tmp_path / f"a{ending}"
    path.write_bytes(text.encode())
    read = fast(monkeypatch, ending, path)
    assert_same(read, careful(monkeypatch, ending, path))
    assert read["vertices"].tolist() == [[0, 0, 0], [1e-3, -25, 0.5], [0, 1, 0], [0, 0, 1]]
    assert read["faces"].tolist() == [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


UNUSUAL_OBJ = [
    PLAIN_OBJ.replace("f 1 2 4", "f 1 2 -1"),
    PLAIN_OBJ.replace("f 1 2 4", "f 1 \\\n2 4"),
    PLAIN_OBJ.replace("f 1 2 4", "f 1 2 4 3"),
    PLAIN_OBJ.replace("f 1 2 4", "f 1 2"),
    PLAIN_OBJ.replace("f 1 2 4", "f 1 +2 4"),
    PLAIN_OBJ.replace("f 1 2 4", "f 1 2 4\x0b"),
    PLAIN_OBJ.replace("# a comment  \r", "# a comment that goes on \\"),
    PLAIN_OBJ.replace("a weight", "ein Gewicht für hier"),
    PLAIN_OBJ.replace(".5\r\n", ".5\r"),
    PLAIN_OBJ.replace("1e-3", "1_0"),
    "v 0 0 0\nv 1 0 0\n",
    "",
]
UNUSUAL_OFF = [
    PLAIN_OFF.replace("3 0 1 3", "4 0 1 3 2"),
    PLAIN_OFF.replace("4 4  6", "4 4 # 6"),
    PLAIN_OFF.replace("STOFF\r\n4 4  6", "STOFF 4 4 6\n# and\x0c"),
    PLAIN_OFF.replace("1e-3", "1_0"),
    "OFF\n0 0 0\n",
]


def test_exponents_of_fortran_are_read(tmp_path):
    (tmp_path / "a.off").write_text("OFF\n3 1 0\n0 0 0\n1.5D+00 0 0\n0 2d0 0\n3 0 1 2\n")
    np.testing.assert_array_equal(read_by(".off", tmp_path / "a.off")["vertices"][1:, :2], [[1.5, 0], [0, 2]])


@pytest.mark.parametrize(
    ("ending", "text"), [*((".obj", text) for text in UNUSUAL_OBJ), *((".off", text) for text in UNUSUAL_OFF)]
)
def test_unusual_text_is_read_with_care(ending, text, tmp_path, monkeypatch):
    path = tmp_path / f"a{ending}"
    path.write_bytes(text.encode())
    expected = careful(monkeypatch, ending, path)
    assert read_by(ending, path)["faces"] == expected["faces"]
    with pytest.raises(NameError):
        fast(monkeypatch, ending, path)


@pytest.mark.parametrize(
    ("ending", "content", "sentence"),
    [
        (
            ".obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 4\n",
            "line 5: a face has vertex 4, but there are only 3 v lines",
        ),
        (".obj", f"v 0 0 0\nf 1 1 {10**18}\n", f"line 2: a face has vertex {10**18}, but there are only 1 v"),
        (".obj", "v\nv 1 0 0\nf 1 1 1\n", "line 1: cannot understand 'v'"),
        (".obj", "v 0 0 0\nv# 1 0 0\nf 1 1 1\n", "line 2: cannot understand 'v# 1 0 0'"),
        (".obj", "v 0 0 0\nv 1-2 0 0\nf 1 1 1\n", "line 2: cannot understand 'v 1-2 0 0'"),
        (".obj", "v 0 0 0\nv 1-2 0\nf 1 1 1\n", "line 2: cannot understand 'v 1-2 0'"),
        (".obj", "v 0 0 0\nv 1-2 0 x\nf 1 1 1\n", "line 2: cannot understand 'v 1-2 0 x'"),
        (".obj", "v 0 0 0x\nf 1 1 1\n", "line 1: cannot understand 'v 0 0 0x'"),
        (".obj", "v 0 0 0\nf 1 1 1x\n", "line 2: cannot understand 'f 1 1 1x'"),
        (".off", "OFF\n2 1 0\n0 0 0\n1-2 0 0\n3 0 0 0\n", "line 4: cannot understand '1-2 0 0'"),
        (".off", "OFF\n1 1 0\n0 0 0\n3 0 0 0/1\n", "line 4: cannot understand '3 0 0 0/1'"),
        (".off", "OFF\n99999999999 1 0\n0 0 0\n", "promises 99999999999 vertices"),
    ],
)
def test_what_the_fast_ways_stumble_over_is_named(ending, content, sentence, tmp_path):
    path = tmp_path / f"a{ending}"
    path.write_text(content)
    assert sentence in refusal(path)


def test_large_files_are_written_in_pieces(monkeypatch, tmp_path):
    write_whole_files = {ending: tmp_path / f"whole{ending}" for ending in (".obj", ".off", ".stl", ".json")}
    for path in write_whole_files.values():
        write_surface(path, sphere())
    monkeypatch.setattr("isoembed.io.text_scan.PIECE", 7)
    for ending, path in write_whole_files.items():
        write_surface(tmp_path / f"pieces{ending}", sphere())
        assert (tmp_path / f"pieces{ending}").read_bytes() == path.read_bytes()


def test_json_is_what_python_writes(tmp_path):
    tables = {"vertices": SPHERE[0], "faces": SPHERE[1], "residual": np.array([1e-300, 0.1, -0.0])}
    FORMATS[".json"].write(tmp_path / "a.json", tables)
    lists = {key: table.tolist() for key, table in tables.items()}
    assert (tmp_path / "a.json").read_text() == json.dumps(lists) + "\n"
    FORMATS[".json"].write(tmp_path / "b.json", {"x": np.array([1.0, np.nan]), "y": np.full((1, 2), np.inf)})
    assert (tmp_path / "b.json").read_text() == '{"x": [1.0, null], "y": [[null, null]]}\n'


@pytest.mark.parametrize(
    "table", ["[[0, 1, 2.0]]", "[[0, 1, 2], [3, 4]]", *(f"[[0, 1, 1{n * '0'}]]" for n in (18, 400, 5000))]
)
def test_tables_of_json_with_numbers_of_any_kind(table, tmp_path, monkeypatch):
    path = tmp_path / "a.json"
    path.write_text(f'{{"faces": {table}, "lengths": [1, 2]}}')
    read, expected = read_by(".json", path), careful(monkeypatch, ".json", path)
    assert [list(row) for row in read["faces"]] == expected["faces"]
    for k, row in enumerate(read["faces"]):
        assert np.array(row).dtype == np.array(expected["faces"][k]).dtype
    assert read["lengths"].dtype == np.float64


def binary_ply(order, rows, *, before="", after=""):
    """A tetrahedron with a label and a list of its own at each vertex, and the faces' rows as given."""
    sign = "<" if order == "little" else ">"
    head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty uchar label\n"
    head += "property float z\nproperty list uchar short near\nproperty float x\nproperty double y\n"
    head += f"element face {len(rows)}\n{before}property list int uint vertex_index\n{after}end_header\n"
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    body = b"".join(struct.pack(f"{sign}BfBhhfd", 7, z, 2, -1, 1, x, y) for x, y, z in points)
    for row in rows:
        body += struct.pack(f"{sign}B", 9) if before else b""
        body += struct.pack(f"{sign}i{len(row)}I", len(row), *row)
        body += struct.pack(f"{sign}f", 0.5) if after else b""
    return head.encode() + body


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_ply_with_other_properties_is_read_in_one_piece(order, tmp_path, monkeypatch):
    path = tmp_path / "a.ply"
    rows = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    path.write_bytes(
        binary_ply(order, rows, before="property uchar flag\n", after="property float32 quality\n")
    )
    read = fast(monkeypatch, ".ply", path)
    assert_same(read, careful(monkeypatch, ".ply", path))
    assert read["faces"].tolist() == rows
    assert read["vertices"].tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


@pytest.mark.parametrize("rows", [[[0, 2, 1], [0, 1, 3, 2]], [[0, 2, 1, 3], [0, 1, 3]], []])
def test_faces_of_different_sizes_in_binary_ply(rows, tmp_path, monkeypatch):
    path = tmp_path / "a.ply"
    path.write_bytes(binary_ply("little", rows))
    with pytest.raises(NameError):
        fast(monkeypatch, ".ply", path)
    assert read_by(".ply", path)["faces"] == rows
    path.write_bytes(path.read_bytes()[:-1])
    assert "is cut short in" in refusal(path)


# Writing.


def test_a_failing_writer_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "surface.obj"
    path.write_text("old")

    def half(template, table):
        yield "v 0 0"
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("isoembed.io.obj.lines", half)
    with pytest.raises(FileError, match=r"cannot write .*surface\.obj: No space left on device"):
        write_surface(path, sphere())
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["surface.obj"]


def test_permissions_follow_the_umask_and_the_old_file(tmp_path):
    path = tmp_path / "r.json"
    previous = os.umask(0o027)
    try:
        write_report(path, {"a": 1})
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
        path.chmod(0o600)
        write_report(path, {"a": 2})
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    finally:
        os.umask(previous)


def test_links_stay_links(tmp_path):
    (tmp_path / "there").mkdir()
    link, file = tmp_path / "r.json", tmp_path / "there" / "real.json"
    link.symlink_to(file)
    write_report(link, {"a": 1})
    assert link.is_symlink()
    assert json.loads(file.read_text()) == {"a": 1}


def test_reports_are_strict_json(tmp_path):
    write_report(tmp_path / "r.json", {"volume": float("nan")})
    assert json.loads((tmp_path / "r.json").read_text()) == {"volume": None}
    write_report(tmp_path / "r.json", isoembed.report(sphere()))
    assert json.loads((tmp_path / "r.json").read_text())["input"]["vertices"] == 42


def test_outputs_are_checked_beforehand(tmp_path):
    for name, sentence in (
        ("a.txt", "not one of .npz"),
        ("no/a.npz", "there is no folder"),
        ("folder.npz", "it is a folder"),
        ("pipe.npz", "not an ordinary file"),
    ):
        if name == "folder.npz":
            (tmp_path / name).mkdir()
        if name == "pipe.npz":
            os.mkfifo(tmp_path / name)
        with pytest.raises(FileError, match=sentence):
            check_output(tmp_path / name, SURFACE_ENDINGS)
    check_output(tmp_path / "a.npz", SURFACE_ENDINGS)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_closed_folders_are_found_beforehand(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(FileError, match="no permission to write"):
        check_output(tmp_path / "a.npz", SURFACE_ENDINGS)
