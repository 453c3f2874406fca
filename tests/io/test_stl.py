"""STL files: both kinds are told apart, and their corners become vertices."""

import struct

import numpy as np
import pytest

import zoo
from damage import refusals
from isoembed import PolyhedralMetric
from isoembed.io import FileError, read_metric
from isoembed.io.metric import read_tables
from isoembed.io.stl import TRIANGLE, write

VERTICES, FACES = zoo.icosahedron()


def binary(vertices, faces, header=b"solid but binary"):
    rows = np.zeros(len(faces), TRIANGLE)
    rows["corners"] = vertices[faces]
    return header.ljust(80) + struct.pack("<I", len(faces)) + rows.tobytes()


def test_binary_corners_that_are_exactly_equal_are_one_vertex(tmp_path):
    vertices, faces = zoo.icosphere(1)
    (tmp_path / "s.stl").write_bytes(binary(vertices, faces))
    metric = read_metric(tmp_path / "s.stl")
    expected = PolyhedralMetric.from_mesh(vertices.astype("<f4").astype(float), faces)
    np.testing.assert_allclose(np.sort(metric.lengths), np.sort(expected.lengths), rtol=1e-14)


def test_vertices_come_in_the_order_of_their_first_corners(tmp_path):
    write(tmp_path / "s.stl", {"vertices": VERTICES, "faces": FACES})
    tables = read_tables(tmp_path / "s.stl")
    corners = tables["faces"].ravel()
    assert (np.maximum.accumulate(corners) <= np.arange(60)).all() and corners[0] == 0
    np.testing.assert_array_equal(tables["vertices"][corners], VERTICES[FACES].reshape(-1, 3))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("hello", "is not a readable STL file"),
        ("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "is not a readable STL file"),
        ("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", "is not a readable STL file"),
        ("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\n", "it has 1 facets, but 2 corners"),
    ],
)
def test_what_is_none(text, sentence, tmp_path):
    (tmp_path / "s.stl").write_text(text)
    with pytest.raises(FileError, match=sentence):
        read_metric(tmp_path / "s.stl")


def test_names_may_be_any_bytes_and_files_may_be_zipped(tmp_path):
    import gzip

    write(tmp_path / "s.stl", {"vertices": VERTICES, "faces": FACES})
    text = (tmp_path / "s.stl").read_bytes().replace(b"solid", b"solid C:\\vertex \xfc", 1)
    (tmp_path / "s.stl").write_bytes(gzip.compress(text.replace(b"\n", b"\r\n")))
    assert read_metric(tmp_path / "s.stl").triangulation.n_vertices == 12


@pytest.mark.parametrize("kind", ["text", "binary"])
def test_damaged_files(kind, tmp_path):
    path = tmp_path / "s.stl"
    write(path, {"vertices": VERTICES, "faces": FACES})
    assert refusals(path, path.read_bytes() if kind == "text" else binary(VERTICES, FACES)) > 200
