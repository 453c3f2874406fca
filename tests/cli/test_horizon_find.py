"""``isoembed horizon --find``: horizons of closed forms and of files, found, embedded and reported."""

import os
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from horizons import check
from isoembed.cli import horizon as command
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import AnalyticCallable, KerrSchild
from patch_data import Grid, Tree, write_amrex, write_athenak, write_chombo, z4c
from slice_files import write_slice
from strict_json import strict

FEW = ["--vertices", 60]
KEYS = {"area", "integrated_mean_curvature", "irreducible_mass", "hawking", "liu_yau", "spin", "embedding"}


@pytest.fixture
def run(call):
    """Call ``isoembed horizon --find`` in an empty folder."""
    return partial(call, "horizon", "--find", "--geometry")


@pytest.fixture
def found(run):
    """Call it where it succeeds; return the object."""

    def found(*arguments):
        status, out, err = run(*arguments, *FEW, "--json")
        assert (status, err) == (0, "")
        report = strict(out)
        assert report["status"] == "embedded" and set(report) >= KEYS
        assert report["horizon"]["marginal"] and report["horizon"]["residual"] < 1e-3
        return report

    return found


def two_holes(masses, d, tilt=0.0, center=(0.0, 0.0, 0.0)):
    """Two holes at the distance d, on an axis that is tilted in the plane of x and z."""
    half = 0.5 * d * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    positions = [*(np.array(center) + half), *(np.array(center) - half)]
    return ["brill-lindquist", "--masses", *masses, "--positions", *positions]


@pytest.mark.parametrize(
    ("arguments", "mass", "liu_yau"),
    [
        (two_holes((0.5, 0.5), 0.5), 0.998248418, 2.01920982),
        pytest.param(two_holes((0.2, 0.8), 0.5), 0.999007214, 2.01382715, marks=pytest.mark.slow),
        ([*two_holes((0.5, 0.5), 1.0), "--guess", 0, 0, 0.5, 0.3], 0.624999260, 1.25000897),
        pytest.param(
            two_holes((0.5, 0.5), 0.5, 0.7, (0.3, -0.2, 0.1)), 0.998248418, 2.01920982, marks=pytest.mark.slow
        ),
        pytest.param(two_holes((0.5, 0.5), 0.6), 0.996294662, 2.04072244, marks=pytest.mark.slow),
    ],
    ids=("equal", "unequal", "individual", "tilted", "wider"),
)
def test_two_holes(found, arguments, mass, liu_yau):
    """The masses and energies by shooting, in nine digits."""
    report = found(*arguments)
    for name, exact in (("irreducible_mass", mass), ("hawking", mass), ("liu_yau", liu_yau)):
        assert abs(report[name] - exact) <= 1e-8
        assert report["errors"][name] <= 1e-9
    assert report["horizon"]["outer"] and 0.0 < report["horizon"]["stability"] < 1.0
    assert report["horizon"]["residual"] < 1e-12 and report["horizon"]["degree"] >= 16
    near = " near (0, 0, 0.5; 0.3)" if "--guess" in arguments else ""
    assert report["name"].startswith(f"horizon{near} in brill-lindquist, masses 0.")


@pytest.mark.parametrize("scale", [1e-3, pytest.param(1e6, marks=pytest.mark.slow)])
def test_one_hole_in_any_unit(found, scale):
    at = (1.0 * scale, -2.0 * scale, 3.0 * scale)
    report = found("isotropic", "--mass", scale, "--center", *at)
    np.testing.assert_allclose(report["horizon"]["center"], at, rtol=1e-12)
    assert abs(report["liu_yau"] - 2.0 * scale) <= report["errors"]["liu_yau"] <= 1e-11 * scale
    assert report["horizon"]["mean_coordinate_radius"] == pytest.approx(0.5 * scale, rel=1e-12)
    assert report["horizon"]["stability"] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.slow
def test_a_tilted_kerr_hole_and_one_in_motion(found):
    report = found("kerr-schild", "--spin", 0.0, 0.36, -0.48, "--center", 1, 2, 3, "--axis", 0, 0, 1)
    check(report, 0.6, 1e-10)
    np.testing.assert_allclose(report["spin"]["vector"], [0.0, 0.36, -0.48], atol=1e-9)
    assert report["spin"]["given_axis"]["J"] == pytest.approx(-0.48, abs=1e-9)
    report = found("boosted", "--velocity", 0.1, 0.2, 0.3)
    assert abs(report["liu_yau"] - 2.0) <= report["errors"]["liu_yau"] <= 1e-10


@pytest.mark.slow
def test_a_horizon_in_a_file(found):
    """Kerr, a = 0.5, on a grid of spacing 1/4: what is stated holds what is missed."""
    write_slice("slice.npz", KerrSchild(1.0, (0.0, 0.0, 0.5)), half=3.125, points=26)
    check(found("slice.npz", "--guess", 0, 0, 0, 2), 0.5, 1e-2)


