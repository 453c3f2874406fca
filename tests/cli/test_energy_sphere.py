"""``isoembed energy --sphere``: coordinate spheres in slices, closed forms and files."""

from functools import partial

import numpy as np
import pytest

from isoembed.cli import energy as command
from isoembed.relativity import BrillLindquist, KerrSchild, StarSurface, embed_surface
from slice_files import write_slice

FEW = ["--vertices", 60]


@pytest.fixture
def run(call):
    """Call ``isoembed energy`` in an empty folder."""
    return partial(call, "energy")


def near(found, **exact):
    for name, value in exact.items():
        assert abs(found[name] - value) <= found["errors"][name] <= 1e-10 * max(1.0, abs(value))


@pytest.mark.parametrize(
    ("slice_", "sphere"),
    [
        (["isotropic"], (0, 0, 0, 2)),
        (["--geometry", "isotropic", "--center", 1, -2, "-5e-3"], (1, -2, "-.5E-2", 2)),
        (["brill-lindquist", "--masses", 1, "--positions", 3, 0, 0], (3, 0, 0, 2)),
        (["boosted", "--velocity", 0, 0, 0, "--center", 0, 0, 1], (0, 0, 1, 2)),
        (
            ["superposed", "--masses", 1, "--positions", 0, 0, 0, "--velocities", 0, 0, 0],
            (0, 0, 0, 2),
        ),
    ],
    ids=lambda value: str(value[:2]),
)
def test_a_sphere_around_one_hole_at_rest(report, slice_, sphere):
    """The isotropic radius 2 M is the areal radius 2 M (5/4)^2 = 3.125 M."""
    found = report(*slice_, "--sphere", *sphere, *FEW)
    R = 3.125
    energy = R * (1.0 - np.sqrt(1.0 - 2.0 / R))
    near(found, area=4.0 * np.pi * R**2, hawking=1.0, brown_york=energy, liu_yau=energy)
    assert found["name"].startswith("sphere of radius 2 about (")
    assert not found["notes"]


@pytest.mark.parametrize("scale", [1e-5, pytest.param(1e6, marks=pytest.mark.slow)])
def test_units_and_the_wang_yau_energy(report, scale):
    """Of a sphere in a slice that falls: that of the slice at rest, in any unit."""
    arguments = ["painleve-gullstrand", "--mass", scale, "--sphere", 0, 0, 0, 4 * scale, "--wang-yau"]
    found = report(*arguments, *FEW)
    exact = 4.0 * (1.0 - np.sqrt(0.5)) * scale
    assert abs(found["wang_yau"] - exact) <= found["errors"]["wang_yau"] <= 1e-9 * scale


@pytest.mark.slow
def test_the_spin_is_a_vector_or_along_z(report):
    """What is printed is what Python computes, and turning the hole changes nothing."""
    upright = report("kerr-schild", "--spin", 0.5, "--sphere", 0, 0, 0, 3, *FEW)
    data = StarSurface.sphere((0.0, 0.0, 0.0), 3.0).data(KerrSchild(1.0, (0.0, 0.0, 0.5)))
    same = embed_surface(data, vertices=60).report
    assert upright["brown_york"] == same["brown_york"] and upright["spin"]["J"] == same["spin"]["J"]
    tilted = report("kerr-schild", "--spin", 0.3, -0.4, 0, "--sphere", 0, 0, 0, 3, *FEW)
    near(tilted, area=upright["area"], brown_york=upright["brown_york"])
    np.testing.assert_allclose(tilted["spin"]["vector"], [0.3, -0.4, 0.0], atol=1e-9)


@pytest.mark.slow
def test_a_sphere_in_a_file(report):
    slice_ = BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.25), (0.0, 0.0, -0.25)))
    write_slice("slice.npz", slice_, half=3.0, points=40)
    found = report("slice.npz", "--sphere", 0, 0, 0, 2, *FEW)
    exact = embed_surface(StarSurface.sphere((0.0, 0.0, 0.0), 2.0).data(slice_), vertices=60).energies
    for name in ("area", "brown_york", "hawking"):
        assert abs(found[name] - getattr(exact, name).value) <= found["errors"][name] <= 1e-4 * found[name]
    assert found["notes"] == ["the slice has no K_ij: it is assumed to be time-symmetric"]
    same = report("--geometry", "slice.npz", "--sphere", 0, 0, 0, 2, *FEW)
    assert same == found


@pytest.mark.slow
def test_what_is_a_horizon_is_said_by_options(report):
    arguments = ["isotropic", "--sphere", 0, 0, 0, 0.5, *FEW]
    undecided = report(*arguments)
    assert undecided["notes"][0].startswith("this may be a horizon")
    assert undecided["christodoulou_mass"] is None
    near(report(*arguments, "--marginal"), liu_yau=2.0, christodoulou_mass=1.0)
    refused = report(*arguments, "--not-marginal")
    assert refused["christodoulou_mass"] is None
    assert not any("may be a horizon" in note for note in refused["notes"])


