"""Pictures: what is drawn, where, and with what colors."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import zoo
from isoembed import Embedding, InvalidParameter, PolyhedralMetric, embed, glue
from isoembed.gallery import CassiniPeanut, Sphere, triangulate
from isoembed.gluing.classics import CLASSICS, LATIN_CROSS
from isoembed.io import FileError
from places import SUPPORT

pytest.importorskip("matplotlib")

from isoembed.plot import Panel, color_scale, draw_panel, figure, panels, write_picture
from isoembed.plot.coloring import Quantity
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


def test_a_panel_in_axes_of_ones_own_is_that_of_a_row(peanut):
    from matplotlib.figure import Figure

    panel, axes = Panel(peanut.vertices, peanut.faces, peanut.mean_curvature), Figure().add_subplot()
    draw_panel(axes, panel, color_scale(0.5, 2.0))
    row = panels([panel], label="H", bounds=(0.5, 2.0))
    (mine,), (there, *_) = axes.collections, row.axes[0].collections
    np.testing.assert_array_equal(mine.get_facecolors(), there.get_facecolors())
    for path, other in zip(mine.get_paths(), there.get_paths(), strict=True):
        np.testing.assert_array_equal(path.vertices, other.vertices)


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
from isoembed import Embedding, InvalidParameter, PolyhedralMetric, embed, glue
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


@pytest.fixture(scope="module")
def folded():
    """The octahedron of a Latin cross, with paper seams along edges and across faces."""
    pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
    return embed(glue([LATIN_CROSS], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov")


def dodecahedron():
    return embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")


def test_a_polyhedron_is_drawn_with_its_faces():
    solid = dodecahedron()
    faces, lines = figure(solid, color="sides").axes[0].collections
    drawn = [path.vertices[:-1] for path in faces.get_paths()]
    assert {len(face) for face in drawn} == {5} and len(drawn) == 6
    # Every edge is a seam of this net: those of the six faces in front, each once.
    front = {
        frozenset(map(tuple, np.round(pair, 9)))
        for f in drawn
        for pair in zip(f, np.roll(f, 1, 0), strict=True)
    }
    seen_lines = {frozenset(map(tuple, np.round(line, 9))) for line in lines.get_segments()}
    assert seen_lines == front and len(lines.get_segments()) == len(front)


def test_boundaries_are_drawn():
    metric = PolyhedralMetric([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], [1.0] * 8)
    [shapes] = figure(embed(metric, boundary="plane")).axes[0].collections
    corners = [len(path.vertices) for path in shapes.get_paths()]
    faces, lines = ([k for k, count in enumerate(corners) if count == n] for n in (4, 3))
    assert (len(faces), len(lines)) == (4, 4)
    dark = shapes.get_edgecolors()[lines]
    assert (dark[:, :3] < 0.2).all()
    assert shapes.get_linewidths()[lines[0]] > shapes.get_linewidths()[faces[0]]


def test_seams_that_are_hidden_are_not_drawn(folded):
    faces, lines = figure(folded).axes[0].collections
    ends, _ = folded.surface.seams
    assert 0 < len(lines.get_segments()) < len(ends)
    view = View.of(folded.vertices, folded.polygons)
    everything = view.put(ends)
    shown = np.array(lines.get_segments())
    # Those left out are behind: the others lie within what is seen.
    low, high = view.extent
    assert (shown >= low - 1e-12).all() and (shown <= high + 1e-12).all()
    assert all(any(np.allclose(line, one) for one in everything) for line in shown)
    assert len(faces.get_paths()) == len(view.faces)


def test_faces_that_are_polygons_look_as_their_triangles_do(folded):
    whole, parts = (
        View.of(folded.vertices, folded.polygons),
        View.of(folded.vertices, folded.faces),
    )

    def area(polygon):
        x, y = polygon.T
        return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2

    owners = folded.surface.flat_faces.of_triangles[parts.faces]
    for polygon, face, light in zip(whole.polygons, whole.faces, whole.light, strict=True):
        own = owners == face
        assert sum(map(area, parts.polygons[own])) == pytest.approx(area(polygon))
        np.testing.assert_allclose(parts.light[own], light, atol=1e-9)


def pyramid():
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]
    faces = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    return embed(PolyhedralMetric.from_mesh(corners, faces), method="alexandrov")


def test_a_polyhedron_has_the_colors_of_its_faces_and_no_scale_of_one_color():
    drawn = figure(pyramid())
    assert drawn.axes[-1].get_ylabel() == "number of sides of a face"
    cube = embed(PolyhedralMetric.from_mesh(*zoo.cube()), method="alexandrov")
    drawn = figure(cube)
    assert len(drawn.axes) == 1 and drawn.texts[-1].get_text() == "number of sides of a face: 4"
    assert figure(cube, color="mean curvature").axes[-1].get_ylabel().startswith("mean curvature")


@pytest.mark.parametrize(("low", "high"), [(-1.0, 1.0), (-0.2, 3.0), (-3.0, 0.2)])
def test_values_of_both_signs_have_colors_that_say_the_sign(low, high):
    scale = color_scale(low, high)
    red, _, blue = scale.to_rgba(np.array([0.0, low, high]))[:, :3].T
    assert abs(red[0] - blue[0]) < 0.1 and min(red[0], blue[0]) > 0.85  # nearly white
    assert blue[1] > red[1] and red[2] > blue[2]
    assert not np.array_equal(color_scale(0.0, 1.0).to_rgba(0.0), scale.to_rgba(0.0))


def test_ticks_of_whole_numbers_are_whole():
    drawn = figure(pyramid())
    drawn.canvas.draw()
    ticks = drawn.axes[-1].get_yticks()
    assert {3, 4} <= set(ticks) and (ticks == ticks.round()).all()


def test_plot_into_axes_of_ones_own(peanut):
    from matplotlib.figure import Figure

    whole = Figure()
    left, right = whole.subplots(1, 2)
    assert peanut.plot(ax=right, color="gaussian-curvature", caption="a peanut") is whole
    assert not left.collections and right.collections
    assert right.get_title() == "a peanut"
    assert [axes.get_ylabel() for axes in whole.axes[2:]] == ["Gaussian curvature  $K$ = deficit / dual area"]
    part = Figure().subfigures(1, 2)[0]
    assert peanut.plot(ax=part.subplots()) is part.figure


@pytest.mark.parametrize("name", ["Gaussian curvature", "gaussian_curvature", "gaussian-curvature"])
def test_colors_by_their_names(peanut, name):
    assert peanut.plot(color=name).axes[1].get_ylabel().startswith("Gaussian curvature")


def test_colors_by_values(peanut):
    values = peanut.vertices[:, 2]
    drawn = peanut.plot(color=values)
    assert drawn.axes[1].get_ylim() == pytest.approx(Quantity("", "", values).bounds)


@pytest.mark.parametrize(
    ("color", "said"),
    [
        (np.zeros(3), r"values of shape \(3,\), not \(\d+,\): one for each of the vertices"),
        (Quantity("k", "k", np.zeros((2, 2)), at="faces"), "one for each of the faces"),
        (["a", "b"], "the color is of type list, not the name of a quantity"),
        (object(), "the color is of type object, not the name of a quantity"),
    ],
)
def test_colors_that_are_none(peanut, color, said):
    with pytest.raises(InvalidParameter, match=said):
        peanut.plot(color=color)


def test_a_color_that_is_mistyped(peanut):
    with pytest.raises(InvalidParameter, match=r"no quantity 'mean_curvatur'.*did you mean 'mean-curvature'"):
        peanut.plot(color="mean_curvatur")
