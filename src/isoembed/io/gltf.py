"""glTF 2.0 (.gltf, .glb): the triangles of a scene with their node transformations.

The format is read-only: its coordinates have single precision or less, which no exact surface survives.
"""

import base64
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError, Tables, first_line
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.strips import fan_triangles, strip_triangles
from isoembed.metric.precision import SINGLE

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
TRIANGLES, STRIP = 4, 5  # modes of primitives; lower ones are points and lines, and 6 is a fan
UNKNOWN = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing")
"""Extensions without which the triangles cannot be read."""

Object = dict[str, Any]


def read(file: InputFile) -> Tables:
    """Read the triangles of all meshes in the scene, in scene coordinates; all else is ignored.

    Vertices are as in the file, which repeats them at seams of normals or textures.  Transformed coordinates
    no longer show their precision, which is therefore stated: the coarsest of all primitives.

    Raises
    ------
    FileError
        The file is damaged, or requires an unsupported extension.
    """
    try:
        document = _Document(file)
        vertices, faces, n = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
        (unit, name), transformed = (0.0, SINGLE), False
        for mesh, matrix in document.placed():
            for primitive in _list(mesh, "primitives"):
                points, triangles = document.triangles(primitive)
                used, triangles = np.unique(triangles, return_inverse=True)  # primitives may share points
                vertices.append(points[used] @ matrix[:3, :3].T + matrix[:3, 3])
                if used.size:
                    own, kind = document.precision(primitive["attributes"]["POSITION"], points[used])
                    unit, name = max((unit, name), (own * float(np.linalg.norm(matrix[:3, :3], 2)), kind))
                    transformed |= bool((matrix != np.eye(4)).any())
                mirrored = np.linalg.det(matrix[:3, :3]) < 0
                faces.append(n + triangles.reshape(-1, 3)[:, :: -1 if mirrored else 1])
                n += len(used)
    except FileError:
        raise
    except (ValueError, TypeError, RecursionError, OSError) as error:  # invalid JSON, arrays or files
        raise FileError(f"{file} is not a readable glTF file: {first_line(error)}") from None
    # A length has the errors of two coordinates, uniformly distributed over a unit of the last digit.
    stated = {"precision": name, "rounding_error": unit / math.sqrt(6)} if transformed and unit else {}
    return {"vertices": np.concatenate(vertices), "faces": np.concatenate(faces), **stated}


