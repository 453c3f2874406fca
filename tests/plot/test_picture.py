"""Pictures: what is drawn, where, and with what colors."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from isoembed import Embedding, PolyhedralMetric
from isoembed.gallery import CassiniPeanut, Sphere, triangulate
from isoembed.io import FileError
from places import SUPPORT

pytest.importorskip("matplotlib")

from isoembed.plot import figure, write_picture
from isoembed.plot.view import View


def embedded(surface, n):
    vertices, faces = triangulate(surface, n)
    return Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)


def seen(surface):
    return View.of(surface.vertices, surface.faces)


@pytest.fixture(scope="module")
def peanut():
    return embedded(CassiniPeanut(), 200)


def test_half_of_a_sphere_is_seen():
    view = seen(embedded(Sphere(), 1000))
    assert len(view.faces) == pytest.approx(998, rel=0.05)
    # The projected triangles cover the disk once.
    a, b, c = view.polygons.transpose(1, 0, 2)
    (x1, y1), (x2, y2) = (b - a).T, (c - a).T
    areas = (x1 * y2 - x2 * y1) / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(np.pi, rel=0.02)


def test_the_view_does_not_depend_on_the_position(peanut):
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved = Embedding(peanut.metric, 7.0 + peanut.vertices @ turn, method="exact", tolerance=1e-10)
    here, there = seen(peanut).polygons, seen(moved).polygons
    # A surface of revolution fixes its long axis only: the extent of the picture is what must agree.
    np.testing.assert_allclose(np.ptp(here[..., 0]), np.ptp(there[..., 0]), rtol=0.02)
    assert np.ptp(here[..., 0]) > np.ptp(here[..., 1])  # the long axis lies across


def test_the_figure_says_which_convention(peanut):
    picture = figure(peanut)
    axes, bar = picture.axes
    assert axes.get_aspect() == 1.0
    assert "H = (k_1 + k_2)/2" in bar.get_ylabel()
    (triangles,) = axes.collections
    assert len(triangles.get_paths()) == len(seen(peanut).faces)
    # The waist is less curved than the ends, so the colors differ in lightness.
    lightness = triangles.get_facecolors()[:, :3].mean(axis=1)
    assert np.ptp(lightness) > 0.2


def test_no_global_state():
    code = """
import sys, zoo
from isoembed import Embedding, PolyhedralMetric
from isoembed.plot import figure
vertices, faces = zoo.icosphere(1)
figure(Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10))
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=SUPPORT)


@pytest.mark.parametrize(("ending", "magic"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_picture_files(peanut, ending, magic, tmp_path):
    write_picture(tmp_path / f"a{ending}", peanut)
    assert (tmp_path / f"a{ending}").read_bytes().startswith(magic)


def test_what_cannot_be_drawn(peanut, tmp_path, monkeypatch):
    with pytest.raises(FileError, match=r"not one of \.png \.svg \.pdf"):
        write_picture(tmp_path / "a.gif", peanut)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(FileError, match="pictures need matplotlib"):
        write_picture(tmp_path / "a.png", peanut)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("radius", [1e-150, 1.0, 1e12])
def test_any_size(radius):
    sphere = embedded(Sphere(radius=radius), 42)
    assert np.isfinite(seen(sphere).polygons).all()
    figure(sphere).canvas.draw()
