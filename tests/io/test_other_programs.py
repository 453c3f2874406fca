"""Files as other programs write them, by the descriptions of their formats: all are one tetrahedron."""

import base64
import json
import struct
import zlib

import numpy as np
import pytest

from isoembed.errors import InvalidMetric, MeshNote
from isoembed.io import FileError, read_metric
from places import SHARED

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
LENGTHS = np.sqrt([1, 4, 5, 9, 10, 13])  # sorted: formats number vertices in their own ways

XYZ = ["{:g} {:g} {:g}".format(*p) for p in POINTS]
V = "\n".join(XYZ)
ONES = ["{} {} {}".format(*(f + 1)) for f in FACES]
TRIPLES = "\n".join("3 {} {} {}".format(*f) for f in FACES)

FACET = (
    "facet normal 0 0 0\n  outer loop\n" + 3 * "    vertex {:.6e} {:.6e} {:.6e}\n" + "  endloop\nendfacet\n"
)
STL = "solid name\n" + "".join(FACET.format(*POINTS[f].ravel()) for f in FACES) + "endsolid name\n"


def binary_stl(header=b"", attribute=0, rest=b""):
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *POINTS[f].ravel(), attribute) for f in FACES)
    return header.ljust(80, b" ") + struct.pack("<I", 4) + rows + rest


def obj(faces, vertices=None, before="", between=""):
    return (
        before + "".join(f"v {x}\n" for x in vertices or XYZ) + between + "".join(f"f {f}\n" for f in faces)
    )


def ply(order="ascii", count="uchar", index="int", name="vertex_indices", extra=False):
    codes = {"uchar": "B", "int": "i", "uint": "I", "ushort": "H"}
    kind = "ascii" if order == "ascii" else f"binary_{order}_endian"
    head = f"ply\nformat {kind} 1.0\ncomment made by hand\nobj_info none\nelement vertex 4\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += "property uchar red\nproperty float nx\n" if extra else ""
    head += f"element face 4\nproperty list {count} {index} {name}\n"
    head += "property list uchar float texcoord\n" if extra else ""
    head = (head + "end_header\n").encode()
    if order == "ascii":
        tail = [" 255 0.5", " 6 0 0 1 0 0 1"] if extra else ["", ""]
        rows = [*(x + tail[0] for x in XYZ), *(f + tail[1] for f in TRIPLES.splitlines())]
        return head + "\n".join(rows).encode() + b"\n"
    sign = "<" if order == "little" else ">"
    body = b"".join(
        struct.pack(sign + "3f", *p) + (struct.pack(sign + "Bf", 9, 1) if extra else b"") for p in POINTS
    )
    for f in FACES:
        body += struct.pack(sign + codes[count] + 3 * codes[index], 3, *f)
        body += struct.pack(sign + "B6f", 6, *6 * [0.5]) if extra else b""
    return head + body


STRIPS = (
    f"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    f"element tristrips 1\nproperty list int int vertex_indices\nend_header\n{V}\n9 0 1 2 3 -1 2 3 0 1\n"
)


def with_columns(names, numbers, faces="element face 4\nproperty list uchar uint vertex_indices\n", rest=""):
    """A text PLY file with further columns and elements."""
    columns = "".join(f"property float {axis}\n" for axis in "xyz")
    columns += "".join(f"property {name}\n" for name in names)
    rows = "\n".join(f"{x} {numbers}" for x in XYZ)
    head = f"ply\nformat ascii 1.0\nelement vertex 4\n{columns}{faces}end_header\n"
    return f"{head}{rows}\n{TRIPLES}\n{rest}"


BLENDER = ["float nx", "float ny", "float nz", *(f"uchar {c}" for c in ("red", "green", "blue", "alpha"))]
EDGES = "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
FACES_FIRST = (
    "ply\nformat ascii 1.0\nelement face 4\nproperty list uchar int vertex_indices\nelement vertex 4\n"
    f"property double x\nproperty double y\nproperty double z\nend_header\n{TRIPLES}\n{V}\n"
)
BINARY_STRIPS = (
    b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    + POINTS.astype(">f4").tobytes() + struct.pack(">10i", 9, 0, 1, 2, 3, -1, 2, 3, 0, 1)
)  # fmt: skip


