"""``isoembed struts``: tables of domes, and back to the dome."""

import csv
import json

import numpy as np
import pytest

from domes import dome
from isoembed.io import mesh_writer, read_surface, write_atomically


@pytest.fixture
def half(call):
    """Half a 2V dome, in a file."""
    vertices, faces = dome(2, -0.01)
    write_atomically({"dome.obj": mesh_writer("dome.obj", vertices, faces)})
    return vertices


def test_the_table_and_the_dome_back_from_it(half, call):
    status, out, err = call("struts", "dome.obj", "-o", "struts.csv")
    assert (status, err) == (0, "")
    assert out.startswith("65 struts of 2 types, 26 hubs of 3 types, 40 faces of 2 types; on a sphere of ")
    with open("struts.csv", newline="") as file:
        header, first, second = list(csv.reader(file))[:3]
    assert header[:3] == ["type", "count", "length"]
    assert [first[:2], second[:2]] == [["A", "30"], ["B", "35"]]
    assert call("embed", "struts.csv", "--boundary", "plane", "-o", "again.npz", "--quiet") == (0, "", "")
    again = read_surface("again.npz")
    assert np.ptp(again.vertices[again.triangulation.boundary_vertices, 2]) < 1e-9
    assert np.ptp(again.vertices[:, 2]) == pytest.approx(np.ptp(half[:, 2]), abs=1e-9)


def test_on_the_screen_and_as_json(half, call):
    status, out, err = call("struts", "dome.obj", "--hub-radius", "0.01", "--stock", "3")
    assert (status, err) == (0, "")
    assert "cut length" in out and "13 bars of 3, 5.8% left over" in out
    status, out, err = call("struts", "dome.obj", "--json", "--tolerance", "0.1")
    assert (status, err) == (0, "")
    assert [one["count"] for one in json.loads(out)["strut_types"]] == [65]


def test_a_picture(half, call, tmp_path):
    pytest.importorskip("matplotlib")
    status, out, err = call("struts", "dome.obj", "-o", "a.json", "--picture", "a.png", "--quiet")
    assert (status, out, err) == (0, "", "")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_few_digits_are_fitted(call):
    vertices, faces = dome(4)
    write_atomically({"dome.obj": mesh_writer("dome.obj", vertices, faces)})
    assert call("struts", "dome.obj", "-o", "exact.csv", "--quiet")[0] == 0
    with open("exact.csv", newline="") as file:
        legend, _, _, struts, _ = file.read().split("\n\n")
    rounded = [f"{row.split(',')[0]},{float(row.split(',')[2]):.3f}" for row in legend.splitlines()[1:]]
    joined = [",".join(row.split(",")[1:4]) for row in struts.splitlines()]
    with open("typed.csv", "w") as file:
        file.write("\n".join(["type,length", *rounded, "", *joined, ""]))
    status, _, err = call("embed", "typed.csv", "-o", "dome.npz")
    assert (status, err) == (0, "")
    radii = np.linalg.norm(read_surface("dome.npz").vertices, axis=1)
    assert np.ptp(radii) < 5e-3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["dome.obj", "-o", "a.txt"], "a.txt has the ending '.txt', not one of .csv .json"),
        (["dome.obj", "-o", "dome.obj"], "dome.obj has the ending '.obj', not one of .csv .json"),
        (["dome.obj", "--tolerance", "-1"], "argument --tolerance: -1 is not a non-negative length"),
        (["dome.obj", "--stock", "x"], "argument --stock: 'x' is not a number (see"),
        (["dome.obj", "--stock", "1m"], "'1m' is not a number: lengths are in the unit of the file"),
        (["dome.obj", "--stock", ".5"], "a strut of type B is 0.618034 long, more than a bar of 0.5"),
        (["dome.obj", "--hub-radius", "3"], "hubs of radius 3 overlap: struts of type A are 0.546533 long"),
    ],
)
def test_refusals(arguments, words, half, call):
    status, _, err = call("struts", *arguments)
    assert status == 2
    assert words in err
