"""VTP files: polygons and strips, in the encodings that `test_vtu` tests; and VTK's own layouts of them."""

import base64
import zlib

import numpy as np
import pytest

import zoo
from damage import refusals
from isoembed.io import FileError, read_metric
from isoembed.io.metric import read_tables

CUBE = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
# Around the cube; and the bottom and the top, one as polygons of both sizes.
STRIP = [0, 1, 4, 5, 6, 7, 2, 3, 0, 1]
TOP = [[1, 3, 7, 5], [0, 4, 2], [4, 6, 2]]
BOUNDS = np.sqrt(2)


def array(name, values, form, appended):
    kind, code = {"f": ("Float32", "<f4"), "i": ("Int64", "<i8")}[np.asarray(values).dtype.kind]
    content = np.asarray(values).astype(code).tobytes()
    packed = zlib.compress(content)
    header = np.array([1, 32768, len(content), len(packed)] if content else [0], "<u4").tobytes()
    begin = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="3" format='
    end = '<InformationKey name="L2_NORM_RANGE"><Value index="0">1</Value></InformationKey></DataArray>'
    if form == "ascii":
        return f'{begin}"ascii">\n{" ".join(map(repr, np.ravel(values).tolist()))}\n{end}'
    if form == "binary":
        text = base64.b64encode(header).decode() + base64.b64encode(packed if content else b"").decode()
        return f'{begin}"binary">\n {text}\n {end}'
    place = sum(map(len, appended))
    appended.append(header + (packed if content else b""))
    return f'{begin}"appended" offset="{place}"/>'


def document(form, polygons=TOP, strips=(STRIP,), pieces=1, points=CUBE):
    appended = []
    body = [array("Points", points.ravel(), form, appended)]
    for kind, cells in (("Verts", []), ("Polys", polygons), ("Strips", strips)):
        corners = np.concatenate([*cells, []]).astype(int)
        arrays = [array("connectivity", corners, form, appended)]
        arrays.append(array("offsets", np.cumsum([len(cell) for cell in cells]).astype(int), form, appended))
        body.append(f"<{kind}>{''.join(arrays)}</{kind}>")
    head = f'<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(polygons)}" '
    head += f'NumberOfStrips="{len(strips)}"><PointData/><Points>{body[0]}</Points>'
    text = '<VTKFile type="PolyData" byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><PolyData>'
    text += pieces * (head + "".join(body[1:]) + "</Piece>") + "</PolyData>"
    data = text.encode()
    if appended:
        data += b'<AppendedData encoding="raw">_' + b"".join(appended) + b"</AppendedData>"
    return data + b"</VTKFile>"


@pytest.mark.parametrize("form", ["ascii", "binary", "appended"])
def test_polygons_and_strips(form, tmp_path):
    path = tmp_path / "a.vtp"
    path.write_bytes(document(form))
    metric = read_metric(path)
    assert metric.triangulation.n_faces == 12
    assert set(np.round(metric.lengths**2, 12)) == {1, 2}


def test_polygons_alone_stay_one_table(tmp_path):
    vertices, faces = zoo.icosahedron()
    (tmp_path / "a.vtp").write_bytes(document("binary", faces.tolist(), (), points=vertices))
    tables = read_tables(tmp_path / "a.vtp")
    np.testing.assert_array_equal(tables["faces"], faces)
    np.testing.assert_array_equal(tables["vertices"], vertices.astype("f4"))


def test_pieces_follow_one_another(tmp_path):
    (tmp_path / "a.vtp").write_bytes(document("ascii", pieces=2))
    assert read_tables(tmp_path / "a.vtp")["faces"].max() == 15


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (document("ascii").replace(b"PolyData", b"ImageData"), "there is no Piece of a PolyData"),
        (document("ascii", [[0, 1, 8]]), "number 0 of the POLYGONS is not made of the 8 points"),
        (
            document("ascii", strips=[[0, 1, 8]]),
            "number 0 of the TRIANGLE_STRIPS is not made",
        ),
        (document("ascii").replace(b'"offsets"', b'"ends"'), "there is no Polys/DataArray"),
        (
            document("ascii").replace(b'Polys="3"', b'Polys="x"'),
            "is not a readable VTP file: invalid",
        ),
        (b"hello", "is not a readable VTP file"),
    ],
)
def test_malformed(data, sentence, tmp_path):
    (tmp_path / "a.vtp").write_bytes(data)
    with pytest.raises(FileError, match=sentence):
        read_metric(tmp_path / "a.vtp")


@pytest.mark.parametrize("form", ["ascii", "binary", "appended"])
def test_damaged_files(form, tmp_path):
    assert refusals(tmp_path / "a.vtp", document(form)) > 100
