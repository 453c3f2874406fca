"""VTU files in all their encodings: of others, of meshio, and damaged ones."""

import base64
import lzma
import re
import zlib

import numpy as np
import pytest

import zoo
from damage import refusals
from isoembed.errors import InvalidMetric
from isoembed.io import FileError, InputFile, read_metric
from isoembed.io.vtu import read, write

VERTICES, FACES = zoo.icosahedron()
COMPRESS = {"": None, "vtkZLibDataCompressor": zlib.compress, "vtkLZMADataCompressor": lzma.compress}


def block(content, compressor, encoded, order="<"):
    """An array with its header, in blocks of 200 bytes if they are compressed."""
    code = base64.b64encode if encoded else bytes
    pack = COMPRESS[compressor]
    if pack is None:
        return code(np.array([len(content)], order + "u8").tobytes() + content)
    parts = [pack(content[k : k + 200]) for k in range(0, len(content), 200)]
    header = np.array([len(parts), 200, len(content) % 200, *map(len, parts)], order + "u8")
    return code(header.tobytes()) + code(b"".join(parts))


def document(form, compressor="", order="<", cells=FACES, kind=5, pieces=1):
    """A file in which all arrays are of one form: ascii, binary, or appended in base64 or raw."""
    ends = np.arange(1, len(cells) + 1) * cells.shape[1]
    types = np.full(len(cells), kind)
    appended = b""
    elements = []
    for name, type_name, code, array in (
        ("", "Float64", "f8", VERTICES),
        ("connectivity", "Int32", "i4", cells),
        ("offsets", "Int64", "i8", ends),
        ("types", "UInt8", "u1", types),
    ):
        content = array.astype(order + code).tobytes()
        where, inside = form, b""
        if form == "ascii":
            inside = " ".join(map(repr, array.ravel().tolist())).encode()
        elif form == "binary":
            inside = b"\n  " + block(content, compressor, True, order) + b"\n"
        else:
            where = f'appended" offset="{len(appended)}'
            appended += block(content, compressor, form == "base64", order)
        head = f'<DataArray type="{type_name}" Name="{name}" NumberOfComponents="3" format="{where}">'
        elements.append(head.encode() + inside + b"</DataArray>")
    order_name = "LittleEndian" if order == "<" else "BigEndian"
    head = f'<VTKFile type="UnstructuredGrid" byte_order="{order_name}" header_type="UInt64"'
    head += f' compressor="{compressor}">' if compressor else ">"
    piece = b'<Piece NumberOfPoints="12" NumberOfCells="20"><Points>' + elements[0] + b"</Points><Cells>"
    piece += b"".join(elements[1:]) + b"</Cells></Piece>"
    text = head.encode() + b"<UnstructuredGrid>" + pieces * piece + b"</UnstructuredGrid>"
    if appended:
        text += f'<AppendedData encoding="{form}">\n _'.encode() + appended + b"</AppendedData>"
    return text + b"</VTKFile>"


@pytest.mark.parametrize("compressor", COMPRESS)
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("form", ["ascii", "binary", "base64", "raw"])
def test_all_encodings(form, compressor, order, tmp_path):
    path = tmp_path / "a.vtu"
    path.write_bytes(document(form, compressor, order))
    with InputFile(path) as file:
        tables = read(file)
    np.testing.assert_array_equal(tables["vertices"], VERTICES)
    np.testing.assert_array_equal(tables["faces"], FACES)


def test_pieces_follow_one_another(tmp_path):
    path = tmp_path / "a.vtu"
    path.write_bytes(document("raw", pieces=2))
    with InputFile(path) as file:
        tables = read(file)
    np.testing.assert_array_equal(tables["faces"], np.concatenate([FACES, FACES + 12]))
    with pytest.raises(InvalidMetric):
        read_metric(path)


QUADS = np.arange(12).reshape(3, 4)


