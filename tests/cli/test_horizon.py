"""``isoembed horizon``: from files, written here from known horizons, to energies and what is written."""

import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from finder_files import ylm_legend, ylm_row, ylm_text
from horizons import IMC, check, shape_text, write_grid, write_kerr
from isoembed.cli import horizon as command
from isoembed.io import InputFile, read_metric
from isoembed.io.vtk import read_polydata
from isoembed.plot.series import stills
from isoembed.relativity import KerrSchild
from isoembed.relativity.series import horizon_task
from places import SHARED
from strict_json import strict

FILES = SHARED / "real" / "einsteintoolkit"
KERR_SCHILD = ["--geometry", "kerr-schild", "--vertices", 100]


@pytest.fixture
def run(call):
    """Call ``isoembed horizon`` in an empty folder."""
    return partial(call, "horizon")


def is_kerr(found, a):
    check(found, a)
    assert abs(found["christodoulou_mass"] - 1.0) <= 1e-7  # J about the axis of the spin
    assert found["horizon"]["points"] == 6 * 13**2 - 12 * 13 + 8
    assert found["horizon"]["largest_expansion"] < 1e-4
    assert found["name"] == "h.t0.ah1.gp" and found["status"] == "embedded"


@pytest.mark.slow
def test_a_horizon_in_kerr_schild_coordinates(run):
    spin = (-0.48, 0.36, 0.0)
    write_kerr("h.t0.ah1.gp", spin)
    status, out, err = run("h.t0.ah1.gp", *KERR_SCHILD, "--spin", *spin, "--json")
    assert (status, err) == (0, "")
    is_kerr(strict(out), 0.6)
    assert os.listdir() == ["h.t0.ah1.gp"]


def test_the_axis_is_found_whatever_axis_is_given(run):
    spin = np.array((0.0, 0.3, 0.4))
    write_kerr("h.gp", tuple(spin))
    geometry = [*KERR_SCHILD, "--spin", *spin]
    status, out, _ = run("h.gp", *geometry, "--json")
    found = strict(out)
    assert status == 0
    check(found, 0.5)
    assert abs(found["spin"]["J"] - 0.5) <= found["spin"]["error"] <= 1e-6
    assert np.linalg.norm(np.cross(found["spin"]["axis"], spin / 0.5)) <= found["spin"]["axis_error"] <= 1e-4
    np.testing.assert_allclose(found["spin"]["vector"], spin, atol=1e-6)
    assert "given_axis" not in found["spin"] and not found["notes"]
    assert abs(found["christodoulou_mass"] - 1.0) <= found["errors"]["christodoulou_mass"] <= 1e-6
    assert abs(found["dimensionless_spin"] - 0.5) <= found["errors"]["dimensionless_spin"] <= 1e-6
    status, out, _ = run("h.gp", *geometry, "--axis", 3, 4, 0)
    assert status == 0
    assert "note: about the axis that was given J is 0.24, and 0.5 about the one that was found" in out
    lines = {line[:26].rstrip(): line[26:] for line in out.splitlines()}
    assert abs(float(lines["Christodoulou mass"].split()[0]) - 1.0) < 1e-6
    assert abs(float(lines["angular momentum J"].split()[0]) - 0.5) < 1e-6
    assert "(0, 0.6, 0.8)" in out


def test_what_is_written(run):
    write_kerr("h.t0.ah1.gp", (0.0, 0.0, 0.5))
    status, out, err = run("h.t0.ah1.gp", *KERR_SCHILD, "--spin", 0, 0, 0.5, "-o", "deep/found")
    assert (status, err) == (0, "")
    assert sorted(os.listdir("deep/found")) == [f"h.t0.ah1.{ending}" for ending in ("json", "png", "vtk")]
    is_kerr(strict(Path("deep/found/h.t0.ah1.json").read_text()), 0.5)
    assert read_metric("deep/found/h.t0.ah1.vtk").triangulation.n_vertices == 100
    assert Path("deep/found/h.t0.ah1.png").read_bytes().startswith(b"\x89PNG")
    with InputFile(Path("deep/found/h.t0.ah1.vtk")) as file:
        shown = read_polydata(file)
    assert {"theta_plus", "theta_minus", "angular_momentum_density"} < set(shown.fields)
    assert np.abs(shown.fields["theta_plus"]).max() < 1e-4 and shown.fields["theta_minus"].max() < -0.1
    # z is z in both spaces, and the angles about it are the same.
    at, there = (
        points[:, 0] + 1j * points[:, 1] for points in (shown.points, shown.fields["slice_coordinates"])
    )
    assert np.abs((at / there).imag).max() < 1e-6 and (at / there).real.min() > 0.5
    assert b"CYCLE 1 1 double" in Path("deep/found/h.t0.ah1.vtk").read_bytes()
    for words in ("h.t0.ah1.gp\n", "Kijowski-Liu-Yau energy", "points, fitted to", "0 on a horizon"):
        assert words in out


