"""Loops are compiled, and arrays that they are not made for are refused, whatever else is wrong with them."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from isoembed import Embedding, embed, unfold
from isoembed.intrinsic.delaunay_loops import tilts
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import Mesh
from isoembed.mesh.loops import find, pinched, reached_faces
from isoembed.smooth.harmonics import Harmonics
from isoembed.surface.triangle_loops import face_normals
from places import ROOT

SOURCES = ROOT / "src"
MODULES = [
    ".".join(path.relative_to(SOURCES).with_suffix("").parts)
    for path in sorted(SOURCES.rglob("*.py"))
    if path.read_bytes().startswith(b"# cython:")
]
FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize("name", MODULES)
def test_modules_of_loops_are_compiled(name):
    assert not importlib.import_module(name).__file__.endswith(".py")


def test_modules_of_loops_import_lower_packages_only():
    """Imports of C are not seen by `lint-imports`."""
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    layers = linter["contracts"][0]["layers"]
    for name in MODULES:
        text = (SOURCES / name.replace(".", "/")).with_suffix(".py").read_text(encoding="utf-8")
        for package in re.findall(r"cimports\.isoembed\.(\w+)\.", text):
            assert layers.index(package) >= layers.index(name.split(".")[1]), name


def test_modules_of_loops_run_as_python(tmp_path):
    pytest.importorskip("Cython")
    shutil.copytree(SOURCES, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("*.so", "*.pyd"))
    code = f"""
from importlib import import_module
import numpy as np
from isoembed import PolyhedralMetric, embed
for name in {MODULES}:
    assert import_module(name).__file__.endswith(".py"), name
vertices, faces = np.array({VERTICES.tolist()}), np.array({FACES[:, ::-1].tolist()})
for method in ("aim", "alexandrov"):
    print(embed(PolyhedralMetric.from_mesh(vertices, faces), method=method).volume)
"""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert [float(volume) for volume in done.stdout.split()] == pytest.approx([1 / 6] * 2), done.stderr


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda table: table.astype(np.int32),
        lambda table: table.astype(np.float32),
        lambda table: table.astype(np.complex128),
        lambda table: table.tolist(),
        lambda table: table.ravel(),
        lambda table: table[None],
        lambda table: np.array(table, dtype=object),
        lambda _: np.zeros((4, 3), dtype="U1"),
        lambda _: None,
    ],
)
def test_arrays_of_other_types_and_shapes_are_refused(spoilt):
    face_normals(FACES, VERTICES)
    with pytest.raises((TypeError, ValueError)):
        face_normals(spoilt(FACES), VERTICES)
    with pytest.raises((TypeError, ValueError)):
        face_normals(FACES, spoilt(VERTICES))
    with pytest.raises((TypeError, ValueError)):
        find(spoilt(FACES), 4, FACES[:, :2].copy())


@pytest.mark.parametrize("strided", [np.asfortranarray, lambda table: np.repeat(table, 2, axis=1)[:, ::2]])
def test_arrays_that_are_not_contiguous_are_refused_or_read(strided):
    assert np.array_equal(face_normals(strided(FACES), VERTICES), face_normals(FACES, VERTICES))
    with pytest.raises(ValueError, match="contiguous"):
        find(strided(FACES), 4, FACES[:, :2].copy())


def test_arrays_that_are_read_only_and_empty_are_read():
    table = FACES.copy()
    table.flags.writeable = False
    assert np.array_equal(face_normals(table, VERTICES), face_normals(FACES, VERTICES))
    assert face_normals(FACES[:0], VERTICES).shape == (0, 3)
    assert find(FACES[:0, :2].copy(), 4, FACES[:0, :2].copy()).size == 0
    assert pinched(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), 0) == -1
    for integer in (np.int32, np.int64):
        assert reached_faces(np.array([3, 4, 5, 0, 1, 2], dtype=integer)).all()


def test_tables_that_are_to_be_changed_are_not_read_only():
    mesh = HalfEdges(FACES.ravel(), np.arange(12), np.ones(12), np.zeros(12))
    tilts(mesh.views, np.zeros(4))
    mesh.lengths.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        mesh.views  # noqa: B018
    with pytest.raises(TypeError, match="Mesh"):
        tilts(mesh, np.zeros(4))
    assert isinstance(HalfEdges(FACES.ravel(), np.arange(12), np.ones(12), np.zeros(12)).views, Mesh)


def test_points_in_any_order_of_memory():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    surface = embed((corners, faces))
    by_columns = np.asfortranarray(surface.vertices)
    assert Embedding(surface.metric, by_columns, method="given", tolerance=1e-9).volume == surface.volume
    assert unfold((corners[:, [1, 2, 0]], faces)).sheets
    harmonics = Harmonics(3, 3)
    u = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    expected = harmonics.derivatives(u, np.ones(harmonics.size))
    for other in (np.asfortranarray(u), np.repeat(u, 2, axis=0)[::2]):
        for got, right in zip(harmonics.derivatives(other, np.ones(harmonics.size)), expected, strict=True):
            np.testing.assert_array_equal(got, right)
