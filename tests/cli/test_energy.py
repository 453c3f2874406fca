"""``isoembed energy`` of closed forms: energies, what is written, what does not embed."""

import json
import os
import re
from functools import partial

import numpy as np
import pytest

from isoembed.io import read_metric
from isoembed.metric.curvature import area
from isoembed.relativity import KerrNewmanSphere, energy_table
from isoembed.surface.measures import volume

KERR = KerrNewmanSphere(3.0, 1.0, 0.8)
BROWN_YORK = 1.2196541460073282
NAMES = ("area", "integrated_mean_curvature", "irreducible_mass", "hawking", "brown_york", "liu_yau")


@pytest.fixture
def run(call):
    """Call ``isoembed energy`` in an empty folder."""
    return partial(call, "energy")


def kerr(surface, spin, *more):
    return ["--spacetime", "kerr", "--spin", spin, "--surface", surface, "--vertices", 60, *more]


def check(found, **exact):
    """Every number is within its error, and its error is small."""
    for name, value in exact.items():
        if value is None:
            assert found[name] is None
        else:
            assert abs(found[name] - value) <= found["errors"][name] <= 1e-10 * max(1.0, value)


# closed forms


@pytest.mark.parametrize(
    ("arguments", "exact"),
    [
        (
            kerr("horizon", 0.5),
            {
                "area": 46.898333599528960,
                "integrated_mean_curvature": 24.300446945608874,
                "irreducible_mass": 0.9659258262890682,
                "christodoulou_mass": 1.0,
                "hawking": 0.9659258262890682,
                "brown_york": 1.9337681253680011,
                "liu_yau": 1.9337681253680011,
            },
        ),
        (
            kerr("r=3", 0.8, "-o", "surface.npz"),
            {
                "area": 120.12242026143980,
                "integrated_mean_curvature": 38.873468325120506,
                "brown_york": BROWN_YORK,
                "liu_yau": BROWN_YORK,
            },
        ),
        (
            kerr("ergosphere=.5", 0.975),
            {"area": 84.498458825124000, "integrated_mean_curvature": 33.021720529589184, "liu_yau": None},
        ),
        (
            [
                "--spacetime",
                "schwarzschild",
                "--surface",
                "r=6",
                "--slice",
                "painleve-gullstrand",
                "--vertices",
                60,
            ],
            {"brown_york": 0.0, "liu_yau": 1.10102051443364, "hawking": 1.0, "irreducible_mass": 3.0},
        ),
        (
            ["--spacetime", "schwarzschild", "--surface", "r=6", "--vertices", 60],
            {"brown_york": 1.1010205144336438, "liu_yau": 1.1010205144336438, "hawking": 1.0},
        ),
        (kerr("r=3", 0.8, "--slice", "kerr-schild"), {"area": 120.12242026143980, "liu_yau": BROWN_YORK}),
        (
            [
                "--spacetime",
                "schwarzschild",
                "--surface",
                "horizon",
                "--slice",
                "painleve-gullstrand",
                "--vertices",
                60,
            ],
            {"hawking": 1.0, "liu_yau": 2.0, "area": 16.0 * np.pi, "brown_york": 0.0},
        ),
    ],
    ids=lambda value: " ".join(map(str, value)) if isinstance(value, list) else "",
)
def test_closed_forms(report, arguments, exact):
    found = report(*arguments)
    assert {*NAMES, "error_estimate", "errors", "notes", "status", "conventions"} <= set(found)
    assert found["status"] == "embedded" and found["error_estimate"] < 1e-10
    check(found, **exact)
    text = energy_table(found)
    assert all(f"note: {note}\n" in text for note in found["notes"])
    assert ("Liu-Yau energy  " in text) == (found["liu_yau"] is not None)
    if "ergosphere=.5" in arguments:
        assert found["notes"][0].startswith("k = -")
    if "surface.npz" in arguments:
        with np.load("surface.npz") as archive:
            tables = dict(archive)
        assert set(tables) >= {"vertices", "faces", "mean_curvature", "gaussian_curvature", "residual", "k"}
        assert volume(tables["faces"], tables["vertices"]) > 0.0
        assert np.all(2.0 * tables["mean_curvature"] > tables["k"])


def test_energies_are_in_units_of_the_mass(report):
    found = report(*kerr("r=3e4", 8e3, "--mass", 1e4))
    assert found["brown_york"] == pytest.approx(1e4 * BROWN_YORK, rel=1e-12)
    assert found["area"] == pytest.approx(1e8 * 120.12242026143980, rel=1e-12)


def test_a_charged_horizon_embeds_and_no_band_is_written(run):
    status, out, err = run(*kerr("horizon", 0.5, "--charge", 0.6, "--band", "band.npz"), "--json")
    assert status == 0 and err == "isoembed: error: band.npz is not written: the whole surface embeds\n"
    check(json.loads(out), christodoulou_mass=1.0)
    assert os.listdir() == []


def test_the_text_tells_the_same_and_the_surface_is_written(run):
    status, out, err = run(*kerr("horizon", 0.5, "-o", "horizon.vtk"))
    assert (status, err) == (0, "")
    assert os.listdir() == ["horizon.vtk"]
    mesh = read_metric("horizon.vtk")
    assert mesh.triangulation.n_vertices == 60
    assert area(mesh) == pytest.approx(46.898333599528960, rel=0.1)
    assert out.startswith("Kerr-Newman horizon of mass 1, spin 0.5, charge 0\n")
    for words, exact in (
        ("area", 46.898333599528960),
        (r"int H dA, H = \(k1 \+ k2\)/2", 24.300446945608874),
        ("irreducible mass", 0.9659258262890682),
        ("Christodoulou mass", 1.0),
        ("Hawking energy", 0.9659258262890682),
        ("Brown-York energy", 1.9337681253680011),
        ("Kijowski-Liu-Yau energy", 1.9337681253680011),
    ):
        line = re.search(rf"^{words} +(\S+) +\+- (\S+)$", out, re.MULTILINE)
        assert abs(float(line[1]) - exact) <= 2.0 * float(line[2]) + 1e-14 * exact <= 1e-9
    assert "geometric, G = c = 1" in out
