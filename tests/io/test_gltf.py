"""glTF files: how triangles are packed, where nodes put them, and damaged ones."""

import base64
import json
import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import zoo
from damage import refusals
from isoembed import PolyhedralMetric
from isoembed.io import FileError, check_output, read_metric
from isoembed.io.metric import read_tables
from isoembed.io.registry import SURFACE_ENDINGS

VERTICES, FACES = zoo.icosahedron()
POINTS = VERTICES.astype("<f4")


def document(*arrays, mode=4, nodes=None, **more):
    """Objects and the binary buffer of one mesh: positions, then corners if there are any."""
    kinds = {"f4": 5126, "u1": 5121, "i1": 5120, "u2": 5123, "i2": 5122, "u4": 5125}
    accessors, views, data = [], [], b""
    for array in arrays:
        data += bytes(-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        kind = "VEC3" if array.ndim == 2 else "SCALAR"
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": kinds[array.dtype.str[1:]], "count": len(array)}
        )
        accessors[-1]["type"] = kind
        data += array.tobytes()
    primitive = {"attributes": {"POSITION": 0}, "mode": mode} | ({"indices": 1} if len(arrays) > 1 else {})
    root = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}] if nodes is None else nodes,
    }
    return root | more, data


def glb(root, data):
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def tables(path, root, data):
    path.write_bytes(glb(root, data))
    return read_tables(path)


def lengths(vertices, faces):
    return np.sort(PolyhedralMetric.from_mesh(vertices, faces).lengths)


@pytest.mark.parametrize("code", ["<u1", "<u2", "<u4"])
def test_indices_of_all_types(code, tmp_path):
    found = tables(tmp_path / "a.glb", *document(POINTS, FACES.astype(code).ravel()))
    np.testing.assert_array_equal(found["vertices"][found["faces"]], POINTS[FACES])


def test_vertices_apart_are_merged_by_default(tmp_path):
    (tmp_path / "a.glb").write_bytes(glb(*document(POINTS[FACES].reshape(-1, 3))))
    np.testing.assert_allclose(read_metric(tmp_path / "a.glb").lengths, 2.0, rtol=1e-6)


@pytest.mark.parametrize("where", ["inside", "beside", "zipped"])
def test_buffers_of_text_files(where, tmp_path):
    import gzip

    root, data = document(POINTS, FACES.astype("<u2").ravel())
    if where == "beside":
        (tmp_path / "a buffer.bin").write_bytes(data)
        root["buffers"][0]["uri"] = "a%20buffer.bin"
    else:
        root["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    text = json.dumps(root).encode()
    path = tmp_path / ("a.gltf.gz" if where == "zipped" else "a.gltf")
    path.write_bytes(gzip.compress(text) if where == "zipped" else text)
    np.testing.assert_allclose(read_metric(path).lengths, 2.0, rtol=1e-6)


def test_positions_a_stride_apart_and_sparse(tmp_path):
    rows = np.zeros(12, np.dtype([("normal", "<f4", 3), ("position", "<f4", 3), ("uv", "<u2", 2)]))
    rows["position"] = POINTS
    rows["position"][[3, 7]] = 9.0
    root, data = document(rows.view("<f4").reshape(-1, 1), FACES.astype("<u4").ravel())
    root["bufferViews"][0]["byteStride"] = 28
    root["accessors"][0] |= {"byteOffset": 12, "count": 12}
    begin = len(data)
    data += struct.pack("<HH", 3, 7) + POINTS[[3, 7]].tobytes()
    root["bufferViews"] += [
        {"buffer": 0, "byteOffset": begin + at, "byteLength": n} for at, n in ((0, 4), (4, 24))
    ]
    root["accessors"][0]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 3},
    }
    found = tables(tmp_path / "a.glb", root, data)
    np.testing.assert_array_equal(found["vertices"][found["faces"]], POINTS[FACES])


def test_whole_numbers_that_stand_for_fractions(tmp_path):
    octahedron, faces = zoo.octahedron()
    positions = np.round(127 * octahedron / np.abs(octahedron).max()).astype("i1")
    root, data = document(np.pad(positions, ((0, 0), (0, 1))), faces.astype("<u2").ravel())
    root["bufferViews"][0]["byteStride"] = 4
    root["accessors"][0]["normalized"] = True
    found = tables(tmp_path / "a.glb", root, data)
    np.testing.assert_allclose(lengths(**found), np.sqrt(2), rtol=1e-15)


