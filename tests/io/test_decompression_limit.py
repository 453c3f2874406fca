"""Files that promise more than they hold: refused in a sentence, without the memory that they promise."""

import base64
import gzip
import io
import json
import os
import struct
import subprocess
import sys
import zipfile
import zlib

import numpy as np
import pytest

import zoo
from isoembed import Embedding, PolyhedralMetric
from isoembed.io import FileError, decompression_limit, read_metric, write_surface
from isoembed.io.decompression_limit import ExpansionThresholds
from isoembed.relativity.spacetimes.slice_file import GAMMA, read_cartesian_grid

VERTICES, FACES = zoo.icosphere(1)


@pytest.fixture
def bounded(monkeypatch):
    """Little files are bombs, too."""
    monkeypatch.setattr(decompression_limit, "EXPANSION", ExpansionThresholds(spare=10_000))


def npy(shape, data):
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return head.getvalue() + data


def archive(members, compression=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as written:
        for name, data in members.items():
            written.writestr(f"{name}.npy", data)
    return file.getvalue()


def test_what_expands_too_far_is_refused(bounded, tmp_path):
    zeros = bytes(5_000_000)
    (tmp_path / "a.obj.gz").write_bytes(gzip.compress(zeros))
    (tmp_path / "a.npz").write_bytes(archive({"lengths": npy((625_000,), zeros)}))
    for name in os.listdir(tmp_path):
        size = (tmp_path / name).stat().st_size
        with pytest.raises(FileError, match=rf"{name} expands from {size} to more than \d+ bytes"):
            read_metric(tmp_path / name)


def test_a_grid_of_nothing(bounded, tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in GAMMA:  # of which nothing is stored
            file.create_dataset(name, (10**5, 10**4, 10**3), "f8", chunks=(10, 10, 10))
        file.attrs["origin"], file.attrs["spacing"] = np.zeros(3), 1.0
    with pytest.raises(FileError, match=r"/gxx of .*a\.h5 expands from 0 to more than 10000 bytes"):
        read_cartesian_grid(tmp_path / "a.h5")


def test_blocks_of_vtu(bounded, tmp_path):
    surface = Embedding(PolyhedralMetric.from_mesh(VERTICES, FACES), VERTICES, method="a", tolerance=1e-9)
    write_surface(tmp_path / "a.vtu", surface)
    text = (tmp_path / "a.vtu").read_bytes()
    begin = text.index(b'format="binary">\n') + 17
    for size, promised, sentence in (
        (5_000_000, 5_000_000, "expands from"),
        (99, 9_000, "9000 bytes has 99"),
    ):
        packed = zlib.compress(bytes(size))
        header = struct.pack("<4I", 1, promised, 0, len(packed))
        block = base64.b64encode(header) + base64.b64encode(packed)
        (tmp_path / "b.vtu").write_bytes(text[:begin] + block + text[text.index(b"\n</DataArray>") :])
        with pytest.raises(FileError, match=sentence):
            read_metric(tmp_path / "b.vtu")


LIMITED = """
import json, resource, sys
from isoembed.errors import InvalidMetric
from isoembed.io import FileError, read_metric

def refusal(path):
    try:
        read_metric(path)
    except (FileError, InvalidMetric) as error:
        return str(error)

names = json.load(sys.stdin)
for name in names:
    refusal(name)  # loads what it takes
with open("/proc/self/statm") as sizes:
    size = int(sizes.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 200_000_000, resource.RLIM_INFINITY))
print(json.dumps({name: refusal(name) for name in names}))
"""


def promises():
    """Files by their names, with counts that are far too large."""
    ply = "ply\nformat {} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
    ply += "element face {}\nproperty list {} int vertex_indices\nend_header\n"
    binary = "binary_little_endian"
    point = struct.pack("<3d", 0, 0, 0)
    most = 2**31 - 1
    yield "vertices.ply", ply.format(binary, 10**15, 4, "uchar").encode() + 9 * point
    yield "corners.ply", ply.format(binary, 1, 1, "uint").encode() + point + struct.pack("<I", most)
    yield "text.ply", (ply.format("ascii", 1, 10**12, "int") + "0 0 0\n4026531840 0 1 2\n").encode()
    yield "text2.ply", (ply.format("ascii", 10**12, 1, "int") + "0 0 0\n").encode()
    yield "a.off", b"OFF\n999999999999 999999999999 0\n0 0 0\n"
    yield "corners.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n999999999999 0 1 2\n"
    yield "a.stl", bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50)
    yield "a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999999\nf 1 3 2\n"
    vtk = "# vtk DataFile Version 4.2\n\n{}\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n"
    yield "points.vtk", vtk.format("BINARY", 10**12).encode() + bytes(100)
    yield "text.vtk", vtk.format("ASCII", 10**12).encode() + b"0 0 0\n"
    cells = vtk.format("ASCII", 1) + "0 0 0\nCELLS {} {}\n3 0 0 0\n"
    yield "cells.vtk", cells.format(10**12, 4).encode()
    yield "numbers.vtk", cells.format(1, 10**12).encode()
    yield "a.json", b'{"faces": [[0, 1, 999999999999], [0, 999999999999, 1]], "lengths": [1, 1, 1]}'
    yield "a.npz", archive({"lengths": npy((10**12,), bytes(80))})
    yield "stored.npz", archive({"lengths": npy((10**9,), bytes(80))}, zipfile.ZIP_STORED)


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs /proc")
def test_promises_take_no_memory(tmp_path):
    files = dict(promises())
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    done = subprocess.run(
        [sys.executable, "-c", LIMITED],
        input=json.dumps(list(files)),
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    for name, sentence in json.loads(done.stdout).items():
        assert sentence and "\n" not in sentence and len(sentence) < 250, (name, sentence)
        assert name in sentence or name in ("a.obj", "a.json", "corners.off"), sentence
