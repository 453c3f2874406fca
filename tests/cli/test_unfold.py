"""``isoembed unfold``: a net from a file, and back to the solid."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import discs
import zoo
from isoembed import PolyhedralMetric
from isoembed.io import mesh_writer, read_surface, write_atomically, write_metric


def write(name, vertices, faces):
    write_atomically({name: mesh_writer(name, vertices, faces)})


@pytest.mark.parametrize("name", ["solid.obj", "solid.npz", "solid.ply"])
def test_the_solid_comes_back_from_its_net(name, call):
    vertices, faces = zoo.random_hull(15, 4)
    write(name, vertices, faces)
    status, out, err = call("unfold", name, "-o", "net.json")
    assert (status, err) == (0, "")
    assert re.fullmatch(r"1 sheet, 14 pairs of sides, 25 folds\nnet.json written, \S+ s\n", out)
    assert call("glue", "net.json", "-o", "again.npz")[0] == 0
    again = read_surface("again.npz").vertices
    assert len(again) == 15
    apart = np.sort(pdist(again)) - np.sort(pdist(read_surface(name).vertices))
    assert np.abs(apart).max() < 1e-9


def test_what_embed_and_glue_wrote_is_unfolded(call):
    with open("net.json", "w") as file:
        json.dump({"polygons": [{"rectangle": [2, 1]}], "sides": [[[0, k], [0, k]] for k in range(4)]}, file)
    assert call("glue", "net.json", "-o", "solid.npz", "--quiet")[0] == 0
    assert call("unfold", "solid.npz", "-o", "again.json", "--quiet") == (0, "", "")
    with open("again.json") as file:
        again = json.load(file)
    assert set(again) == {"polygons", "sides", "folds"}


@pytest.mark.parametrize(("kind", "magic"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_pages(kind, magic, call, tmp_path):
    pytest.importorskip("matplotlib")
    write("cube.off", *zoo.cube())
    status, out, err = call("unfold", "cube.off", "-o", f"net.{kind}", "--paper", "letter", "--scale", "40")
    assert (status, err) == (0, "")
    assert out.startswith(
        "1 sheet, 7 pairs of sides, 5 folds; solid 40 x 40 x 40 mm, 40 mm a unit; 1 page of letter\n"
        f"net.{kind} written, "
    )
    assert (tmp_path / f"net.{kind}").read_bytes().startswith(magic)


def test_edges_are_cut_and_kept(call):
    vertices, faces = zoo.icosahedron()
    write("solid.obj", vertices, faces)
    kept, cut = ("-".join(map(str, faces[f][:2])) for f in (0, 5))
    status, out, _ = call("unfold", "solid.obj", "-o", "a.json", "--objective", "faces", "--keep", kept)
    assert status == 0 and out.startswith("19 sheets, 29 pairs of sides, 1 fold\n")
    status, out, _ = call("unfold", "solid.obj", "-o", "b.json", "--cut", cut, "--objective", "strips")
    assert status == 0 and out.startswith("1 sheet, 11 pairs of sides, 19 folds\n")


@pytest.mark.parametrize(
    ("typed", "plain"),
    [
        (["--size", "15cm"], ["--size", "150"]),
        (["--size", '4"', "--kerf", "0,15"], ["--size", "101.6", "--kerf", "0.15"]),
        (["--scale", "1,5cm", "--paper", "21x29,7cm"], ["--scale", "15", "--paper", "A4"]),
        (["--scale", "1:0,1", "--paper", "ROLL:60CM"], ["--scale", "10", "--paper", "roll:600"]),
        (["--paper", "8.5x11in"], ["--paper", "letter"]),
    ],
)
def test_lengths_as_people_type_them(typed, plain, call):
    write("cube.off", *zoo.cube())
    assert call("unfold", "cube.off", "-o", "a.svg", *typed)[0] == 0
    assert call("unfold", "cube.off", "-o", "b.svg", *plain)[0] == 0
    with open("a.svg") as one, open("b.svg") as other:
        assert one.read() == other.read()


@pytest.mark.parametrize(("axis", "longest"), [("x", 60), ("y", 90), ("z", 180)])
def test_the_extent_of_an_axis(axis, longest, call):
    write("box.off", zoo.cube()[0] * [3, 2, 1], zoo.cube()[1])
    status, said, _ = call("unfold", "box.off", "-o", "a.svg", "--size", f"{axis}=6cm")
    assert status == 0 and f"; solid {longest} x {2 * longest / 3:g} x {longest / 3:g} mm, " in said
    assert call("unfold", "box.off", "-o", "b.svg", "--size", str(longest))[0] == 0
    assert Path("a.svg").read_text() == Path("b.svg").read_text()
    status, said, err = call("unfold", "box.off", "-o", "a.svg", "--scale", "0.001")
    assert status == 0 and "note: the solid is 0.003 x 0.002 x 0.001 mm large: is the scale right?" in err
    write("flat.off", np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    status, _, err = call("unfold", "flat.off", "-o", "a.svg", "--size", "z=6cm")
    assert status == 2 and "a size in z is given, but the solid has no extent in z" in err
    status, _, err = call("unfold", "box.off", "-o", "a.svg", "--size", f"{axis}=3m")
    said = re.search(rf"size in {axis} is 3000 mm, but face 0 fits on A4 up to --size {axis}=(\S+);", err)
    most = float(said[1])
    assert call("unfold", "box.off", "-o", "a.svg", "--size", f"{axis}={most}")[0] == 0
    assert call("unfold", "box.off", "-o", "a.svg", "--size", f"{axis}={1.01 * most}")[0] == 2


def test_dxf_without_ezdxf(call, monkeypatch):
    write("cube.off", *zoo.cube())
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    status, _, err = call("unfold", "cube.off", "-o", "net.dxf")
    assert status == 2 and "writing net.dxf needs ezdxf: pip install ezdxf; .svg needs nothing" in err


def test_few_pages(call):
    write("solid.obj", *zoo.random_hull(30, 1))
    for objective, pages in (
        ("sheets", "7 pages of A4"),
        ("pages", "6 pages of A4"),
    ):
        status, out, _ = call(
            "unfold", "solid.obj", "-o", "a.svg", "--scale", "150", "--objective", objective
        )
        said = out.partition("\n")[0]
        assert status == 0 and said.endswith(f"; solid 279 x 233 x 167 mm, 150 mm a unit; {pages}")
        printed = Path("a.svg").read_text()
        pairs, folds = re.search(r"(\d+) pairs of sides, (\d+) folds", said).groups()
        numbers = printed.partition('id="numbers"')[2].partition("</g>")[0]
        assert max(int(n) for n in re.findall(r">(\d+)</text>", numbers)) == int(pairs)
        assert printed.count("data-angle") == int(folds)
        assert said.startswith(f"1 sheet cut into 8 islands that fit on pages, {pairs}") == (
            objective == "sheets"
        )


def test_a_solid_of_a_given_size_with_numbers_on_several_pages(call, tmp_path):
    write("cube.off", *zoo.cube())
    status, out, err = call(
        "unfold", "cube.off", "-o", "net.svg", "--size", "150", "--numbers", "--paper", "A9"
    )
    assert (status, out) == (2, "") and "paper is 'A9', not one of A0" in err
    status, out, _ = call("unfold", "cube.off", "-o", "net.svg", "--size", "150", "--numbers")
    assert status == 0 and "; 6 pages of A4 and a drawing of the solid\n" in out
    text = (tmp_path / "net.svg").read_text()
    assert "page 6 of 6" in text and text.count(">F5<") == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["cube.ply"], "the following arguments are required: -o/--output"),
        (["cube.ply", "-o", "a.png"], "a.png has the ending '.png', not one of .svg .pdf .dxf .html .json"),
        (["cube.json", "-o", "cube.json"], "the output is the input cube.json"),
        (["cube.ply", "-o", "a.json", "--scale", "3"], "--scale is for nets on pages (.svg .pdf .dxf .html)"),
        (
            ["cube.ply", "-o", "a.json", "--k-factor", "0.4"],
            "--k-factor is for nets on pages (.svg .pdf .dxf .html)",
        ),
        (
            ["cube.ply", "-o", "a.svg", "--kerf", "2", "--joints", "stitches"],
            "kerf is 2 mm, as wide as a hole of 1 mm",
        ),
        (["cube.ply", "-o", "a.svg", "--allowance", "5"], "is for --joints stitches or --joints none"),
        (
            ["cube.ply", "-o", "a.json", "--paper", "A3"],
            "--paper is for nets on pages (.svg .pdf .dxf .html)",
        ),
        (["cube.ply", "-o", "a.json", "--numbers"], "--numbers is for nets on pages (.svg .pdf .dxf .html)"),
        (["cube.ply", "-o", "a.svg", "--scale", "3", "--size", "3"], "not both"),
        (["cube.ply", "-o", "a.svg", "--paper", "A9"], "paper is 'A9', not one of A0, A1,"),
        (
            ["cube.ply", "-o", "a.svg", "--scale", "300"],
            "scale is 300 mm, but face 0 fits on A4 up to --scale 182; --paper A2 is large enough",
        ),
        (["cube.ply", "-o", "a.svg", "--cut", "3"], "'3' is not a pair of vertex numbers such as 3-17"),
        (["cube.ply", "-o", "a.svg", "--objective", "page"], "invalid choice: 'page'"),
        (
            ["cube.ply", "-o", "a.svg", "--objective", "pages"],
            "size of the solid: give a scale or a size",
        ),
        (["cube.ply", "-o", "a.json", "--objective", "pages"], "--objective pages is for nets on pages"),
        (
            ["cube.ply", "-o", "a.svg", "--glue"],
            "unrecognized arguments: --glue (see 'isoembed unfold --help')",
        ),
        (
            ["cube.ply", "-o", "a.svg", "--size", "2ft"],
            "argument --size: '2ft' is not a length such as 15, 15mm,",
        ),
        (["cube.ply", "-o", "a.svg", "--size", "20", "cm"], "unrecognized arguments: cm; did you mean 20cm?"),
        (["cube.ply", "-o", "a.svg", "--height", "20cm"], "--height; did you mean '--size'?"),
        (["cube.ply", "-o", "a.svg", "--size", "h=3"], "'h=3' is not an extent in x, y or z such as z=200"),
        (["cube.ply", "-o", "a.svg", "--size", "1,500"], "'1,500' is not a length such as 15, 15mm,"),
        (["cube.ply", "-o", "a.svg", "--cut", "0-0"], ": --cut 0-0 is not an edge between two faces"),
        (["cube.ply", "-o", "a.svg", "--scale", "0"], "scale is 0, not a positive finite number"),
        (
            ["cube.ply", "-o", "a.svg", "--scale", "3m"],
            "no format is large enough: give a page size, --paper WIDTHxHEIGHT in mm",
        ),
        (["cube.ply", "-o", "a.svg", "--paper", "21x29.7"], "; in centimeters, write '21x29.7cm'"),
        (["nothing.ply", "-o", "a.svg"], "there is no file nothing.ply"),
        (["metric.npz", "-o", "a.svg"], "metric.npz is a metric without vertices"),
    ],
)
def test_what_is_refused(arguments, words, call):
    vertices, faces = zoo.cube()
    for name in ("cube.ply", "cube.json"):
        write(name, vertices, faces)
    write_metric("metric.npz", PolyhedralMetric.from_mesh(vertices, faces))
    status, out, err = call("unfold", *arguments)
    assert (status, out) == (2, "")
    assert words in err


def test_an_open_box_and_a_torus(call):
    vertices, faces = zoo.cube()
    write("box.off", vertices, faces[2:])
    write("torus.off", *discs.torus(8, 6))
    for name, sides in (("box", 4), ("torus", 49)):
        status, said, _ = call("unfold", f"{name}.off", "-o", f"{name}.svg")
        assert (status, said.split(",")[:2]) == (0, ["1 sheet", f" {sides} pairs of sides"])
        assert ("; open: 1 boundary of 4 edges; " in said) == (name == "box")
        assert call("glue", f"{name}.svg", "-o", f"{name}.ply")[0] == 0


def test_a_net_of_many_folds_is_announced(call):
    write("ball.obj", *zoo.random_hull(250, 1))
    status, _, said = call("unfold", "ball.obj", "-o", "net.json")
    simplify = "simplify the mesh first, to the number of faces that you want to fold"
    assert (status, said) == (0, f"isoembed: note: 495 folds: {simplify}\n")
    assert call("unfold", "ball.obj", "-o", "net.json", "--quiet")[2] == ""


@pytest.mark.parametrize("kind", ["svg", "dxf"])
def test_the_solid_comes_back_from_a_drawing(kind, call):
    if kind == "dxf":
        pytest.importorskip("ezdxf")
    write("cube.off", *zoo.cube())
    how = ["--scale", "40", "--kerf", "0.2", "--bends", "perforate", "--joints", "none"]
    assert call("unfold", "cube.off", "-o", f"net.{kind}", *how)[0] == 0
    status, _, err = call("glue", f"net.{kind}", "-o", "again.npz")
    assert (status, err) == (0, "")
    apart = np.sort(pdist(read_surface("again.npz").vertices)) - np.sort(pdist(40 * zoo.cube()[0]))
    assert np.abs(apart).max() < 1e-3


def test_a_page_of_the_folding(call, tmp_path):
    write("cube.off", *zoo.cube())
    assert call("unfold", "cube.off", "-o", "cube.html", "--paper", "A3", "--quiet") == (0, "", "")
    text = (tmp_path / "cube.html").read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>") and "data:image/svg+xml;base64," in text