@pytest.mark.slow
def test_a_grid_needs_no_geometry_and_without_matplotlib_there_is_no_picture(run, monkeypatch):
    write_grid("grid.npz", 0.5)
    status, out, err = run("grid.npz", "--vertices", 60, "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["hawking"] is None and found["liu_yau"] is None
    note = "not treated as a horizon, because k is unknown: if it is one, marginal=True gives its Hawking"
    assert note in found["notes"][0]
    status, out, err = run("grid.npz", "--marginal", "--vertices", 60, "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    check(found, 0.5)
    assert found["brown_york"] is None and found["horizon"] == {}
    assert "Brown-York" in found["notes"][0]
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    status, out, err = run("grid.npz", "--vertices", 60, "-o", "found")
    assert status == 0 and out.startswith("grid.npz\n")
    assert "pictures need matplotlib, pip install matplotlib" in err
    assert sorted(os.listdir("found")) == ["grid.json", "grid.vtk"]


REFUSED = [
    (["no.gp"], "there is no file no.gp"),
    (["h.gp"], "name it with --geometry"),
    (["grid.npz", "--geometry", "kerr-schild"], "grid.npz holds a metric of its own: it needs no --geometry"),
    (["h.gp", "./h.gp", *KERR_SCHILD], "have the same name: h"),
    (["h.gp", "h.npz", *KERR_SCHILD], "h.gp and h.npz have the same name: h"),
    (
        ["h.gp", "--geometry", "flat"],
        "the geometry flat: there are brill-lindquist, kerr-schild, boyer-lindquist, isotropic, ",
    ),
    (["h.gp", "--geometry", "no.h5"], "there is no file no.h5"),
    (
        ["h.gp", "--geometry", "isotropic", "--spin", 0, 0, 0.5],
        "--spin does not go with the geometry isotropic, which takes --mass and --center",
    ),
    (
        ["h.gp", "--geometry", "painleve-gullstrand", "--spin", 0, 0.1, 0],
        "--spin does not go with the geometry painleve-gullstrand",
    ),
    (
        ["h.gp", "--geometry", "slice.h5", "--mass", 2],
        "--mass does not go with the geometry slice.h5, a file",
    ),
    (["h.gp", "--geometry", "boosted"], "the geometry boosted needs --velocity"),
    (["h.gp", "--mass", 2], "--mass needs a --geometry"),
    (["h.gp", "--spin", 0, 0, 0.5], "--spin needs a --geometry"),
    (["h.gp", "--masses", 1, 1], "--masses needs a --geometry"),
    (["--masses", 1, 1, "h.gp", *KERR_SCHILD], "'h.gp' is not a number (files come before the options)"),
    (["h.gp", "--geometry", "kerr-schild", "--mass", -1], "the mass"),
    (["h.gp", "--geometry", "kerr-schild", "--mass", "nan"], "the mass"),
    (
        ["h.gp", "--geometry", "kerr-schild", "--spin", 0, 0],
        "--spin takes one number, along z, or three, not 2",
    ),
    (["h.gp", *KERR_SCHILD, "--axis", 0, 0, 0], "--axis 0 0 0 is not an axis"),
    (["grid.npz", "--axis", 0, 0, 1], "grid.npz has no coordinates for an --axis"),
    (["h.gp", *KERR_SCHILD[:2], "--vertices", 11], "--vertices must be at least 12, not 11"),
    (["bad.gp", *KERR_SCHILD], "bad.gp"),
    (["no.gp", "bad.gp", "-o", "found"], "there is no file no.gp; bad.gp"),
    (["grid.npz", "-o", "h.gp"], "the output h.gp is not a folder"),
    (["grid.npz", "-o", "h.gp/found"], "cannot make the folder h.gp/found"),
]


@pytest.mark.parametrize(("arguments", "sentence"), REFUSED)
def test_refusals(run, monkeypatch, arguments, sentence):
    monkeypatch.setattr(horizon_task, "embed_surface", lambda *_, **__: pytest.fail("it computed"))
    write_kerr("h.gp", (0.0, 0.0, 0.5))
    write_grid("grid.npz", 0.5)
    write_grid("h.npz", 0.5)
    Path("bad.gp").write_text("# N_patches = 6\n# origin = 0 0 0\n")
    status, _, err = run(*arguments)
    assert status == 2
    assert sentence in err


def test_the_expansion_tells_that_a_surface_is_no_horizon(run):
    Path("sphere.gp").write_text(shape_text(lambda u: np.full(len(u), 3.0)))
    status, out, _ = run("sphere.gp", "--geometry", "painleve-gullstrand", "--vertices", 60, "--json")
    assert status == 0
    found = strict(out)
    assert found["area"] == pytest.approx(36.0 * np.pi, rel=1e-9)
    # theta_+ = 2 / r - 2 sqrt(2 M / r) / r
    assert found["horizon"]["largest_expansion"] == pytest.approx(
        2.0 / 3.0 * (1.0 - np.sqrt(2.0 / 3.0)), rel=1e-6
    )


def test_the_expansion_or_an_option_decides_what_is_a_horizon(run):
    Path("near.gp").write_text(shape_text(lambda u: np.full(len(u), 2.001)))
    options = ["near.gp", "--geometry", "kerr-schild", "--vertices", 60]
    exact = 2.001 * (1.0 - np.sqrt(1.0 - 2.0 / 2.001))
    for option, marginal, liu_yau, error in (
        ((), True, 2.001, 0.1),
        (("--marginal",), True, 2.001, 3e-3),
        (("--not-marginal",), False, exact, 1e-9),
    ):
        status, out, _ = run(*options, *option, "--json")
        assert status == 0
        found = strict(out)
        assert found["horizon"]["marginal"] is marginal
        assert found["liu_yau"] == pytest.approx(liu_yau, rel=1e-9)
        assert found["errors"]["liu_yau"] < error
        assert any(note.startswith("treated as a horizon") for note in found["notes"]) is marginal
    status, _, err = run(*options, "--marginal", "--not-marginal")
    assert status == 2 and "not allowed with" in err


def test_a_horizon_in_a_slice_that_is_moved_and_its_wang_yau_energy(run):
    """In isotropic coordinates, around another center; outside of it, the least energy is that of tau = 0."""
    center = (1.0, -2.0, 0.5)
    for name, radius in (("h", 0.5), ("outside", 1.0)):
        Path(f"{name}.gp").write_text(shape_text(lambda u, r=radius: np.full(len(u), r), center))
    arguments = ["--geometry", "isotropic", "--center", *center, "--vertices", 60, "--wang-yau", "--json"]
    status, out, err = run("h.gp", "outside.gp", *arguments)
    assert (status, err) == (0, "")
    horizon, outside = strict(out)
    assert horizon["horizon"]["marginal"] and horizon["liu_yau"] == pytest.approx(2.0, rel=1e-12)
    assert horizon["wang_yau"] == pytest.approx(2.0, rel=1e-12)  # the limit, int k0 dA / 8 pi
    assert "arXiv:2406.10751" in horizon["minimum"]["notes"][0]
    R = 2.25
    exact = R * (1.0 - np.sqrt(1.0 - 2.0 / R))
    assert abs(outside["wang_yau"] - exact) <= outside["errors"]["wang_yau"] <= 1e-9
    assert outside["minimum"]["least_second_derivative"] > 0.0


def test_units(run):
    scale = 1e-3
    geometry = KerrSchild(scale, (0.0, 0.0, 0.5 * scale))
    Path("h.gp").write_text(shape_text(geometry.spheroid(geometry.horizon)))
    arguments = ["--mass", scale, "--spin", 0, 0, 0.5 * scale, "--json"]
    status, out, _ = run("h.gp", *KERR_SCHILD, *arguments)
    assert status == 0
    found = strict(out)
    assert found["liu_yau"] / scale == pytest.approx(IMC[0.5] / (4.0 * np.pi), rel=1e-7)
    assert found["errors"]["liu_yau"] <= 1e-6 * scale


@pytest.mark.shared
@pytest.mark.slow
def test_the_horizon_that_the_einstein_toolkit_found(run):
    """Of a Kerr black hole, a = 0.6, tilted; the file's own error is 0.3 % of the area."""
    spin = (0.0, -0.6 * np.sin(0.4), 0.6 * np.cos(0.4))
    name = FILES / "EinsteinExact_KS-tilted-EE.h.t0.ah1.gp"
    status, out, err = run(name, "--geometry", "kerr-schild", "--spin", *spin, "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["area"] == pytest.approx(45.12076, abs=2e-5)
    assert abs(found["area"] / 45.238934211693022 - 1.0) < 3e-3
    assert abs(found["integrated_mean_curvature"] / IMC[0.6] - 1.0) < 3e-3
    assert found["christodoulou_mass"] == pytest.approx(1.0, abs=5e-3)
    assert found["horizon"]["points"] == 1946


def test_the_picture_of_a_file_with_any_name_says_when_it_was(run, monkeypatch):
    captions = []
    drawn = stills.placed_figure
    monkeypatch.setattr(
        stills, "placed_figure", lambda panel, **o: captions.append(o["caption"]) or drawn(panel, **o)
    )
    name = f"h_$^{{{'x' * 60}.t{7}.gp"
    write_kerr(name, (0.0, 0.0, 0.0))
    status, _, err = run(name, *KERR_SCHILD, "-o", "found")
    assert (status, err) == (0, "")
    first, second = captions[0].split("\n")
    assert first == rf"h_\$^{{{'x' * 44}…     iteration 7"
    assert second.startswith("area 50.265")
    assert len(os.listdir("found")) == 3


def test_refusals_of_files_with_several_name_the_option(run):
    """A Python user is told the parameter, see tests/relativity/horizons/test_spectre.py."""
    from scattered import lattice, write_hdf5

    h5py = pytest.importorskip("h5py")
    points = {f"InertialCoordinates_{axis}": x for axis, x in zip("xyz", lattice(40).T, strict=True)}
    for name, surfaces, times in (("times.h5", ["AhA"], (0.5, 1.5)), ("surfaces.h5", ["AhA", "AhB"], (0.5,))):
        for surface in surfaces:
            for k, time in enumerate(times):
                group = f"{surface}.vol/ObservationId{k}"
                write_hdf5(name, points, group)
                with h5py.File(name, "a") as file:
                    file[group].attrs["observation_value"] = time
    status, _, err = run("times.h5", *KERR_SCHILD)
    assert status == 2
    assert "AhA holds 2 observations: choose one of t = 0.5, 1.5, by --time" in err
    status, _, err = run("surfaces.h5", *KERR_SCHILD)
    assert status == 2
    assert "holds several surfaces: choose one of AhA, AhB, by --surface" in err
    rows = [ylm_row(time, (0.0, 0.0, 0.0)) for time in (0.5, 1.5)]
    Path("AhC_Ylm.dat").write_text(ylm_text(rows, ylm_legend(4)))
    status, _, err = run("AhC_Ylm.dat", *KERR_SCHILD)
    assert status == 2
    assert "AhC holds 2 observations: choose one of t = 0.5, 1.5, by --time" in err
    status, _, err = run("AhC_Ylm.dat", "--time", "1.5", "--surface", "AhC")
    assert status == 2
    assert "AhC_Ylm.dat holds the coordinates of 512 points of a horizon, but no metric" in err
    status, _, err = run("h.t0.ah1.gp", "--time", "1.5", *KERR_SCHILD)
    assert status == 2
    assert "--time and --surface are for SpECTRE's files, and h.t0.ah1.gp is not one" in err
