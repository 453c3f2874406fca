"""Shape files of BHaHAHA, from files written here in its layout."""

import gzip

import numpy as np
import pytest

from finder_files import bhahaha_text, lopsided
from isoembed.io.files import FileError
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity import read_horizon

CENTER = np.array([3.25, -1.0, 0.5])


def read(folder, text, name="h.t0000064.ah2.gp"):
    (folder / name).write_text(text)
    return read_horizon(folder / name)


@pytest.mark.parametrize("center", [CENTER, (0.0, 0.0, 0.0), (1024.0, 0.0, -512.0)])
def test_a_shape_and_its_center(center, tmp_path):
    shape = read(tmp_path, bhahaha_text(center=center))
    assert (shape.name, shape.iteration, shape.time) == ("ah2", 64, 1.25)
    assert len(shape.points) == 240 == Triangulation(shape.faces).n_vertices
    digits = 1e-10 * max(1.0, np.abs(center).max())
    np.testing.assert_allclose(shape.center, center, atol=digits)
    arrows = shape.points - center
    r = np.linalg.norm(arrows, axis=1)
    np.testing.assert_allclose(r, lopsided(arrows / r[:, None]), atol=10.0 * digits)


def test_a_compressed_file_of_another_name_without_a_time(tmp_path):
    lines = bhahaha_text().splitlines(keepends=True)
    path = tmp_path / "horizon.gp.gz"
    path.write_bytes(gzip.compress("".join(lines[1:]).encode()))
    shape = read_horizon(path)
    assert (shape.name, shape.iteration, shape.time) == ("", None, None)
    np.testing.assert_allclose(shape.center, CENTER, atol=1e-9)


def rounded(text):
    """The last point of each ring, which is its first, with other digits."""
    rings = text.rstrip("\n").split("\n\n")
    closed = (ring.rpartition(" ") for ring in rings)
    return "\n\n".join(f"{before} {float(z) + 1e-8!r}" for before, _, z in closed) + "\n\n"


@pytest.mark.parametrize("change", [rounded, lambda text: text.replace(" ", ", ")])
def test_rings_closed_to_rounding_and_commas(change, tmp_path):
    text = bhahaha_text()
    begin = text.index("\n") + 1
    changed = text[:begin] + change(text[begin:])
    assert changed != text
    found, other = read(tmp_path, text), read(tmp_path, changed, "h.t1.ah1.gp")
    np.testing.assert_allclose(found.center, other.center, atol=1e-9)


BAD = {
    "whole rings missing": (
        lambda text: "\n\n".join(text.split("\n\n")[:11]) + "\n\n",
        "the 11 rings of 20 points are not at the angles of a cell-centered grid",
    ),
    "cut in a ring": (
        lambda text: "\n".join(text.splitlines()[:40]) + "\n",
        "line 40: the ring that ends here does not have 20 points followed by the first one again",
    ),
    "cut in a row": (
        lambda text: "\n".join([*text.splitlines()[:40], "1.5 2.5"]),
        "line 41: there are 2 columns, not 3",
    ),
    "no blank lines": (
        lambda text: text.replace("\n\n", "\n"),
        "the ring that ends here does not have 251 points",
    ),
    "not closed": (lambda text: text.replace("\n\n", "\n1 2 3\n\n", 1), "line 26: the ring that ends here"),
    "one point": (lambda text: "1 2 3\n", "line 1: the ring that ends here does not have 3 points"),
    "not finite": (
        lambda text: "\n".join([*text.splitlines()[:5], "nan 0 0", *text.splitlines()[6:]]),
        "line 6: a coordinate is not finite",
    ),
    "huge": (
        lambda text: "\n".join([*text.splitlines()[:5], "1e200 1e300 0", *text.splitlines()[6:]]),
        "are not at the angles of a cell-centered grid",
    ),
    "a word": (lambda text: text + "1 2 x\n", "could not convert string to float: 'x'"),
    "another column": (lambda text: text + "1 2 3 4\n", "there are 4 columns, not 3"),
}


@pytest.mark.parametrize("change, message", BAD.values(), ids=BAD)
def test_refusals(change, message, tmp_path):
    with pytest.raises(FileError, match=message) as refusal:
        read(tmp_path, change(bhahaha_text()))
    assert str(refusal.value).startswith(str(tmp_path))
