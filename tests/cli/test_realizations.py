"""``isoembed realizations``: what is listed, what is written, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed import PolyhedralMetric
from isoembed.cli.realizations import LEGEND
from isoembed.io import read_surface, write_metric
from strict_json import strict


@pytest.fixture
def files():
    """A metric, m.npz, with two realizations, and one of them, s.npz: an icosahedron, an apex out or in."""
    x, faces = zoo.icosahedron()
    normal = x[faces[0]].mean(axis=0)
    x = np.vstack([x, 1.02 * normal])
    a, b, c = faces[0]
    faces = np.vstack([faces[1:], [[a, b, 12], [b, c, 12], [c, a, 12]]])
    metric = PolyhedralMetric.from_mesh(x, faces)
    write_metric("m.npz", metric)
    np.savez("s.npz", vertices=x, faces=faces)
    return metric


@pytest.mark.parametrize("command", [["realizations", "s.npz", "m.npz"], ["embed", "s.npz", "m.npz"]])
def test_a_file_is_no_folder(call, files, command):
    status, out, err = call(*command, "-o", "m.npz")
    assert (status, out, err) == (2, "", "isoembed: error: the output m.npz is not a folder\n")
    status, out, err = call(*command, "-o", "new.ply")
    assert (status, out) == (2, "")
    assert "the output new.ply would be a folder for several files: give one without .ply" in err
    assert not Path("new.ply").exists()


def test_the_realizations_are_listed_and_written(call, files, monkeypatch):
    status, out, err = call("realizations", "s.npz", "m.npz", "-o", "out")
    assert (status, err) == (0, "")
    head, first, second, legend, message, files_written = out.splitlines()
    assert head.split() == ["distance", "nearest", "roughness", "fine", "radius", "isolation"]
    assert (first.split()[0], second.split()[0]) == ("1", "2")
    assert [line.count("SURFACE itself") for line in (first, second)].count(1) == 1
    assert legend == LEGEND
    assert message.startswith("2 realizations of these lengths found within 0.12 mean edge lengths of the")
    assert files_written.startswith("out/realization-1.ply, out/realization-2.ply written, ")
    surfaces = [read_surface(Path("out", f"realization-{i}.ply")) for i in (1, 2)]
    for surface in surfaces:
        assert surface.metric.lengths == pytest.approx(files.lengths, abs=1e-12)
    assert sorted(surface.surface.concave_edges.any() for surface in surfaces) == [False, True]
    found = strict(call("realizations", "s.npz", "--json", "--surfaces", "1")[1])  # the lengths are the same
    assert found["region"] == {"distance": 0.12, "motions": 5, "unsolved": 0}
    assert [each["searched"] for each in found["realizations"]].count(True) == 1
    monkeypatch.setattr("isoembed.cli.realizations.LISTED", 1)
    head, row, more, legend, _ = call("realizations", "s.npz", "m.npz")[1].splitlines()
    assert "SURFACE itself" in row
    assert more == "the 1 nearest of 2; --json and --output have all"
    assert found["apart"][0][1] > found["realizations"][0]["certificate"]["isolation"]


def test_none_is_found(call, files):
    write_metric("other.npz", files.with_lengths(files.lengths * np.linspace(1, 1.3, len(files.lengths))))
    status, out, _ = call("realizations", "s.npz", "other.npz", "--distance", "1e-3", "-o", "out")
    assert status == 3
    assert out.startswith("no realization of these lengths was found within 0.001 mean edge lengths")
    assert not Path("out").exists()
    found = strict(call("realizations", "s.npz", "other.npz", "--distance", "1e-3", "--json")[1])
    assert found["realizations"] == [] and found["evidence"] == "searched"
    assert found["basis"] in found["message"] and found["message"].endswith("that are not predicted")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--motions", "9"], "the number of motions is 9, not an integer from 2 to 8"),
        (["--distance", "-1"], "the distance is -1.0, not a positive number of mean edge lengths"),
    ],
)
def test_numbers_out_of_range(call, files, arguments, sentence):
    assert call("realizations", "s.npz", "m.npz", *arguments) == (2, "", f"isoembed: error: {sentence}\n")


def test_files_that_do_not_go_together(call, files):
    write_metric("small.npz", PolyhedralMetric.from_mesh(*zoo.icosahedron()))
    status, _, err = call("realizations", "s.npz", "small.npz")
    assert (status, err) == (
        2,
        "isoembed: error: s.npz has 13 vertices, small.npz has 12: realizations are on the same triangles, "
        "with the same numbers of vertices\n",
    )


def test_the_input_is_not_overwritten(call, files):
    assert call("embed", "m.npz", "-o", "realization-1.ply")[0] == 0
    status, _, err = call("realizations", "realization-1.ply", "m.npz", "-o", ".")
    assert status == 2
    assert "realization-1.ply would overwrite the input: take another folder" in err


def test_which_of_them_is_the_answer(call, files):
    assert call("embed", "m.npz", "--which", "smoothest", "-o", "out.ply")[0] == 0
    assert call("embed", "m.npz", "--which", "convex", "-o", "out.ply")[0] == 0
    assert not read_surface(Path("out.ply")).surface.concave_edges.any()
    x, faces = np.load("s.npz")["vertices"], files.faces
    x[-1] *= 0.96 / 1.02  # the apex pushed in
    np.savez("near.npz", vertices=3 * x, faces=faces)
    assert call("embed", "m.npz", "--which", "near.npz", "-o", "out.ply")[0] == 0
    assert read_surface(Path("out.ply")).surface.concave_edges.any()


def test_the_surface_of_the_file_may_be_another_realization(call, files):
    x, faces = np.load("s.npz")["vertices"], files.faces
    assert call("embed", "s.npz", "-o", "out.ply")[2] == ""
    x[-1] *= 0.98 / 1.02  # the mirror image of the apex in its triangle
    np.savez("dented.npz", vertices=x, faces=faces)
    _, _, err = call("embed", "dented.npz", "-o", "out.ply")
    assert "the surface in dented.npz has these lengths, too, and is 0.0" in err
    assert "--which dented.npz returns it" in err
    assert call("embed", "dented.npz", "--which", "dented.npz", "-o", "out.ply")[2] == ""
    assert isoembed.embed("dented.npz").distance(x) > 0.01
    assert read_surface(Path("out.ply")).surface.concave_edges.any()


def test_the_surface_of_the_file_is_returned_where_the_search_fails(call, files):
    x, faces = zoo.icosphere(1)
    x = x * (1 + 0.3 * np.random.default_rng(0).standard_normal((len(x), 1)))
    np.savez("star.npz", vertices=x, faces=faces)
    status, _, err = call("embed", "star.npz", "--effort", "0")
    assert status == 3
    assert "the surface in star.npz has these lengths: --which star.npz returns it" in err
    assert call("embed", "star.npz", "--effort", "0", "--which", "star.npz", "-o", "out.ply")[0] == 0
    found = read_surface(Path("out.ply"))
    assert smooth_bodies.misfit(found.vertices, x) < 1e-12


def test_other_surfaces_to_be_near_to_are_refused(call, files):
    x, faces = zoo.icosahedron()
    np.savez("other.npz", vertices=x, faces=faces)
    status, out, err = call("embed", "m.npz", "--which", "other.npz")
    assert (status, out) == (2, "")
    assert "error: other.npz has 12 vertices, m.npz has 13: 'nearest' is defined for a surface on" in err
    status, _, err = call("embed", "m.npz", "--which", "none.ply")
    assert status == 2 and "none.ply" in err
    status, _, err = call("embed", "m.npz", "--method", "alexandrov", "--which", "convex")
    assert status == 2 and "--which needs the method 'aim'" in err
