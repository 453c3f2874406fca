"""Shape files of AHFinderDirect, written here from surfaces that are known: read, completed, and refused."""

import gzip

import numpy as np
import pytest

from horizon_texts import AXES, ORIGIN, lopsided, shape_text
from isoembed.io.files import FileError
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity.horizons.ahfinderdirect import read_ahfinderdirect
from isoembed.surface.measures import volume
from places import SHARED

FILES = SHARED / "real"


def mirrored(u, powers=(2, 2, 2)):
    """A radius that is even in the coordinates whose power is 2."""
    x, y, z = u.T
    return (
        0.7 + 0.1 * x ** powers[0] + 0.05 * y ** powers[1] + 0.07 * z ** powers[2] + 0.04 * (x * y * z) ** 2
    )


def half_turn(u):
    """Symmetric under a rotation by 180 degrees about z and the reflection in z, and under nothing else."""
    x, y, z = u.T
    return 0.7 + 0.1 * x * y + 0.06 * x**2 + 0.05 * z**2 * x * y


def quarter_turn(u):
    """Symmetric under a rotation by 90 degrees about z, and maybe the reflection in z."""
    x, y, z = u.T
    return 0.7 + 0.3 * x * y * (x**2 - y**2) + 0.05 * z**2


def read(text, tmp_path, name="h.t0.ah1.gp"):
    path = tmp_path / name
    path.write_text(text)
    return read_ahfinderdirect(path)


def check(shape, radius, n, origin=ORIGIN):
    """The whole surface, closed, outward, at the right radius, nothing twice."""
    assert len(shape.points) == 6 * n**2 - 12 * n + 8
    triangulation = Triangulation(shape.faces)
    assert triangulation.n_vertices == len(shape.points)
    arrow = shape.points - origin
    r = np.linalg.norm(arrow, axis=1)
    np.testing.assert_allclose(r, radius(arrow / r[:, None]), rtol=1e-8)
    np.testing.assert_allclose(shape.center, origin)
    a, b, c = arrow[shape.faces.T]
    assert np.all(np.einsum("fi,fi->f", a, np.cross(b, c)) > 0)


@pytest.mark.parametrize("ghosts", [0, 2])
@pytest.mark.parametrize("n", [5, 19])
def test_six_patches(n, ghosts, tmp_path):
    shape = read(shape_text(lopsided, n, ghosts), tmp_path, "h.t64.ah2.gp")
    check(shape, lopsided, n)
    assert (shape.name, shape.time, shape.iteration) == ("ah2", None, 64)
    assert shape.source.endswith("h.t64.ah2.gp")
    assert f"the coordinates of {len(shape.points)} points of a horizon, but no metric" in shape.contents
    if n == 19:
        assert len(shape.points) == 1946 and len(shape.faces) == 3888
        assert volume(shape.faces, shape.points) == pytest.approx(4.0 / 3.0 * np.pi * 0.7**3, rel=0.02)


SYMMETRIC = {
    "z": (lambda u: mirrored(u, (3, 1, 2)), {2: 1}, 5),
    "z, lower half": (lambda u: mirrored(u, (1, 1, 2)), {2: -1}, 5),
    "x": (lambda u: mirrored(u, (2, 1, 1)), {0: 1}, 5),
    "y": (lambda u: mirrored(u, (3, 2, 1)), {1: -1}, 5),
    "x and y": (lambda u: mirrored(u, (2, 2, 1)), {0: 1, 1: 1}, 4),
    "x and z": (lambda u: mirrored(u, (2, 1, 2)), {0: 1, 2: 1}, 4),
    "octant": (mirrored, {0: 1, 1: 1, 2: 1}, 3),
    "a sphere's octant": (lambda u: 0.7 + 0.0 * u[:, 0], {0: 1, 1: 1, 2: 1}, 3),
    "half turn": (half_turn, {0: 1}, 5),
    "half turn about the other axis, and z": (half_turn, {1: 1, 2: 1}, 4),
    "quarter turn": (quarter_turn, {0: 1, 1: 1}, 4),
    "quarter turn and z": (quarter_turn, {0: 1, 1: 1, 2: 1}, 3),
}


@pytest.mark.parametrize("ghosts", [0, 2])
@pytest.mark.parametrize("radius, half, patches", SYMMETRIC.values(), ids=SYMMETRIC)
def test_what_symmetric_runs_leave_out_is_completed(radius, half, patches, ghosts, tmp_path):
    text = shape_text(radius, 13, ghosts, half)
    assert f"N_patches = {patches}" in text
    check(read(text, tmp_path), radius, 13)


def test_far_from_where_the_coordinates_begin(tmp_path):
    """Ten digits do not put the points on the seams in quite the same place."""
    origin = np.array([8e3, 0.0, 0.0])
    shape = read(shape_text(lopsided, 9, 0, None, origin), tmp_path)
    assert len(shape.points) == 386 and Triangulation(shape.faces).n_vertices == 386


@pytest.mark.parametrize("scale", [1e-90, 1e-6, 1e80])
def test_scales(scale, tmp_path):
    origin = scale * ORIGIN
    shape = read(shape_text(lambda u: scale * half_turn(u), 7, 1, {0: 1, 2: 1}, origin), tmp_path)
    check(shape, lambda u: scale * half_turn(u), 7, origin)


def test_compressed_and_other_comments(tmp_path):
    text = shape_text(lopsided, 7)
    path = tmp_path / "h.t0.ah1.gp.gz"
    path.write_bytes(gzip.compress(text.encode()))
    check(read_ahfinderdirect(path), lopsided, 7)
    other = text.replace("# N_patches = ", "% n_patches: ").replace("### ", "#").replace("\n", "\r\n")
    check(read(other.replace("# ghosted_gfn", "! ghosted"), tmp_path), lopsided, 7)