def write_kerr(layout):
    """Kerr, a = 0.5, on two levels in a file of another code, and its center."""
    kerr, path, at = KerrSchild(1.0, (0.0, 0.3, 0.4)), Path(layout), 0.0
    boxes = ((((0, 0, 0), (24, 24, 24)),), (((12, 12, 12), (24, 24, 24)),))
    if path.suffix == ".bin":
        tree = Tree((-8.0,) * 3, 0.5, (4,) * 3, 8, lambda level, a, b: level < 1 and np.abs(a + b).max() < 5)
        write_athenak(path, kerr, tree, z4c(-4.0))
    elif path.suffix == ".hdf5":
        pytest.importorskip("h5py")
        at = 6.0
        write_chombo(path, kerr, Grid((0.0,) * 3, 0.5, boxes, (at,) * 3))
    else:
        write_amrex(path, kerr, Grid((-6.0,) * 3, 0.5, boxes))
    return kerr, at


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["plt00010", "checkpoint_000010.3d.hdf5", "run.z4c.00010.bin"])
def test_a_horizon_is_found_in_files_of_other_codes(found, layout):
    _, at = write_kerr(layout)
    report = found(layout, "--guess", at, at, at, 2.1)
    check(report, 0.5, 1e-2)
    assert report["name"] == f"horizon near ({at:.9g}, {at:.9g}, {at:.9g}; 2.1) in {layout}"


@pytest.mark.parametrize(
    "layout",
    [
        "plt00010",
        pytest.param("checkpoint_000010.3d.hdf5", marks=pytest.mark.slow),
        pytest.param("run.z4c.00010.bin", marks=pytest.mark.slow),
    ],
)
def test_a_horizon_embeds_in_files_of_other_codes(call, layout):
    """From its coordinates in a file."""
    kerr, at = write_kerr(layout)
    u = fibonacci_directions(600)
    np.savez("shape.npz", points=at + u * kerr.spheroid(kerr.horizon)(u)[:, None])
    status, out, err = call("horizon", "shape.npz", "--geometry", layout, *FEW, "--json")
    assert (status, err) == (0, "")
    check(strict(out), 0.5, 1e-2)


def test_what_is_written_and_said(run):
    status, out, err = run("isotropic", "--guess", 0, 0, 0, 0.6, *FEW, "--wang-yau", "-o", "deep/found")
    assert (status, err) == (0, "")
    stem = "isotropic-horizon_0_0_0_0.6"
    assert sorted(os.listdir("deep/found")) == [f"{stem}.{ending}" for ending in ("json", "png", "vtk")]
    report = strict(Path(f"deep/found/{stem}.json").read_text())
    assert abs(report["hawking"] - 1.0) <= report["errors"]["hawking"] and report["horizon"]["outer"]
    assert out.startswith("horizon near (0, 0, 0; 0.6) in isotropic\n")
    assert "the least eigenvalue of the stability operator is 1 / R^2, R the areal radius: stable" in out
    assert "the expansion of outgoing rays, 0 on a horizon, is at most" in out


def test_where_there_is_no_horizon_the_reason_is_said(run):
    flat = AnalyticCallable(lambda x: np.tile(np.eye(3), (len(x), 1, 1)))
    write_slice("flat.npz", flat, half=2.0, points=8)
    status, out, err = run("flat.npz", "--json")
    assert status == 3
    report = strict(out)
    assert report["status"] == "not found" and report["name"] == "horizon in flat.npz"
    assert report["least_expansion"] == pytest.approx(1.0, abs=1e-6)  # c R / 2 of spheres
    assert report["evidence"] == "searched"
    assert err == f"isoembed: error: {report['message']}\n" and "no horizon was found" in err
    status, out, err = run("isotropic", "--guess", 0, 0, 3, 1)
    assert (status, out) == (3, "") and err.startswith("isoembed: error: no horizon was found from the guess")


@pytest.mark.slow
def test_a_horizon_that_does_not_embed_is_reported(run):
    status, out, err = run("kerr-schild", "--spin", 0, 0, 0.9, *FEW, "--json")
    assert status == 3 and "no surface of revolution has this metric" in err
    assert err.endswith("\nisoembed: try: --space hyperbolic, which embeds the whole surface\n")
    report = strict(out)
    assert report["status"] == "not embedded" and report["horizon"]["outer"]
    assert report["irreducible_mass"] == pytest.approx(np.sqrt(0.5 * (1.0 + np.sqrt(0.19))), rel=1e-9)
    status, out, _ = run("kerr-schild", "--spin", 0, 0, 0.9, *FEW)
    assert status == 3 and "irreducible mass            0.8473163206" in out and "J_3 -0.515" in out