def vtk(version, cells, binary=False, kind="POLYDATA", after=""):
    head = f"# vtk DataFile Version {version}\nname\n{'BINARY' if binary else 'ASCII'}\nDATASET {kind}\n"
    points = POINTS.astype(">f4").tobytes() if binary else V.encode()
    return (head + "POINTS 4 float\n").encode() + points + b"\n" + cells + after.encode()


POLYGONS = f"POLYGONS 4 16\n{TRIPLES}\n".encode()
BINARY_POLYGONS = b"POLYGONS 4 16\n" + np.insert(FACES, 0, 3, axis=1).astype(">i4").tobytes() + b"\n"
CORNERS = " ".join(map(str, FACES.ravel()))
OFFSETS = f"POLYGONS 5 12\nOFFSETS vtktypeint64\n0 3 6 9 12\nCONNECTIVITY vtktypeint64\n{CORNERS}\n".encode()
BINARY_OFFSETS = (
    b"POLYGONS 5 12\nOFFSETS vtktypeint64\n" + np.arange(0, 13, 3).astype(">i8").tobytes()
    + b"\nCONNECTIVITY vtktypeint64\n" + FACES.astype(">i8").tobytes() + b"\n"
)  # fmt: skip
CELLS = f"CELLS 4 16\n{TRIPLES}\nCELL_TYPES 4\n5 5 5 5\n"
CELL_DATA = (
    "CELL_DATA 4\nSCALARS area double 1\nLOOKUP_TABLE default\n1 2 3 4\nNORMALS n float\n" + 4 * "0 0 1\n"
)
METADATA = "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"


