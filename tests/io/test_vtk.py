"""Legacy VTK files: of others, of meshio, and damaged ones."""

import numpy as np
import pytest

import zoo
from damage import refusals
from isoembed.errors import InvalidMetric
from isoembed.io import FileError, InputFile, read_metric
from isoembed.io.vtk import read_polydata, write

VERTICES, FACES = zoo.icosahedron()
LENGTHS = 2.0 / np.sqrt(10.0 + 2.0 * np.sqrt(5.0)) * 2.0


def text(rows):
    return "\n".join(" ".join(map(repr, row)) for row in np.asarray(rows).tolist()) + "\n"


def grid(cells="CELLS 20 80", sizes=True):
    rows = np.insert(FACES, 0, 3, axis=1) if sizes else FACES
    head = (
        f"# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n{text(VERTICES)}"
    )
    return f"{head}{cells}\n{text(rows)}\nCELL_TYPES 20\n{text([[5]] * 20)}"


def binary_polydata():
    """With what ParaView writes beside the polygons: offsets, metadata, colors."""
    parts = [b"# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET POLYDATA\nPOINTS 12 float\n"]
    parts += [VERTICES.astype(">f4").tobytes(), b"\nMETADATA\nINFORMATION 0\n\n"]
    parts += [b"POLYGONS 21 60\nOFFSETS vtktypeint64\n", np.arange(0, 61, 3, dtype=">i8").tobytes()]
    parts += [b"\nCONNECTIVITY vtktypeint64\n", FACES.astype(">i8").tobytes()]
    parts += [b"\nCELL_DATA 20\nCOLOR_SCALARS c 3\n", bytes(range(60)), b"\nPOINT_DATA 12\nSCALARS s short\n"]
    parts += [b"LOOKUP_TABLE t\n", np.arange(12, dtype=">i2").tobytes(), b"\nLOOKUP_TABLE t 2\n", bytes(8)]
    parts += [
        b"\nNORMALS n double\n",
        VERTICES.astype(">f8").tobytes(),
        b"\nFIELD FieldData 1\nMETADATA\nx\n\n",
    ]
    parts += [b"pair 2 12 int\n", np.arange(24, dtype=">i4").tobytes(), b"\n"]
    return b"".join(parts)


def test_text(tmp_path):
    path = tmp_path / "a.vtk"
    path.write_text(grid())
    expected = read_metric(path)
    assert expected.triangulation.n_vertices == 12
    np.testing.assert_array_equal(expected.faces, FACES)
    write(path, {"vertices": VERTICES, "faces": FACES})
    np.testing.assert_array_equal(read_metric(path).lengths, expected.lengths)


def test_binary_polydata_with_all_kinds_of_data(tmp_path):
    path = tmp_path / "a.vtk"
    path.write_bytes(binary_polydata())
    with InputFile(path) as file:
        data = read_polydata(file)
    np.testing.assert_array_equal(data.points, VERTICES.astype("f4"))
    np.testing.assert_array_equal(data.polygons, FACES)
    assert {name: values.shape for name, values in data.fields.items()} == {
        "s": (12,),
        "n": (12, 3),
        "pair": (12, 2),
    }
    np.testing.assert_array_equal(data.fields["pair"][3], [6, 7])
    assert read_metric(path).triangulation.n_faces == 20


def test_vectors_time_and_iteration_are_written(tmp_path):
    path = tmp_path / "a.vtk"
    tables = {"vertices": VERTICES, "faces": FACES, "s": VERTICES[:, 0], "v": 2.0 * VERTICES}
    write(path, {**tables, "time": 1.5, "iteration": 1024})
    assert (
        path.read_bytes()
        .split(b"POINTS")[0]
        .endswith(
            b"DATASET UNSTRUCTURED_GRID\nFIELD FieldData 2\nTIME 1 1 double\n"
            + np.array(1.5, ">f8").tobytes()
            + b"\nCYCLE 1 1 double\n"
            + np.array(1024.0, ">f8").tobytes()
            + b"\n"
        )
    )
    with InputFile(path) as file:
        data = read_polydata(file)
    assert sorted(data.fields) == ["s", "v"]
    np.testing.assert_array_equal(data.fields["v"], 2.0 * VERTICES)
    np.testing.assert_array_equal(data.points, VERTICES)


@pytest.mark.parametrize(
    ("change", "error", "sentence"),
    [
        (("ASCII", "UTF-8"), FileError, "neither ASCII nor BINARY"),
        (("UNSTRUCTURED_GRID", "STRUCTURED_GRID"), FileError, "none of POLYDATA and UNSTRUCTURED_GRID"),
        (("12 double", "12 words"), FileError, "the points are of the type 'words', which is not known"),
        (
            ("POINTS 12", "POINTS 13"),
            FileError,
            "among the points, could not convert string to float: 'CELLS'",
        ),
        (("CELLS 20 80", "CELLS 20 90"), FileError, "among the CELLS, could not convert"),
        (("CELLS 20 80", "CELLS 21 80"), FileError, "80 numbers are not enough for 21 CELLS"),
        (("CELL_TYPES 20\n5\n", "CELL_TYPES 19\n"), FileError, "has 20 cells, but the types of 19"),
        (("CELL_TYPES 20\n5", "CELL_TYPES 20\n22"), InvalidMetric, "cell 0 is a cell of type 22, not a tri"),
        (("CELL_TYPES 20\n5", "CELL_TYPES 20\nnan"), InvalidMetric, "cell 0 is a cell of type nan"),
        (("\n3 ", "\n5 "), FileError, "80 numbers are not enough for 20 CELLS|not made of the 12 points"),
        (("POINTS 12 double", "POINTS 12"), FileError, "the line before byte .* ends early"),
    ],
)
def test_malformed(change, error, sentence, tmp_path):
    path = tmp_path / "a.vtk"
    path.write_text(grid().replace(*change, 1))
    with pytest.raises(error, match=sentence):
        read_metric(path)