GUESS = ["--guess", 0, 0, 0, 0.5]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["isotropic", "h.gp"], "--find takes no FILE, and h.gp is given"),
        (["isotropic", *GUESS[:-1], 0], "the radius must be positive, not 0"),
        (["isotropic", *GUESS[:-1], -1], "the radius must be positive, not -1"),
        (["isotropic", *GUESS[:-1], "nan"], "the radius must be positive, not nan"),
        (["isotropic", *GUESS[:-1]], "--guess: expected 4 arguments"),
        (["isotropic", "--guess", "inf", 0, 0, 1], "the center must be three finite numbers"),
        (["isotropic", "--time", 1], "--time is for files, not for --find"),
        (["isotropic", "--surface", "AhA"], "--surface is for files, not for --find"),
        (["isotropic", "--stability", 0], "the number of eigenvalues must be at least 1, not 0"),
        (["isotropic", "--marginal"], "--marginal is for files, not for --find"),
        (["isotropic", "--not-marginal"], "--not-marginal is for files, not for --find"),
        (["isotropic", "--mass", 0], "the mass must be positive, not 0"),
        (["flat"], "the geometry flat: there are brill-lindquist, kerr-schild, "),
        (["no.h5"], "there is no file no.h5"),
        (["slice.npz", "--guess", 0, 0, 2, 2], "lies outside the grid, which reaches from (-3, -3, -3)"),
        (["slice.npz", "--masses", 1, 1], "--masses does not go with the geometry slice.npz, a file"),
        (["brill-lindquist", "--masses", 1, 1], "the geometry brill-lindquist needs --positions"),
        (
            ["brill-lindquist", "--masses", 1, "--positions", 0, 0, 1, 0, 0, 0],
            "1 masses at 2 positions: there must be one for each",
        ),
        (
            ["brill-lindquist", "--masses", 1, -1, "--positions", 0, 0, 1, 0, 0, 0],
            "mass 1 must be positive, not -1",
        ),
        (["kerr-schild", "--spin", 0, 1.2, 0], "there is no horizon: the spin 1.2 exceeds the mass 1"),
        (["kerr-schild", "--spin", 1.2], "there is no horizon: the spin 1.2 exceeds the mass 1"),
        (["boyer-lindquist"], "singular on the horizon: take --geometry kerr-schild, or 'isoembed energy"),
        (["isotropic", "--axis", 0, 0, 0], "--axis 0 0 0 is not an axis"),
        (["isotropic", "--vertices", 11], "--vertices must be at least 12, not 11"),
    ],
)
def test_refusals(run, monkeypatch, arguments, sentence):
    monkeypatch.setattr(command, "run_tasks", lambda *_, **__: pytest.fail("it computed"))
    write_slice("slice.npz", KerrSchild(1.0, (0.0, 0.0, 0.5)), half=3.0, points=10)
    status, _, err = run(*arguments)
    assert status == 2
    assert sentence in err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "no horizon: give a FILE, or --find and a --geometry"),
        (["--find"], "--find needs a --geometry to find a horizon in"),
        (["h.gp", *GUESS], "--guess needs --find"),
    ],
)
def test_files_and_finding_exclude_each_other(call, arguments, sentence):
    status, _, err = call("horizon", *arguments)
    assert status == 2 and sentence in err


def test_the_stability_spectrum(run):
    status, out, _ = run("isotropic", *FEW, "--stability", 4, "--json")
    spectrum = strict(out)["horizon"]["stability_spectrum"]
    assert status == 0
    assert spectrum["real"] == pytest.approx([1.0, 3.0, 3.0, 3.0], abs=1e-9)
    assert spectrum["imaginary"] == [0.0] * 4
    assert spectrum["orders"] == [0, 0, 1, -1]
    status, out, _ = run("isotropic", *FEW, "--stability", 1)
    head = "eigenvalues of the stability operator times R^2, R = 2:"
    first = re.search(rf"\n{re.escape(head)}\n  (\S+) \+- ([^,\s]+)", out)
    assert status == 0 and abs(float(first[1]) - 1) <= float(first[2]) < 1e-9


def test_a_stability_spectrum_of_files_is_refused(call):
    status, _, err = call("horizon", "h.gp", "--stability", 4)
    assert status == 2 and "--stability needs --find" in err


@pytest.mark.slow
def test_multipoles_without_symmetry(run):
    status, out, _ = run("kerr-schild", "--spin", 0.36, 0, 0.48, *FEW, "--multipoles", 2, "--json")
    found = strict(out)["conformal_multipoles"]
    assert status == 0 and [len(row) for row in found["I"]] == [1, 2, 3]
    assert found["I_power"][2] == pytest.approx(0.2454326928822, abs=1e-10)
    assert found["L_power"][1] == pytest.approx(0.956624084, abs=1e-8)
    status, out, _ = run("isotropic", *FEW, "--multipoles", 1)
    assert status == 0 and "\nsum over m of |I_lm|^2 for l = 1: " in out
    status, _, err = run("isotropic", "--multipoles", 0)
    assert status == 2 and "the highest degree of multipoles must be at least 1, not 0" in err