BRILL = ["--geometry", "brill-lindquist"]
SPHERE = ["--sphere", 0, 0, 0, 2]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (SPHERE, "a --sphere lies in one slice: give a --geometry, or a file"),
        ([*BRILL, *SPHERE, "slice.npz"], "a --sphere lies in one slice"),
        (["--geometry", "isotropic"], "--geometry needs a --sphere, the surface in the slice"),
        (["grid.npz", "--masses", 1], "--masses needs a --sphere, the surface in the slice"),
        (["flat", *SPHERE], "the geometry flat: there are brill-lindquist, kerr-schild, "),
        (["slice.npz", *SPHERE], "there is no file slice.npz"),
        (["slice.npz", *SPHERE, "--mass", 2], "--mass does not go with the geometry slice.npz, a file"),
        (["body.ply", *SPHERE], "body.ply"),
        ([*BRILL, *SPHERE], "the geometry brill-lindquist needs --masses"),
        ([*BRILL, *SPHERE, "--masses", 1], "the geometry brill-lindquist needs --positions"),
        (
            [*BRILL, *SPHERE, "--masses", 1, 1, "--positions", 0, 0, 0],
            "2 masses at 1 positions: there must be one for each",
        ),
        (
            [*BRILL, *SPHERE, "--masses", 1, 1, "--positions", 0, 0, 0, 1],
            "--positions takes three numbers for each hole, not 4 in all",
        ),
        (
            [*BRILL, *SPHERE, "--masses", 1, 0, "--positions", 0, 0, 1, 0, 0, 0],
            "mass 1 must be positive, not 0",
        ),
        (
            [*BRILL, *SPHERE, "--masses", 1, "--positions", 0, "nan", 1],
            "position 0 must be three finite numbers",
        ),
        (
            [*BRILL, *SPHERE, "--mass", 1],
            "--mass does not go with the geometry brill-lindquist, which takes --masses and --positions",
        ),
        (["isotropic", *SPHERE, "--spin", 0.5], "--spin does not go with the geometry isotropic"),
        (["kerr-schild", *SPHERE, "--spin", 0.5, 0.5], "--spin takes one number, along z, or three, not 2"),
        (["kerr-schild", *SPHERE, "--spin", 1.5], "there is no horizon: the spin 1.5 exceeds the mass 1"),
        (["boosted", *SPHERE], "the geometry boosted needs --velocity"),
        (["boosted", *SPHERE, "--velocity", 0, 1, 0], "the speed must be less than that of light, 1, not 1"),
        (
            ["superposed", *SPHERE, "--masses", 1, "--positions", 0, 0, 1, "--velocities", 0, 2, 0],
            "hole 0: the speed must be less than that of light",
        ),
        (
            ["superposed", *SPHERE, "--masses", 1, 1, "--positions", 0, 0, 1, "--velocities", 0, 0.1, 0],
            "2 masses at 1 positions with 1 velocities: there must be one of each for every hole",
        ),
        (["--masses", 1, 1, "slice.npz", *SPHERE], "'slice.npz' is not a number (files come before"),
        (["isotropic", "--sphere", 0, 0, 0, -1], "the radius must be positive, not -1"),
        (["isotropic", "--sphere", 0, 0, 0, 0], "the radius must be positive, not 0"),
        (["isotropic", "--sphere", 0, 0, 0], "--sphere: expected 4 arguments"),
        (["isotropic", "--sphere", "nan", 0, 0, 1], "the center must be three finite numbers"),
        (
            [*BRILL, "--masses", 1, 1, "--positions", 0, 0, 5, 1.2, 0, 1.6, *SPHERE],
            "the surface passes through the black hole at (1.2, 0, 1.6)",
        ),
        (["boyer-lindquist", *SPHERE], "does not lie outside the horizon r = 2"),
        (["isotropic", *SPHERE, "--spacetime", "kerr"], "--spacetime does not go with a --sphere"),
        (["isotropic", *SPHERE, "--charge", 0.5], "--charge does not go with a --sphere"),
        (["isotropic", *SPHERE, "--lengths", "chord"], "--lengths does not go with a --sphere"),
        (
            ["--spacetime", "kerr", "--surface", "horizon", "--geometry", "isotropic"],
            "--geometry does not go with a --spacetime",
        ),
        (
            ["--spacetime", "kerr", "--surface", "horizon", "--not-marginal"],
            "--not-marginal does not go with a --spacetime",
        ),
        (
            ["--spacetime", "kerr", "--surface", "horizon", "--spin", 0.1, 0.2, 0.3],
            "--spin takes one number with a --spacetime, whose holes spin about z",
        ),
    ],
)
def test_refusals(run, monkeypatch, arguments, sentence):
    monkeypatch.setattr(command, "embed_surface", lambda *_, **__: pytest.fail("it computed"))
    status, _, err = run(*arguments)
    assert status == 2
    assert sentence in err


def test_a_sphere_that_leaves_the_grid_is_refused(run):
    write_slice("slice.npz", KerrSchild(1.0, (0.0, 0.0, 0.5)), half=3.0, points=10)
    status, _, err = run("slice.npz", "--sphere", 0, 0, 2, 2)
    assert status == 2
    assert "lies outside the grid, which reaches from (-3, -3, -3) to (3, 3, 3)" in err