@pytest.mark.parametrize("kind", ["text", "written", "polydata"])
def test_damaged_files(kind, tmp_path):
    path = tmp_path / "a.vtk"
    write(path, {"vertices": VERTICES, "faces": FACES, "residual": VERTICES[:, 0]})
    data = {"text": grid().encode(), "written": path.read_bytes(), "polydata": binary_polydata()}[kind]
    assert refusals(path, data) > 100


@pytest.mark.parametrize("version", ["4.2", "5.1"])
@pytest.mark.parametrize("binary", [True, False])
def test_files_of_meshio(version, binary, tmp_path, capsys):
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(VERTICES, [("triangle", FACES)], point_data={"z": VERTICES[:, 2]})
    meshio.vtk.write(tmp_path / "a.vtk", mesh, fmt_version=version, binary=binary)
    with InputFile(tmp_path / "a.vtk") as file:
        data = read_polydata(file)
    np.testing.assert_array_equal(data.points, VERTICES)
    np.testing.assert_array_equal(data.polygons, FACES)
    np.testing.assert_array_equal(data.fields["z"], VERTICES[:, 2])


def polydata(binary, version):
    """A cube: a strip around it, a square on top, two triangles below, texture coordinates, and a line."""
    points = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    parts = [
        f"# vtk DataFile Version {version}\n\n{'BINARY' if binary else 'ASCII'}\nDATASET POLYDATA\n".encode()
    ]

    def put(line, values, kind):
        parts.append(line.encode() + b"\n")
        content = np.asarray(values).astype(kind)
        parts.append(content.tobytes() + b"\n" if binary else text(content.reshape(1, -1)).encode())

    put("POINTS 8 float", points, ">f4")
    for name, cells in (
        ("LINES", [[0, 1]]),
        ("POLYGONS", [[1, 3, 7, 5], [0, 4, 2], [4, 6, 2]]),
        ("TRIANGLE_STRIPS", [[0, 1, 4, 5, 6, 7, 2, 3, 0, 1]]),
    ):
        flat = np.concatenate(cells)
        if version == "5.1":
            parts.append(f"{name} {len(cells) + 1} {len(flat)}\n".encode())
            put("OFFSETS vtktypeint64", np.cumsum([0, *map(len, cells)]), ">i8")
            put("CONNECTIVITY vtktypeint64", flat, ">i8")
        else:
            rows = np.concatenate([[len(cell), *cell] for cell in cells])
            put(f"{name} {len(cells)} {len(rows)}", rows, ">i4")
    parts.append(b"POINT_DATA 8\n")
    put("TEXTURE_COORDINATES TCoords 2 float", np.zeros(16), ">f4")
    return b"".join(parts)


@pytest.mark.parametrize("version", ["3.0", "5.1"])
@pytest.mark.parametrize("binary", [True, False])
def test_strips_and_polygons_of_polydata(binary, version, tmp_path):
    (tmp_path / "a.vtk").write_bytes(polydata(binary, version))
    metric = read_metric(tmp_path / "a.vtk")
    assert metric.triangulation.n_faces == 12
    np.testing.assert_allclose(np.unique(np.round(metric.lengths**2, 12)), [1, 2])


@pytest.mark.parametrize("version", ["3.0", "5.1"])
def test_damaged_polydata(version, tmp_path):
    assert refusals(tmp_path / "a.vtk", polydata(True, version)) > 40


@pytest.mark.parametrize("word", [b"0.5.5", b"0.5\xa05", b"0.5\x855"])
def test_a_word_that_is_no_single_number(word, tmp_path):
    text = (
        b"# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 1 " + word + b"\n"
    )
    (tmp_path / "a.vtk").write_bytes(text)
    with pytest.raises(FileError, match="among the points, could not convert string to float"):
        read_metric(tmp_path / "a.vtk")


def test_bytes_that_are_no_numbers_are_refused_without_a_warning(tmp_path):
    signaling = np.array([0x7F800001], ">u4").tobytes()
    head = b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n"
    (tmp_path / "a.vtk").write_bytes(
        head + 9 * signaling + b"\nPOLYGONS 1 4\n" + np.array([3, 0, 1, 2], ">i4").tobytes()
    )
    with pytest.raises(InvalidMetric, match="not finite"):
        read_metric(tmp_path / "a.vtk")


def test_a_million_million_points_in_a_short_file(tmp_path):
    for kind in ("ASCII", "BINARY"):
        head = f"# vtk DataFile Version 3.0\nt\n{kind}\nDATASET POLYDATA\nPOINTS {10**12} double\n0 0 0\n"
        (tmp_path / "a.vtk").write_text(head)
        with pytest.raises(FileError, match="ends after"):
            read_metric(tmp_path / "a.vtk")