def vtk_xml(kind, how, packed=False, header="UInt32"):
    """A .vtp or .vtu file: ascii, base64, or appended raw or in base64."""
    size = {"UInt32": "<u4", "UInt64": "<u8"}[header]
    arrays = [POINTS, FACES, 3 * np.arange(1, 5), np.full(4, 5)]
    names = [("Points", "Float64"), ("connectivity", "Int64"), ("offsets", "Int64"), ("types", "UInt8")]
    elements, appended = [], b""
    for array, (name, code) in zip(arrays, names, strict=True):
        content = array.astype({"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[code]).tobytes()
        start = np.array([len(content)], size).tobytes()
        if packed:
            squeezed = zlib.compress(content)
            start, content = np.array([1, len(content), 0, len(squeezed)], size).tobytes(), squeezed
        encoded = base64.b64encode(start) + base64.b64encode(content)
        if not packed:
            encoded = base64.b64encode(start + content)
        what, text = f'format="{"binary" if how == "base64" else how}"', encoded.decode()
        if how == "ascii":
            text = " ".join(map(str, array.ravel().tolist()))
        elif how.startswith("appended"):
            what, text = f'format="appended" offset="{len(appended)}"', ""
            appended += encoded if how == "appended64" else start + content
        elements.append(f'<DataArray type="{code}" Name="{name}" {what}>{text}</DataArray>')
    is_grid = kind == "UnstructuredGrid"
    cells = "Cells" if is_grid else "Polys"
    last = 4 if is_grid else 3
    squeezer = ' compressor="vtkZLibDataCompressor"' if packed else ""
    document = (
        f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" '
        f'header_type="{header}"{squeezer}><{kind}><Piece NumberOfPoints="4" '
        f'NumberOf{cells}="4"><Points>{elements[0]}</Points><{cells}>{"".join(elements[1:last])}'
        f"</{cells}></Piece></{kind}>"
    ).encode()
    if appended:
        encoding = b"base64" if how == "appended64" else b"raw"
        document += b'<AppendedData encoding="' + encoding + b'">_' + appended + b"</AppendedData>"
    return document + b"</VTKFile>"


def glb(code="<u2", parts=1, stride=12, sparse=False, embedded=False):
    """A .glb, or a .gltf with its buffer in it: several primitives, a stride, positions given sparsely."""
    component = {"<u1": 5121, "<u2": 5123, "<u4": 5125}[code]
    points = POINTS.copy()
    if sparse:
        points[3] = 0
    buffer = b"".join(struct.pack("<3f", *p).ljust(stride, b"\0") for p in points)
    views = [{"buffer": 0, "byteLength": len(buffer), "byteStride": stride}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}]
    if sparse:
        views += [{"buffer": 0, "byteOffset": len(buffer) + k, "byteLength": n} for k, n in ((0, 4), (4, 12))]
        buffer += struct.pack("<I3f", 3, *POINTS[3])
        accessors[0]["sparse"] = {
            "count": 1,
            "indices": {"bufferView": 1, "componentType": 5125},
            "values": {"bufferView": 2},
        }
    primitives = []
    for some in np.array_split(FACES, parts):
        content = some.astype(code).tobytes()
        primitives.append({"attributes": {"POSITION": 0}, "indices": len(accessors), "mode": 4})
        accessors.append(
            {"bufferView": len(views), "componentType": component, "count": some.size, "type": "SCALAR"}
        )
        views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(content)})
        buffer += content + bytes(-len(content) % 4)
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    document |= {"meshes": [{"primitives": primitives}], "accessors": accessors, "bufferViews": views}
    document["buffers"] = [{"byteLength": len(buffer)}]
    if embedded:
        uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
        document["buffers"][0]["uri"] = uri
        return json.dumps(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


OFF_TWO = f"# antiprism\n4 4 6 # counts\n{V}\n{TRIPLES}\n"
COLORED = "\n".join(f"{x} 255 0 0 255" for x in XYZ)
NORMALS = "\n".join(f"{x} 0 0 1" for x in XYZ)
TEXTURED = "\n".join(f"{x} 0.5 0.5" for x in XYZ)

CASES = {
    "OpenSCAD.stl": STL.replace(".000000e+00", "").replace("name", "OpenSCAD_Model"),
    "uppercase.stl": STL.upper(),
    "mixed.stl": STL.title(),
    "bom.stl": "\ufeff" + STL,
    "bom-uppercase.stl": "\ufeff" + STL.upper(),
    "cr.stl": STL.replace("\n", "\r"),
    "crlf-tabs.stl": STL.replace("\n", "\r\n").replace("  ", "\t"),
    "no-name.stl": STL.replace(" name", ""),
    "two-solids.stl": STL[: STL.index("facet normal", 40)] + "endsolid name\nsolid two\n"
    + STL[STL.index("facet normal", 40) :],
    "a-solid-each.stl": "".join(
        f"solid part {k}\n{FACET.format(*POINTS[f].ravel())}endsolid part {k}\n" for k, f in enumerate(FACES)
    ),
    "solid-and-zeros.stl": binary_stl(b"solid\0part"),
    "Blender.stl": binary_stl(b"Exported from Blender-4.2"),
    "SolidWorks.stl": binary_stl(b"solid part; exported by SolidWorks"),
    "VisCAM-color.stl": binary_stl(b"COLOR=\xff\x80\x00\xff", attribute=0x8FFF),
    "one-byte-more.stl": binary_stl(rest=b"\n"),
    "solid-and-one-byte-more.stl": binary_stl(b"solid part", rest=b"\n"),
    "footer.stl": binary_stl(b"MeshLab", rest=bytes(300)),
    "plain.obj": obj(ONES),
    "Meshmixer.obj": obj(ONES, [f"{x} 0.5 0.5 1" for x in XYZ], before="# Meshmixer\nmtllib a.mtl\n"),
    "negative.obj": obj(["-4 -2 -3", "-4 -3 -1", "-3 -2 -1", "-4 -1 -2"]),
    "negative-groups.obj": "g all\n" + "".join(f"v {x}\n" for x in XYZ)
    + "g a\ns off\nf -4//1 -2//1 -3//1\ng b c\nf -4 -3 -1\no x\nf -3 -2 -1\nf -4 -1 -2\n",
    "faces-between.obj": "v 0 0 0\nv 1 0 0\nv 0 2 0\nf -3 -1 -2\nv 0 0 3\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
    "continued-twice.obj": obj(ONES).replace("f 1 3 2", "f 1\\\n 3\\\n 2"),
    "normals.obj": obj([" ".join(f"{c}//1" for c in f.split()) for f in ONES], between="vn 0 0 1\n"),
    "Maya.obj": obj(
        [" ".join(f"{c}/1/1" for c in f.split()) for f in ONES],
        before="# Maya\ng default\n",
        between="vt 0 0\nvn 0 0 1\ns 1\ng body\nusemtl lambert1\n",
    ),
    "Houdini.obj": obj(ONES, [f"{x} 1.0" for x in XYZ], between="g\n").replace("\n", "\r\n"),
    "continued.obj": obj(ONES).replace("f 1 3 2", "f 1 \\\n3 2").replace("v 0 2 0", "v 0 \\\n 2 0"),
    "continued-crlf.obj": obj(ONES).replace("f 1 3 2", "f 1 \\\n3 2").replace("\n", "\r\n"),
    "lines-and-points.obj": obj(ONES) + "l 1 2\np 3\no other\n",
    "bom.obj": "\ufeff" + obj(ONES),
    "cr.obj": obj(ONES).replace("\n", "\r"),
    "geomview.off": f"OFF\n{OFF_TWO}",
    "CGAL.off": f"OFF\n4 4 0\n\n{V}\n\n{TRIPLES}\n",
    "one-line.off": f"OFF 4 4 6\n{V}\n{TRIPLES}\n",
    "edges.off": f"OFF\n4 6 6\n{V}\n{TRIPLES}\n2 0 1\n1 3\n",
    "MeshLab-colors.off": f"COFF\n4 4 6\n{COLORED}\n{TRIPLES}\n",
    "colors-normals.off": f"CNOFF\n4 4 6\n{NORMALS.replace('0 0 1', '0 0 1 255 0 0 255')}\n{TRIPLES}\n",
    "normals.off": f"NOFF\n4 4 6\n{NORMALS}\n{TRIPLES}\n",
    "textures.off": f"STOFF\n4 4 6\n{TEXTURED}\n{TRIPLES}\n",
    "all.off": f"STCNOFF\n4 4 6\n{V}\n{TRIPLES}\n",
    "face-colors.off": f"OFF\n4 4 6\n{V}\n" + TRIPLES.replace("\n", " 0.1 0.2 0.3\n") + " 7\n",
    "comments.off": f"# a\nOFF # b\n#\n4 4 6 # c\n{V.replace('1 0 0', '1 0 0 # d')}\n# e\n{TRIPLES}\n",
    "bom-crlf.off": "\ufeff" + f"OFF\n{OFF_TWO}".replace("\n", "\r\n"),
    "ascii.ply": ply(),
    "ascii-extra.ply": ply(extra=True, name="vertex_index"),
    "little.ply": ply("little"),
    "big.ply": ply("big", "int", "uint", "vertex_index"),
    "little-extra.ply": ply("little", "uint", "ushort", extra=True),
    "big-extra.ply": ply("big", "uchar", "uchar", "vertex_index", extra=True),
    "strips.ply": STRIPS,
    "strips-big.ply": BINARY_STRIPS,
    "Blender.ply": with_columns([*BLENDER, "float s", "float t"], "0 0 1 255 128 0 255 0.5 0.5"),
    "MeshLab-edges.ply": with_columns(
        ["int flags"], "0", f"element face 4\nproperty list uchar int vertex_indices\n{EDGES}", "0 1\n1 2\n"
    ),
    "faces-first.ply": FACES_FIRST,
    "crlf.ply": ply().replace(b"\n", b"\r\n"),
    "polydata-3.vtk": vtk("3.0", POLYGONS),
    "polydata-2.vtk": vtk("2.0", POLYGONS, after=CELL_DATA),
    "polydata-4.vtk": vtk("4.2", METADATA.encode() + POLYGONS, after=CELL_DATA),
    "polydata-5.vtk": vtk("5.1", OFFSETS, after=CELL_DATA),
    "crlf.vtk": vtk("3.0", POLYGONS, after=CELL_DATA).replace(b"\n", b"\r\n"),
    "crlf-5.vtk": vtk("5.1", OFFSETS, after=CELL_DATA).replace(b"\n", b"\r\n"),
    "vertices-and-lines.vtk": vtk("3.0", b"VERTICES 2 4\n1 0\n1 1\nLINES 1 3\n2 0 1\n" + POLYGONS),
    "strips.vtk": vtk("3.0", b"TRIANGLE_STRIPS 2 10\n4 0 1 2 3\n4 2 3 0 1\n"),
    "ParaView-ids.vtk": vtk("3.0", POLYGONS, after="POINT_DATA 4\nGLOBAL_IDS ids vtkIdType\n0 1 2 3\n"),
    "binary-3.vtk": vtk("3.0", BINARY_POLYGONS, True),
    "binary-5.vtk": vtk("5.1", BINARY_OFFSETS, True),
    "grid.vtk": vtk("3.0", CELLS.encode(), kind="UNSTRUCTURED_GRID"),
    **{
        f"{how}{'-zlib' * packed}-{header}{ending}": vtk_xml(kind, how, packed, header)
        for kind, ending in (("PolyData", ".vtp"), ("UnstructuredGrid", ".vtu"))
        for how, packed, header in (
            ("ascii", False, "UInt32"),
            ("base64", False, "UInt64"),
            ("base64", True, "UInt32"),
            ("appended", False, "UInt64"),
            ("appended", True, "UInt64"),
            ("appended64", True, "UInt32"),
        )
    },
    "u8.glb": glb("<u1"),
    "u16-stride.glb": glb("<u2", stride=24),
    "u32-primitives.glb": glb("<u4", parts=3),
    "sparse.glb": glb(sparse=True),
    "embedded.gltf": glb(embedded=True),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_it_is_read(name, tmp_path):
    content = CASES[name]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    metric = read_metric(tmp_path / name)
    assert metric.triangulation.n_vertices == 4
    np.testing.assert_allclose(np.sort(metric.lengths), LENGTHS, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("part.step", "ISO-10303-21;", "open it with FreeCAD, and export it as .stl or .obj"),
        ("part.IGS.gz", "", "open it with FreeCAD"),
        ("scene.blend", "", "open it with Blender"),
        ("part.amf", "", "open it with PrusaSlicer"),
        ("short.stl", binary_stl()[:-1], "binary STL, which would have 4 triangles in 284 bytes"),
        ("t.off", f"4OFF\n4 4 6\n{V}\n", "does not begin with OFF"),
    ],
)
def test_it_is_refused_with_a_way_out(name, content, sentence, tmp_path):
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises((FileError, InvalidMetric), match=sentence):
        read_metric(tmp_path / name)


@pytest.mark.parametrize("index", ["inf", "nan", "1e300", "0.5"])
def test_strips_of_what_are_no_indices(index, tmp_path):
    (tmp_path / "strips.ply").write_text(
        STRIPS.replace("int int", "int float").replace("0 1\n", f"0 {index}\n")
    )
    with pytest.raises(InvalidMetric, match=r"whole numbers|too large"):
        read_metric(tmp_path / "strips.ply")


@pytest.mark.shared
@pytest.mark.parametrize("name", ["binary_with_newline_at_end", "bom", "cr_line_ends", "uppercase"])
def test_cubes_of_other_programs(name):
    metric = read_metric(SHARED / "trials" / "numbers" / f"07_{name}.stl")
    assert metric.triangulation.n_vertices == 8


@pytest.mark.shared
def test_off_with_an_edge():
    metric = read_metric(SHARED / "trials" / "numbers" / "08_explicit_edge.off")
    assert metric.triangulation.n_vertices == 8


@pytest.mark.shared
def test_a_collinear_triangle():
    path = SHARED / "trials" / "numbers" / "11_collinear_triangle.obj"
    with pytest.raises(InvalidMetric, match="vertex 8 is on the side from vertex 0 to vertex 1"):
        read_metric(path)
    with pytest.warns(MeshNote, match="split"), pytest.warns(MeshNote, match="1 triangle without area"):
        assert read_metric(path, merge=1e-5).triangulation.n_vertices == 9


@pytest.mark.shared
def test_points_that_lost_a_number():
    with pytest.raises(FileError, match="among the points, could not convert"):
        read_metric(SHARED / "trials" / "numbers" / "13_damaged_points.vtk")