def cut(text, lines):
    return "\n".join(text.splitlines()[:lines])


def change(text, line, old, new):
    lines = text.splitlines()
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new, 1)
    return "\n".join(lines)


TEXT = shape_text(lopsided, 5)
# Line 12 is the first of numbers; a patch of 5 x 5 takes 8 + 25 + 5 + 1 lines.
ANY = shape_text(lambda u: 0.7 + u @ [0.1, 0.05, 0.0], 13, 0, {0: 1})  # creased whatever completes it
BAD = {
    "cut in a patch": (cut(TEXT, 60), r"line 60: the patch \+x ends after \d+ rows; 5 x 5"),
    "cut between patches": (cut(TEXT, 3 + 4 * 39), r"ends at line 158 after 4 of 6 patches"),
    "cut in the header": (cut(TEXT, 2), r"ends at line 2 after 0 of 6 patches"),
    "empty patch": (cut(TEXT, 3 + 39 + 8), r"line 43: the patch \+x ends after 0 rows"),
    "columns": (change(TEXT, 14, "\t", "\t1 "), r"line 14: there are 7 columns, not 6"),
    "a word": (change(TEXT, 13, "-45", "west"), r"line 13: could not convert string to float: 'west'"),
    "radius": (change(TEXT, 15, "0.", "1."), r"line 15: the radius is 1\.\d+, but the point is at .* 0\."),
    "nan": (change(TEXT, 15, "0.", "nan #"), r"line 15: "),
    "origin": (change(TEXT, 2, "-0.5", ""), r"line 2: '# origin = 3.25 0' does not give 3 finite numbers"),
    "no number": (change(TEXT, 5, "5", "nan"), r"line 5: '# N_rho = nan' does not give 1 finite numbers"),
    "no patch": (change(TEXT, 4, "###", "# a"), r"line 12: there are numbers before a line '### \+z patch'"),
    "no origin": (
        change(TEXT, 2, "origin", "o"),
        r"line 12: there are numbers before a line '# origin = x y z'",
    ),
    "twice": (TEXT.replace("-z patch", "+y patch"), r"line 199: the patch \+y occurs twice"),
    "other files": ("# 1:cctk_iteration\n0 1 2\n", "has no line '# N_patches = ...': it is not a shape file"),
    "a patch missing": (
        shape_text(lopsided, 5, only=AXES[:5]),
        r"the patch -z is missing, and no reflection supplies it, as the patch \+x reaches across z = -0.5",
    ),
    "two patches missing": (
        shape_text(lopsided, 5, only=["+z", "+x", "-x", "-z"]),
        r"has neither the patch \+y nor the patch -y",
    ),
    "patches elsewhere": (
        "# N_patches = 4\n# origin = 0 0 0\n"
        + "".join(
            f"### {name} patch\n0 0 1 {point}\n"
            for name, point in (("+z", "0 1 0"), ("+x", "0 1 0"), ("+y", "0 0 1"), ("-y", "0 1 0"))
        ),
        r"no point of the patch \+z is in the direction \+z",
    ),
    "no symmetry": (
        ANY,
        r"neither reflections nor rotations by 180 degrees complete it smoothly \(creases of 0.0",
    ),
}


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_refusals(text, message, tmp_path):
    with pytest.raises(FileError, match=message) as refusal:
        read(text, tmp_path)
    assert "h.t0.ah1.gp" in str(refusal.value)


def test_unreadable_files(tmp_path):
    with pytest.raises(FileError, match="there is no file"):
        read_ahfinderdirect(tmp_path / "h.t0.ah1.gp")
    path = tmp_path / "h.t0.ah1.gp.gz"
    path.write_bytes(gzip.compress(TEXT.encode())[:-20])
    with pytest.raises(FileError, match="cannot decompress"):
        read_ahfinderdirect(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="is not a text file"):
        read_ahfinderdirect(path)


@pytest.mark.shared
@pytest.mark.parametrize(
    "name, origin",
    [
        ("einsteintoolkit/AHFD_find_1_horizon.h.t0.ah1.gp", [4.0, 0.0, 0.0]),
        ("einsteintoolkit/EinsteinExact_KS-tilted-EE.h.t0.ah1.gp", [0.0, 0.0, 0.0]),
        ("kuibit/h.t1024.ah1.gp", [5.3290163, 0.42076834, 0.0]),
    ],
)
def test_files_of_others(name, origin):
    shape = read_ahfinderdirect(FILES / name)
    assert len(shape.points) == 1946 and Triangulation(shape.faces).n_vertices == 1946
    np.testing.assert_allclose(shape.center, origin, atol=1e-8)


@pytest.mark.shared
def test_the_horizon_of_a_tilted_kerr_black_hole():
    """In Kerr-Schild coordinates it is a spheroid about its axis, of half axes r_+ and sqrt(r_+^2 + a^2)."""
    shape = read_ahfinderdirect(FILES / "einsteintoolkit" / "EinsteinExact_KS-tilted-EE.h.t0.ah1.gp")
    r = 1.0 + np.sqrt(1.0 - 0.6**2)
    axis = np.array([0.0, np.sin(0.4), np.cos(0.4)])
    fits = []
    for sign in (1.0, -1.0):
        along = shape.points @ (axis * [1.0, sign, 1.0])
        across = np.sum(shape.points**2, axis=1) - along**2
        fits.append(np.max(np.abs(along**2 / r**2 + across / (r**2 + 0.6**2) - 1.0)))
    assert min(fits) < 5e-3 < 3e-2 < max(fits)