class _Document:
    """Objects and binary data of a glTF file."""

    def __init__(self, file: InputFile) -> None:
        text, self.binary = _chunks(file.data) if file.data[:4] == b"glTF" else (file.data, b"")
        self.folder = file.path.parent
        self.root = _object(json.loads(text.decode("utf-8-sig")), "the document")
        version = str(_object(self.root.get("asset"), "its asset").get("version"))
        if not version.startswith("2."):
            raise ValueError(f"its version is {version[:20]}, not 2.0")
        for name in UNKNOWN:
            if name in _list(self.root, "extensionsRequired"):
                raise FileError(f"{file} needs the unknown extension {name}: export it without")
        self._buffers: dict[int, bytes] = {}

    def entry(self, kind: str, index: Any) -> Object:
        """Object of a list by index."""
        rows = _list(self.root, kind)
        if not isinstance(index, int) or not 0 <= index < len(rows):
            raise ValueError(f"there is no number {index!r} among its {kind}")
        return _object(rows[index], f"number {index} of its {kind}")

    def placed(self) -> Iterator[tuple[Object, Floats]]:
        """Meshes of the scene, each with its transformation matrix (4, 4)."""
        nodes = _list(self.root, "nodes")
        if not nodes:
            for k in range(len(_list(self.root, "meshes"))):
                yield self.entry("meshes", k), np.eye(4)
            return
        if _list(self.root, "scenes"):
            roots = _list(self.entry("scenes", self.root.get("scene", 0)), "nodes")
        else:
            below = {c for k in range(len(nodes)) for c in _list(self.entry("nodes", k), "children")}
            roots = [k for k in range(len(nodes)) if k not in below]
        waiting, count = [(k, np.eye(4)) for k in reversed(roots)], 0
        while waiting:
            k, above = waiting.pop()
            node = self.entry("nodes", k)
            count += 1
            if count > len(nodes):
                raise ValueError("its nodes are not a tree")
            matrix = above @ _matrix(node)
            if "mesh" in node:
                yield self.entry("meshes", node["mesh"]), matrix
            waiting += [(child, matrix) for child in reversed(_list(node, "children"))]

    def triangles(self, primitive: Any) -> tuple[Floats, Indices]:
        """Points and triangles of a primitive; empty for points and lines."""
        primitive = _object(primitive, "a primitive")
        mode = primitive.get("mode", TRIANGLES)
        attributes = _object(primitive.get("attributes"), "the vertex data of a primitive")
        if mode not in (TRIANGLES, STRIP, 6) or "POSITION" not in attributes:
            return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
        points = self.accessor(attributes["POSITION"], "VEC3", 3).astype(np.float64)
        corners = np.arange(len(points))
        if "indices" in primitive:
            corners = self.accessor(primitive["indices"], "SCALAR", 1).astype(np.int64).ravel()
        if corners.size and not 0 <= corners.min() <= corners.max() < len(points):
            raise ValueError(f"a primitive with {len(points)} vertices refers to vertex {corners.max()}")
        if len(corners) < 3:
            return points, np.empty((0, 3), dtype=np.int64)
        if mode == TRIANGLES:
            return points, corners[: len(corners) // 3 * 3].reshape(-1, 3)
        return points, strip_triangles(corners) if mode == STRIP else fan_triangles(corners)

    def accessor(self, index: Any, kind: str, columns: int) -> NDArray[Any]:
        """Values of an accessor, shape (count, columns)."""
        accessor, name = self.entry("accessors", index), f"accessor {index}"
        if accessor.get("type") != kind:
            raise ValueError(f"{name} has the type {accessor.get('type')!r}, not {kind}")
        dtype, count = _dtype(accessor, name), _natural(accessor, "count", name)
        values = self.view(accessor, dtype, count, columns, name)
        if "sparse" in accessor:
            sparse = _object(accessor["sparse"], f"sparse of {name}")
            few = _natural(sparse, "count", name)
            where, substitutes = (
                _object(sparse.get(key), f"{key} of {name}") for key in ("indices", "values")
            )
            rows = self.view(where, _dtype(where, name), few, 1, name).astype(np.int64).ravel()
            if few and rows.max() >= count:
                raise ValueError(f"{name} has {count} numbers, and a substitute for number {rows.max()}")
            values = values.copy()
            values[rows] = self.view(substitutes, dtype, few, columns, name)
        if accessor.get("normalized") and dtype.kind != "f":
            return np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def precision(self, index: int, values: Floats) -> tuple[float, str]:
        """Unit of the last digit of values from an accessor, and its name."""
        accessor = self.entry("accessors", index)
        dtype = _dtype(accessor, f"accessor {index}")
        if dtype.kind == "f":
            return float(np.finfo(dtype).eps * np.abs(values).max()), SINGLE
        unit = 1 / np.iinfo(dtype).max if accessor.get("normalized") else 1.0
        return unit, f"{8 * dtype.itemsize} bits"

    def view(self, part: Object, dtype: np.dtype, count: int, columns: int, name: str) -> NDArray[Any]:
        """Strided rows of numbers."""
        if "bufferView" not in part:
            raise ValueError(f"{name} has no bufferView")
        view = self.entry("bufferViews", part["bufferView"])
        begin, length = _natural(view, "byteOffset", name, 0), _natural(view, "byteLength", name)
        data = self.buffer(view.get("buffer"))[begin : begin + length]
        stride = _natural(view, "byteStride", name, 0) or columns * dtype.itemsize
        offset = _natural(part, "byteOffset", name, 0)
        if count and offset + (count - 1) * stride + columns * dtype.itemsize > len(data):
            raise ValueError(f"{name} ends after its bufferView")
        return np.ndarray((count, columns), dtype, data, offset, (stride, dtype.itemsize))

    def buffer(self, index: Any) -> bytes:
        """Bytes of a buffer, embedded or in another file in the same folder."""
        buffer = self.entry("buffers", index)
        if index not in self._buffers:
            uri = buffer.get("uri")
            if uri is None:
                self._buffers[index] = self.binary
            elif not isinstance(uri, str):
                raise ValueError(f"buffer {index} has no name, but a {type(uri).__name__}")
            elif uri.startswith("data:"):
                head, _, content = uri.partition(",")
                if not head.endswith(";base64"):
                    raise ValueError(f"buffer {index} is not in base64")
                self._buffers[index] = base64.b64decode(content)
            else:
                self._buffers[index] = _beside(self.folder, unquote(uri))
        return self._buffers[index]


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """JSON and binary chunks of a .glb file."""
    chunks, at = dict[bytes, bytes](), 12
    while at + 8 <= len(data):
        length, kind = int.from_bytes(data[at : at + 4], "little"), data[at + 4 : at + 8]
        if at + 8 + length > len(data):
            raise ValueError("it is cut short")
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if b"JSON" not in chunks:
        raise ValueError("there is no JSON in it")
    return chunks[b"JSON"], chunks.get(b"BIN\0", b"")


def _beside(folder: Path, name: str) -> bytes:
    if ":" in name or Path(name).is_absolute() or ".." in Path(name).parts:
        raise ValueError(f"its buffer {name[:60]!r} is not beside it")
    try:
        return (folder / name).read_bytes()
    except OSError as error:
        raise ValueError(f"its buffer {name[:60]!r} cannot be read: {error.strerror}") from None


def _matrix(node: Object) -> Floats:
    """Transformation from the coordinates of a node to those of its parent, shape (4, 4)."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    x, y, z, w = _numbers(node.get("rotation", [0, 0, 0, 1]), 4)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += 2 * (w * cross + cross @ cross)
    matrix[:3, :3] *= _numbers(node.get("scale", [1, 1, 1]), 3)
    matrix[:3, 3] = _numbers(node.get("translation", [0, 0, 0]), 3)
    return matrix


def _numbers(values: Any, count: int) -> Floats:
    array = np.array(values, dtype=np.float64)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{str(values)[:60]} are not {count} numbers")
    return array


def _dtype(part: Object, name: str) -> np.dtype:
    code = part.get("componentType")
    if code not in COMPONENTS:
        raise ValueError(f"{name} has the componentType {str(code)[:20]}")
    return np.dtype(COMPONENTS[code])


def _natural(part: Object, key: str, name: str, default: int | None = None) -> int:
    value = part.get(key, default)
    if not isinstance(value, int) or not 0 <= value < 2**48:
        raise ValueError(f"the {key} of {name} is {str(value)[:20]}")
    return value


def _list(part: Object, key: str) -> list[Any]:
    rows = part.get(key, [])
    if not isinstance(rows, list):
        raise ValueError(f"its {key} are not a list")
    return rows


def _object(value: Any, name: str) -> Object:
    if not isinstance(value, dict):
        raise ValueError(f"{name} is not an object")
    return value


GLTF = Format(".gltf", read, None, repeats_vertices=True)
GLB = Format(".glb", read, None, repeats_vertices=True)
