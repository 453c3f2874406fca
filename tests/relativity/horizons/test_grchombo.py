"""Coordinate files of GRChombo, from files written here in its layout."""

import numpy as np
import pytest

from finder_files import grchombo_stats, grchombo_text, lopsided
from isoembed.io.files import FileError
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity import KerrSchild, read_horizon
from isoembed.relativity.horizons.horizon import horizon_data

ORIGIN = np.array([16.25, 16.0, 15.5])
STATS = grchombo_stats([(0.0, 0, (0.0, 0.0, 0.0)), (0.75, 12, ORIGIN), (1.0, 13, (1.0, 2.0, 3.0))])
ROUNDING = 1e-7  # angles and radii have seven decimals


def write(folder, text, stats=STATS, name="coords_AH2_000012.dat"):
    (folder / name).write_text(text)
    if stats:
        (folder / "stats_AH2.dat").write_text(stats)
    return folder / name


def check(shape, center):
    np.testing.assert_array_equal(shape.center, center)
    arrows = shape.points - center
    r = np.linalg.norm(arrows, axis=1)
    np.testing.assert_allclose(r, lopsided(arrows / r[:, None]), atol=ROUNDING)


@pytest.mark.parametrize("more", [(), ("g11", "K33")])
@pytest.mark.parametrize("tracked", [True, False])
def test_a_shape_about_the_origin_in_the_table(tracked, more, tmp_path):
    stats = grchombo_stats([(0.75, 12, (9.0, 9.0, 9.0)), (1.5, 12, ORIGIN)], tracked)  # after a restart
    shape = read_horizon(write(tmp_path, grchombo_text(more=more), stats))
    assert (shape.name, shape.time, shape.iteration, shape.notes) == ("AH2", 1.5, None, ())
    assert len(shape.points) == 11 * 20 + 2 == Triangulation(shape.faces).n_vertices
    check(shape, ORIGIN)


def test_the_table_may_be_in_the_folder_above(tmp_path):
    (tmp_path / "coords").mkdir()
    (tmp_path / "stats_AH2.dat").write_text(STATS)
    check(read_horizon(write(tmp_path / "coords", grchombo_text(), None)), ORIGIN)


def test_even_heights(tmp_path):
    shape = read_horizon(write(tmp_path, grchombo_text(uniform=True)))
    assert len(shape.points) == 13 * 20
    check(shape, ORIGIN)


def test_without_a_table_the_origin_is_assumed_and_said(tmp_path):
    path = write(tmp_path, grchombo_text().replace("theta", "    u").replace("phi", "  v"), None)
    shape = read_horizon(path)
    assert shape.time is None
    check(shape, np.zeros(3))
    note = (
        f"the radii in {path} are assumed to be about (0, 0, 0): there is no stats_AH2.dat with their origin"
    )
    assert shape.notes == (note,)
    assert note in horizon_data(shape, KerrSchild(1.0, (0.0, 0.0, 0.0)))[0].notes


def test_radii_at_a_pole_are_averaged(tmp_path):
    """GRChombo sets dr/dtheta = 0 there for each phi, and gets as many radii."""
    rows = [line.split() for line in grchombo_text().splitlines()[1:]]
    rows = [[t, p, r if float(t) else f"{0.95 + 0.01 * np.cos(float(p)):.7f}"] for t, p, r in rows]
    text = "\n".join(["# theta phi r", *map(" ".join, rows), ""])
    shape = read_horizon(write(tmp_path, text))
    arrows = shape.points - ORIGIN
    poles = arrows[np.hypot(arrows[:, 0], arrows[:, 1]) < 1e-3]
    np.testing.assert_allclose(np.sort(poles[:, 2]), [-0.85, 0.95], atol=ROUNDING)


def rows(text, keep):
    lines = text.splitlines()
    return "\n".join([lines[0], *(line for k, line in enumerate(lines[1:]) if keep(k)), ""])


BAD = {
    "cut in a meridian": (
        lambda text: rows(text, lambda k: k < 200),
        "its 200 points are not a whole grid of 13",
    ),
    "cut between meridians": (lambda text: rows(text, lambda k: k < 13 * 15), "not a whole grid of 13 x 15"),
    "a half": (lambda text: rows(text, lambda k: k % 13 < 7), "not a whole grid of 7 x 20 angles"),
    "beyond the poles": (
        lambda text: text.replace("3.1415927", "3.4000000"),
        "not a whole grid of 13 x 20 angles",
    ),
    "twice": (lambda text: rows(text, lambda k: k) + text.splitlines()[2], "not a whole grid of 13 x 20"),
    "a radius of 0": (
        lambda text: text.replace(text.splitlines()[4], "0.7853982 0.0 0.0"),
        "line 5: an angle is not finite, or the radius is not positive",
    ),
    "two columns": (
        lambda text: "# theta phi r\n0.1 0.2\n",
        "line 2: there are 2 columns, fewer than 3",
    ),
}


@pytest.mark.parametrize("change, message", BAD.values(), ids=BAD)
def test_refusals(change, message, tmp_path):
    path = write(tmp_path, change(grchombo_text()))
    with pytest.raises(FileError, match=message) as refusal:
        read_horizon(path)
    assert str(refusal.value).startswith(str(path))


@pytest.mark.parametrize(
    "stats, message",
    [
        (
            grchombo_stats([(0.0, 0, ORIGIN)]),
            r"stats_AH2\.dat has no row of the file 12, .*coords_AH2_000012\.dat",
        ),
        ("1 2 3\n", r"stats_AH2\.dat has no columns 'time file \.\.\. origin_z'"),
        (grchombo_stats([(0.75, 12, (np.nan, 0.0, 0.0))]), "point 0 is not finite"),
    ],
)
def test_tables_that_are_none(stats, message, tmp_path):
    with pytest.raises(FileError, match=message):
        read_horizon(write(tmp_path, grchombo_text(), stats))


def test_other_tables(tmp_path):
    path = tmp_path / "constraints.dat"
    path.write_text("# time Ham\n0.0 1.0\n")
    with pytest.raises(FileError, match=r"is neither a file of .* of GRChombo \(coords_AH\*\.dat\)"):
        read_horizon(path)
