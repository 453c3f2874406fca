"""Meshes as they come, from the command line: merged, and noted on standard error."""

import numpy as np
import pytest

CORNERS = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
SQUARES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
MERGED = "isoembed: note: 16 vertices are merged with others; the first is vertex 8 with vertex 0\n"


def obj(path, vertices, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(map(str, face)) for face in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def apart(tmp_path):
    """A cube of six squares with vertices of their own."""
    return obj(tmp_path / "apart.obj", CORNERS[SQUARES.ravel()], np.arange(24).reshape(6, 4))


def test_merge_on_every_command_that_reads_a_mesh(call, apart):
    for arguments in (
        ("embed", apart, "--method", "alexandrov", "-o", "a.ply"),
        ("inspect", apart),
        ("view", apart, "-o", "a.html"),
        ("energy", apart, "-o", "b.ply"),
    ):
        status, _, complaint = call(*arguments)
        assert status == 2 and complaint.count("\n") == 1
        assert "24 vertices coincide with others (vertex 0 and" in complaint
        assert "merge them with --merge 1e-05" in complaint
        for option in (["--merge"], ["--merge=0"], ["--merge", "1e-7"]):
            assert call(*arguments, *option)[::2] == (0, MERGED)


def test_quiet_has_no_notes(call, apart):
    assert call("embed", apart, "--merge", "--method", "alexandrov", "--quiet", "-o", "a.npz") == (0, "", "")


def test_notes_belong_to_the_one_line_of_a_refusal(call, tmp_path):
    twisted = CORNERS.copy()
    twisted[7] = [0.4, 0.5, 0.6]
    status, _, complaint = call("embed", obj(tmp_path / "t.obj", twisted, SQUARES), "--method", "alexandrov")
    assert status == 2 and complaint.count("\n") == 1
    assert "the metric is not convex" in complaint and " (note: 3 faces are not planar" in complaint


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("--merge", "apart.obj"),
            "'apart.obj' is not a number (put files before --merge, not after it)",
        ),
        (("apart.obj", "--merge", "1"), "1 is not a number of mean edge lengths in [0, 1)"),
        (("apart.obj", "--merge", "nan"), "nan is not a number of mean edge lengths in [0, 1)"),
    ],
)
def test_tolerances_that_are_none(call, apart, arguments, sentence):
    status, _, complaint = call("inspect", *arguments)
    assert status == 2 and sentence in complaint


def test_lengths_are_not_merged(call):
    call("surface", "ellipsoid", "--vertices", "12", "-o", "a.npz")
    status, _, complaint = call("inspect", "a.npz", "--merge")
    assert status == 2 and "a.npz holds lengths: merging applies to files" in complaint