@pytest.mark.parametrize(
    ("mode", "corners"), [(5, [0, 1, 2, 3, 0, 1]), (5, [0, 0, 0, 1, 2, 3, 0, 1]), (6, [0, 1, 2, 3, 1])]
)
def test_strips_and_fans(mode, corners, tmp_path):
    points = zoo.tetrahedron()[0].astype("<f4")
    root, data = document(points, np.array(corners, "<u2"), mode=mode)
    if mode == 6:  # the face across from the first vertex
        begin = len(data)
        data += np.array([1, 3, 2, 0], "<u2").tobytes()
        root["bufferViews"].append({"buffer": 0, "byteOffset": begin, "byteLength": 8})
        root["accessors"].append({"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"})
        root["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 2})
    (tmp_path / "a.glb").write_bytes(glb(root, data))
    np.testing.assert_allclose(read_metric(tmp_path / "a.glb").lengths, np.sqrt(8), rtol=1e-6)


def test_nodes_place_and_mirror_meshes(tmp_path):
    turn = Rotation.from_rotvec([0.3, -0.7, 0.2])
    scale, shift = np.array([1.5, 0.5, 2.0]), np.array([1.0, -2.0, 3.0])
    matrix = np.diag([-1.0, 1, 1, 1])
    matrix[:3, 3] = 4, 5, 6
    nodes = [
        {"children": [2], "matrix": matrix.T.ravel().tolist()},
        {"mesh": 0, "translation": [99, 0, 0]},
        {
            "mesh": 0,
            "rotation": turn.as_quat().tolist(),
            "scale": scale.tolist(),
            "translation": shift.tolist(),
        },
    ]
    parts = {"nodes": nodes, "scenes": [{"nodes": [1]}, {"nodes": [0]}], "scene": 1}
    found = tables(tmp_path / "a.glb", *document(POINTS, FACES.astype("<u2").ravel(), **parts))
    expected = (turn.apply(POINTS * scale) + shift) * [-1, 1, 1] + [4, 5, 6]
    np.testing.assert_allclose(found["vertices"][found["faces"]], expected[FACES[:, ::-1]], atol=1e-13)


@pytest.mark.parametrize(
    "node",
    [
        {"translation": [5, 6, 7]},
        {"scale": [1000, 1000, 1000]},
        {"rotation": [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]},
    ],
)
def test_coordinates_of_single_precision_stay_so_under_transformations(node, tmp_path):
    x, faces = zoo.icosahedron()
    mesh = document((x * [0.7, 0.9, 1.1]).astype("<f4"), faces.astype("<u2").ravel())
    own, moved = (glb(mesh[0] | {"nodes": [{"mesh": 0, **more}]}, mesh[1]) for more in ({}, node))
    (tmp_path / "a.glb").write_bytes(own)
    (tmp_path / "b.glb").write_bytes(moved)
    before, after = read_metric(tmp_path / "a.glb").precision, read_metric(tmp_path / "b.glb").precision
    assert before.name == after.name == "single precision"
    assert 1 <= after.length_error / before.length_error < 5


@pytest.mark.parametrize(
    ("code", "normalized", "name", "unit"),
    [("u2", False, "16 bits", 1.0), ("i2", True, "16 bits", 1 / 32767), ("u1", True, "8 bits", 1 / 255)],
)
def test_quantized_positions_under_a_transformation(code, normalized, name, unit, tmp_path):
    least, most = np.iinfo(code).min, np.iinfo(code).max
    x = np.round((VERTICES / np.abs(VERTICES).max() + 1) / 2 * (most - least) + least).astype(f"<{code}")
    root, data = document(x, FACES.astype("<u2").ravel(), nodes=[{"mesh": 0, "scale": [3, 3, 3]}])
    root["accessors"][0]["normalized"] = normalized
    found = tables(tmp_path / "a.glb", root, data)
    assert (found["precision"], found["rounding_error"]) == (name, pytest.approx(3 * unit / np.sqrt(6)))


def test_the_precision_of_a_scene_is_the_coarsest_of_its_primitives(tmp_path):
    nodes = [{"mesh": 0}, {"mesh": 0, "scale": [1e-3, 1e-3, 1e-3]}]
    found = tables(tmp_path / "a.glb", *document(POINTS, FACES.astype("<u2").ravel(), nodes=nodes))
    unit = np.finfo(np.float32).eps * np.abs(POINTS).max()
    assert found["rounding_error"] == pytest.approx(unit / np.sqrt(6))


def test_nodes_without_scenes_and_meshes_without_nodes(tmp_path):
    arrays = POINTS, FACES.astype("<u2").ravel()
    assert len(tables(tmp_path / "a.glb", *document(*arrays, nodes=[]))["faces"]) == 20
    nodes = [{"mesh": 0}, {"children": [0]}]
    assert len(tables(tmp_path / "a.glb", *document(*arrays, nodes=nodes))["faces"]) == 20
    twice = [{"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}]
    (tmp_path / "a.glb").write_bytes(glb(*document(*arrays, nodes=twice)))
    with pytest.raises(ValueError, match="the surface has 2 components"):
        read_metric(tmp_path / "a.glb")


def without(kind, index, key):
    root, data = document(POINTS, FACES.astype("<u2").ravel())
    del root[kind][index][key]
    return root, data


def changed(kind, index, **values):
    root, data = document(POINTS, FACES.astype("<u2").ravel())
    root[kind][index] |= values
    return root, data


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (
            document(POINTS, extensionsRequired=["KHR_draco_mesh_compression"]),
            "unknown extension KHR_draco_mesh_compression: export it without",
        ),
        (document(POINTS, asset={"version": "1.0"}), "its version is 1.0, not 2.0"),
        (document(POINTS, asset=[]), "its asset is not an object"),
        (document(POINTS, nodes=[{"children": [1]}, {"children": [0]}]), "there are no faces"),
        (document(POINTS, nodes=[{"children": [0]}], scenes=[{"nodes": [0]}]), "its nodes are not a tree"),
        (document(POINTS, nodes=[{"mesh": -1}]), "no number -1 among its meshes"),
        (document(POINTS, nodes=[{"mesh": 0, "scale": [1, 2]}]), "are not 3 numbers"),
        (document(POINTS, nodes={}), "its nodes are not a list"),
        (document(POINTS, np.array([0, 1, 12], "<u2")), "with 12 vertices refers to vertex 12"),
        (document(POINTS, FACES.astype("<u2").ravel(), mode=1), "there are no faces"),
        (without("accessors", 0, "bufferView"), "accessor 0 has no bufferView"),
        (without("accessors", 0, "count"), "the count of accessor 0 is None"),
        (changed("accessors", 0, count=10**9), "accessor 0 ends after its bufferView"),
        (changed("accessors", 0, count=-1), "the count of accessor 0 is -1"),
        (changed("accessors", 0, type="VEC2"), "accessor 0 has the type 'VEC2', not VEC3"),
        (changed("accessors", 0, componentType=5130), "accessor 0 has the componentType 5130"),
        (changed("buffers", 0, uri="../nowhere.bin"), "its buffer '../nowhere.bin' is not beside it"),
        (changed("buffers", 0, uri="http://example.org/a.bin"), "is not beside it"),
        (changed("buffers", 0, uri="data:,abc"), "is not in base64"),
        (changed("buffers", 0, uri=7), "buffer 0 has no name, but a int"),
    ],
)
def test_malformed(parts, sentence, tmp_path):
    (tmp_path / "a.glb").write_bytes(glb(*parts))
    with pytest.raises(ValueError, match=sentence) as caught:
        read_metric(tmp_path / "a.glb")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "data", [b"", b"{}", b"[]", b"glTF", b"\xff", glb(*document(POINTS))[:-4], b"[" * 10**5]
)
def test_what_is_none(data, tmp_path):
    (tmp_path / "a.gltf").write_bytes(data)
    with pytest.raises(FileError, match="is not a readable glTF file"):
        read_metric(tmp_path / "a.gltf")


def test_damaged_files(tmp_path):
    assert refusals(tmp_path / "a.glb", glb(*document(POINTS, FACES.astype("<u2").ravel()))) > 100


@pytest.mark.parametrize("name", ["a.glb", "a.gltf"])
def test_it_is_not_written(name, tmp_path):
    with pytest.raises(FileError, match=r"not one of \.npz"):
        check_output(tmp_path / name, SURFACE_ENDINGS)