@pytest.mark.parametrize(
    ("data", "error", "sentence"),
    [
        (
            document("ascii", cells=QUADS, kind=9),
            InvalidMetric,
            r"face 0 \[0, 1, 2, 3\] cannot be cut into triangles",
        ),
        (document("ascii", cells=QUADS, kind=10), InvalidMetric, "cell 0 is a tetra, not a triangle"),
        (document("ascii", cells=FACES + 1), FileError, "of the cells is not made of the 12 points"),
        (document("raw").replace(b"UInt64", b"UInt65"), FileError, "its header_type 'UInt65' is not known"),
        (document("raw").replace(b"UInt64", b"Float64"), FileError, "its header_type 'Float64' is not known"),
        (document("raw").replace(b"UInt64", b"Int64"), FileError, "its header_type 'Int64' is not known"),
        (b'<?xml version="1.0" encoding="foo"?>' + document("ascii"), FileError, "unknown encoding: foo"),
        (
            document("raw", "vtkZLibDataCompressor").replace(b"ZLib", b"LZ4"),
            FileError,
            "'vtkLZ4DataCompressor'",
        ),
        (document("ascii").replace(b'"types"', b'"kinds"'), FileError, "no Cells/DataArray.@Name='types'"),
        (document("ascii").replace(b"Piece", b"Part"), FileError, "there is no Piece of an UnstructuredGrid"),
        (document("ascii").replace(b"VTKFile", b"Mesh"), FileError, "its root is Mesh, not VTKFile"),
        (document("base64")[:-60] + b"</AppendedData></VTKFile>", FileError, "an array ends after"),
        (
            document("raw").replace(b'offset="0"', b'offset="x"'),
            FileError,
            "is not a readable VTU file: invalid",
        ),
        (document("ascii")[:-3], FileError, "is not a readable VTU file: unclosed token"),
    ],
)
def test_malformed(data, error, sentence, tmp_path):
    (tmp_path / "a.vtu").write_bytes(data)
    with pytest.raises(error, match=sentence):
        read_metric(tmp_path / "a.vtu")


@pytest.mark.parametrize("form", ["ascii", "binary", "raw"])
def test_damaged_files(form, tmp_path):
    assert (
        refusals(tmp_path / "a.vtu", document(form, "" if form == "raw" else "vtkZLibDataCompressor")) > 200
    )


def test_a_size_that_is_not_there_is_not_allocated(tmp_path):
    path = tmp_path / "a.vtu"
    for compressor in ("", "vtkZLibDataCompressor"):
        data = document("raw", compressor)
        begin = data.index(b" _") + 2
        path.write_bytes(data[:begin] + np.array([2**62], "<u8").tobytes() + data[begin + 8 :])
        with pytest.raises(FileError, match="an array ends after"):
            read_metric(path)


def test_blocks_of_no_size_are_not_expanded(tmp_path):
    path = tmp_path / "a.vtu"
    data = document("raw", "vtkZLibDataCompressor")
    begin = data.index(b" _") + 2 + 8  # behind the number of blocks
    path.write_bytes(data[:begin] + bytes(8) + data[begin + 8 :])
    with pytest.raises(FileError, match="its blocks are of no size"):
        read_metric(path)


@pytest.mark.parametrize("options", [{}, {"compression": None}, {"compression": "lzma"}, {"binary": False}])
def test_files_of_meshio(options, tmp_path, capsys):
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(VERTICES, [("triangle", FACES)], point_data={"z": VERTICES[:, 2]})
    meshio.vtu.write(str(tmp_path / "a.vtu"), mesh, **options)
    with InputFile(tmp_path / "a.vtu") as file:
        tables = read(file)
    np.testing.assert_allclose(tables["vertices"], VERTICES, rtol=1e-11)
    np.testing.assert_array_equal(tables["faces"], FACES)


def test_paraview_finds_the_arrays_where_it_looks(tmp_path):
    path = tmp_path / "a.vtu"
    write(path, {"vertices": VERTICES, "faces": FACES, "residual": VERTICES[:, 0]})
    text = path.read_text()
    named = re.findall(r'type="(\w+)" Name="(\w+)"', text)
    assert named == [
        ("Float64", "Points"),
        ("Int64", "connectivity"),
        ("Int64", "offsets"),
        ("UInt8", "types"),
        ("Float64", "residual"),
    ]
    assert text.index("<PointData>") < text.index("residual") < text.index("</PointData>")
