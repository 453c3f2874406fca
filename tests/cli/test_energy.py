"""``isoembed energy``: closed forms, surfaces from files, what is written, what is refused."""

import json
import os
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import h5py
import numpy as np
import pytest

import isoembed
import zoo
from isoembed.cli import energy as command
from isoembed.cli import main
from isoembed.io import read_metric, write_metric
from isoembed.metric.curvature import area
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity import KerrNewmanSphere, StarSurface
from isoembed.smooth import GridMetric, solve, triangulate_metric
from isoembed.smooth.two_metric import angle_frame
from isoembed.surface.measures import volume

KERR = KerrNewmanSphere(3.0, 1.0, 0.8)
BROWN_YORK = 1.2196541460073282
NAMES = ("area", "integrated_mean_curvature", "irreducible_mass", "hawking", "brown_york", "liu_yau")


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Call the command in an empty folder; return its status, its output and its complaint."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        before = set(os.listdir())
        status = main(["energy", *map(str, arguments)])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        if status == 2:
            assert set(os.listdir()) == before
            assert out == "" and err.startswith("isoembed: error: ") and err.count("\n") == 1
        return status, out, err

    return call


@pytest.fixture
def report(run):
    """Call it with --json where it succeeds; return the object."""

    def call(*arguments):
        status, out, err = run(*arguments, "--json")
        assert (status, err) == (0, "")
        return strict(out)

    return call


def strict(text):
    def refuse(constant):
        pytest.fail(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


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
            kerr("r=3", 0.8),
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


def test_energies_are_in_units_of_the_mass(report):
    found = report(*kerr("r=3e4", 8e3, "--mass", 1e4))
    assert found["brown_york"] == pytest.approx(1e4 * BROWN_YORK, rel=1e-12)
    assert found["area"] == pytest.approx(1e8 * 120.12242026143980, rel=1e-12)


def test_a_charged_horizon_embeds_and_no_band_is_written(run):
    status, out, err = run(*kerr("horizon", 0.5, "--charge", 0.6, "--band", "band.npz"), "--json")
    assert status == 0 and err == "isoembed: error: band.npz is not written: the whole surface embeds\n"
    check(json.loads(out), christodoulou_mass=1.0)
    assert os.listdir() == []


def test_the_text_tells_the_same(run):
    status, out, err = run(*kerr("horizon", 0.5))
    assert (status, err) == (0, "")
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


def test_notes_are_in_the_text(run):
    status, out, _ = run(*kerr("ergosphere=.5", 0.975))
    assert status == 0
    assert "note: k = -" in out and "Liu-Yau energy  " not in out


def test_the_surface_is_written(run):
    status, out, err = run(*kerr("horizon", 0.5, "-o", "horizon.vtk"))
    assert (status, err) == (0, "") and out
    assert os.listdir() == ["horizon.vtk"]
    mesh = read_metric("horizon.vtk")
    assert mesh.triangulation.n_vertices == 60
    assert area(mesh) == pytest.approx(46.898333599528960, rel=0.1)


def test_the_file_has_the_curvatures(run):
    assert run(*kerr("r=3", 0.8, "-o", "surface.npz"))[0] == 0
    with np.load("surface.npz") as archive:
        tables = dict(archive)
    assert set(tables) >= {"vertices", "faces", "mean_curvature", "gaussian_curvature", "residual", "k"}
    assert volume(tables["faces"], tables["vertices"]) > 0.0
    assert np.all(2.0 * tables["mean_curvature"] > tables["k"])


# what does not embed


@pytest.fixture
def few(monkeypatch):
    """Fewer degrees: more do not help here."""
    monkeypatch.setattr(solve, "SOLVE", replace(solve.SOLVE, degrees=(8, 12, 16)))


def test_beyond_smarrs_limit(run):
    """With all degrees that there are."""
    status, out, err = run(*kerr("horizon", 0.9, "--json", "-o", "a.vtk"))
    assert status == 3 and os.listdir() == []
    assert err.startswith("isoembed: error: no surface of revolution has this metric for theta < 0.561403")
    assert "84.6509 % of the area" in err and err.count("\n") == 1
    found = strict(out)
    assert found["status"] == "not embedded" and found["message"] in err
    assert found["brown_york"] is found["liu_yau"] is found["integrated_mean_curvature"] is None
    r = 1.0 + np.sqrt(1.0 - 0.81)
    check(
        found, area=4.0 * np.pi * (r**2 + 0.81), christodoulou_mass=1.0, hawking=np.sqrt((r**2 + 0.81) / 4.0)
    )


def test_in_text_too(run, few):
    status, out, err = run(*kerr("horizon", 0.9))
    assert status == 3 and err.startswith("isoembed: error: no surface of revolution")
    assert "irreducible mass" in out and "Brown-York" not in out


def test_the_band_that_embeds_is_written(run, few):
    status, _, err = run(*kerr("horizon", 0.9, "--band", "band.npz", "-o", "whole.npz"))
    assert status == 3 and err
    assert os.listdir() == ["band.npz"]
    with np.load("band.npz") as archive:
        vertices, faces = archive["vertices"], archive["faces"]
    corners = vertices[faces]
    areas = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    )
    r = 1.0 + np.sqrt(1.0 - 0.81)
    assert areas.sum() == pytest.approx(0.846509 * 4.0 * np.pi * (r**2 + 0.81), rel=5e-3)
    a, b, c = np.sort(faces, axis=1).T
    _, counts = np.unique(np.concatenate([np.c_[a, b], np.c_[b, c], np.c_[a, c]]), axis=0, return_counts=True)
    assert set(counts) == {1, 2}  # it has a boundary


def test_the_best_fit(run, few):
    status, out, err = run(*kerr("horizon", 0.9, "--best-fit", "--json", "-o", "fit.vtk"))
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["status"] == "best fit" and os.listdir() == ["fit.vtk"]
    assert any("not an embedding, but the best fit" in note for note in found["notes"])
    assert found["errors"]["brown_york"] > 1e-8


# surfaces from files


@cache
def kerr_mesh():
    return triangulate_metric(KERR, 400)


@pytest.fixture
def triangles(tmp_path):
    """Kerr, r = 3, on triangles, and k there."""
    mesh = kerr_mesh()
    write_metric(tmp_path / "kerr.json", mesh.metric)
    np.save(tmp_path / "k.npy", KERR.mean_curvature(mesh.directions))
    np.save(tmp_path / "p.npy", np.zeros(400))


GRID = (32, 8)


@pytest.fixture
def grid(tmp_path):
    """Kerr, r = 3, on a grid, and k there."""
    metric = GridMetric.sampled(KERR, *GRID)
    names = ("theta", "phi", "q_tt", "q_tp", "q_pp")
    tables = {name: np.array(getattr(metric, name)) for name in names}
    np.savez(tmp_path / "grid.npz", **tables)
    with h5py.File(tmp_path / "grid.h5", "w") as file:
        group = file.create_group("horizon")
        for name, values in tables.items():
            group[name] = values
    u = np.stack([np.sin(metric.theta), np.zeros(GRID[0]), np.cos(metric.theta)], axis=1)
    np.save(tmp_path / "k.npy", np.repeat(KERR.mean_curvature(u)[:, None], GRID[1], axis=1))
    np.save(tmp_path / "p.npy", np.zeros(GRID))
    return metric


@pytest.mark.parametrize("more", [[], ["--momentum", "p.npy"]])
def test_triangles(report, triangles, more):
    found = report("kerr.json", "--mean-curvature", "k.npy", *more, "-o", "a.ply", "--lengths", "geodesic")
    assert found["status"] == "embedded" and found["lengths"] == "geodesic" and found["name"] == "kerr.json"
    assert found["embedding"]["vertices"] == 400 and os.path.exists("a.ply")
    for name, exact in (
        ("brown_york", BROWN_YORK),
        ("liu_yau", BROWN_YORK),
        ("integrated_mean_curvature", 38.873468325120506),
        ("area", 120.1224202614398),
    ):
        assert abs(found[name] - exact) <= found["errors"][name] <= 1e-2 * exact
        assert found[name] == pytest.approx(exact, rel=1e-3)


def test_lengths_of_an_unknown_kind_have_errors_for_both(report, triangles):
    arguments = ["kerr.json", "--mean-curvature", "k.npy"]
    unknown = report(*arguments)
    geodesic, chord = (report(*arguments, "--lengths", kind) for kind in ("geodesic", "chord"))
    assert unknown["lengths"] == "not known" and "wide enough for chords" in unknown["notes"][-1]
    for name in ("area", "integrated_mean_curvature", "brown_york", "liu_yau", "hawking"):
        assert unknown[name] == geodesic[name]
        both = geodesic["errors"][name] + abs(unknown[name] - chord[name])
        assert unknown["errors"][name] >= both * (1.0 - 1e-9)


def test_triangles_without_k(report, triangles):
    found = report("kerr.json")
    assert found["brown_york"] is None and found["irreducible_mass"] == pytest.approx(1.545884737, rel=1e-4)
    assert "k is not given" in found["notes"][0]


def test_meshes_have_chords(report, run):
    vertices, faces = zoo.icosphere(3)
    isoembed.io.write_metric("sphere.json", PolyhedralMetric.from_mesh(vertices, faces))
    with open("sphere.off", "w") as file:
        file.write(f"OFF\n{len(vertices)} {len(faces)} 0\n")
        file.writelines(" ".join(map(repr, map(float, v))) + "\n" for v in vertices)
        file.writelines("3 " + " ".join(map(str, f)) + "\n" for f in faces)
    chords = report("sphere.off")
    assert chords["lengths"] == "chord"
    assert chords["area"] == pytest.approx(4.0 * np.pi, abs=max(1e-12, chords["errors"]["area"]))
    other = report("sphere.json", "--lengths", "chord")
    assert other["area"] == pytest.approx(chords["area"], rel=1e-9)
    assert report("sphere.off", "--lengths", "geodesic")["area"] < chords["area"] * (1.0 - 1e-4)


def test_triangles_that_do_not_embed(run, monkeypatch):
    def attempt(metric, **_):
        raise isoembed.NotEmbedded(
            "the path ended", isoembed.Embedding(metric, vertices, method="aim", tolerance=1.0)
        )

    vertices, faces = zoo.icosphere(1)
    write_metric("sphere.json", PolyhedralMetric.from_mesh(vertices, faces))
    monkeypatch.setattr(isoembed, "embed", attempt)
    status, _, err = run("sphere.json", "-o", "a.npz")
    assert (status, err) == (3, "isoembed: error: the path ended\n") and not os.path.exists("a.npz")


@pytest.mark.parametrize("name", ["grid.npz", "grid.h5"])
def test_grids(report, grid, name):
    found = report(name, "--mean-curvature", "k.npy", "--momentum", "p.npy", "--vertices", 100)
    assert found["name"] == name
    exact = {"area": 120.1224202614398, "integrated_mean_curvature": 38.873468325120506}
    for key, value in {**exact, "brown_york": BROWN_YORK, "liu_yau": BROWN_YORK}.items():
        assert abs(found[key] - value) <= found["errors"][key] <= 1e-9 * value


def test_a_coarse_grid_is_as_uncertain_as_it_is(report, grid):
    coarse = GridMetric.sampled(KERR, 8, 4)
    np.savez("coarse.npz", **{n: getattr(coarse, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})
    found = report("coarse.npz", "--vertices", 100)
    for key, value in (("area", 120.1224202614398), ("integrated_mean_curvature", 38.873468325120506)):
        assert abs(found[key] - value) <= found["errors"][key]
        assert 1e-12 < found["errors"][key] / value < 1e-2
    assert found["brown_york"] is None  # k is not given


# refusals

HORIZON = ["--spacetime", "kerr", "--spin", ".5", "--surface", "horizon"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "which surface? Give a METRIC, or a --spacetime and a --surface"),
        (["--spacetime", "kerr"], "which --surface? There are horizon, r=R and ergosphere=EPSILON"),
        (["--spacetime", "minkowski"], "invalid choice: 'minkowski'"),
        (["--spacetime", "kerr", "--surface", "cube"], "--surface cube: there are horizon, r=R and"),
        (["--spacetime", "kerr", "--surface", "horizon=3"], "--surface horizon=3: there are"),
        (["--spacetime", "kerr", "--surface", "r=big"], "--surface r=big: 'big' is not a number"),
        (["--spacetime", "kerr", "--surface", "r"], "--surface r"),
        (["--spacetime", "kerr", "--surface", "r="], "--surface r="),
        (["--spacetime", "kerr", "--surface", "ergosphere"], "--surface ergosphere"),
        (["--spacetime", "kerr", "--surface", "r=nan"], "r must be finite, not nan"),
        (["--spacetime", "kerr", "--surface", "r=1.5"], "r must be at least r_+ = 2, not 1.5"),
        (["--spacetime", "kerr", "--surface", "ergosphere=-1"], "epsilon must be between"),
        (["--spacetime", "kerr", "--surface", "horizon", "--spin", "1.1"], "must be at most mass^2"),
        (["--spacetime", "kerr", "--surface", "horizon", "--spin", "fast"], "invalid float value: 'fast'"),
        (["--spacetime", "kerr", "--surface", "horizon", "--mass", "0"], "mass must be positive, not 0"),
        (["--spacetime", "kerr", "--surface", "horizon", "--mass", "-1"], "mass must be positive, not -1"),
        (
            ["--spacetime", "schwarzschild", "--surface", "r=6", "--spin", ".5"],
            "a Schwarzschild black hole has neither spin nor charge: take --spacetime kerr",
        ),
        ([*HORIZON, "--slice", "painleve-gullstrand"], "is that of a hole without spin, not 0.5"),
        ([*HORIZON, "--slice", "kerr-schild", "--charge", ".1"], "--charge needs the slice boyer-lindquist"),
        ([*HORIZON, "--slice", "kerr-schild", "--spin", "1.5"], "there is no horizon: the spin 1.5 exceeds"),
        (
            ["--spacetime", "kerr", "--surface", "ergosphere=.5", "--slice", "kerr-schild"],
            "--surface ergosphere needs the slice boyer-lindquist",
        ),
        (["--spacetime", "kerr", "--surface", "r=-3", "--slice", "kerr-schild"], "the radius"),
        (["--spacetime", "kerr", "--surface", "r=0", "--slice", "painleve-gullstrand"], "the radius"),
        ([*HORIZON, "--slice", "mine"], "invalid choice: 'mine'"),
        ([*HORIZON, "--vertices", "11"], "--vertices must be at least 12, not 11"),
        ([*HORIZON, "--vertices", "many"], "invalid int value: 'many'"),
        ([*HORIZON, "-o", "a.txt"], "a.txt has the ending '.txt'"),
        ([*HORIZON, "-o", "no/a.npz"], "there is no folder"),
        ([*HORIZON, "--band", "a.txt"], "a.txt has the ending '.txt'"),
        ([*HORIZON, "kerr.json"], "kerr.json does not go with a --spacetime"),
        ([*HORIZON, "--mean-curvature", "k.npy"], "--mean-curvature does not go with a --spacetime"),
        ([*HORIZON, "--momentum", "p.npy"], "--momentum does not go with a --spacetime"),
        ([*HORIZON, "--lengths", "chord"], "--lengths does not go with a --spacetime"),
        (["kerr.json", "--mass", "2"], "--mass needs a --spacetime"),
        (["kerr.json", "--spin", ".5"], "--spin needs a --spacetime"),
        (["kerr.json", "--charge", ".5"], "--charge needs a --spacetime"),
        (["kerr.json", "--surface", "horizon"], "--surface needs a --spacetime"),
        (["kerr.json", "--slice", "kerr-schild"], "--slice needs a --spacetime"),
        (["kerr.json", "--vertices", "100"], "--vertices is for smooth surfaces"),
        (["kerr.json", "--best-fit"], "--best-fit is for smooth surfaces"),
        (["kerr.json", "--band", "b.npz"], "--band is for smooth surfaces"),
        (["kerr.json", "--lengths", "secant"], "invalid choice: 'secant'"),
        (["kerr.json", "--momentum", "p.npy"], "the momentum is of use only with the mean curvature"),
        (["kerr.json", "--mean-curvature", "no.npy"], "there is no file no.npy"),
        (["kerr.json", "--mean-curvature", "kerr.json"], "kerr.json is not a .npy file"),
        (
            ["kerr.json", "--mean-curvature", "short.npy"],
            "the mean curvature has the shape (7,): there are 400",
        ),
        (
            ["kerr.json", "--mean-curvature", "k.npy", "--momentum", "short.npy"],
            "the momentum has the shape (7,): there are 400 vertices, so it must be (400,)",
        ),
        (["kerr.json", "--mean-curvature", "nan.npy"], "nan.npy: entry (3,) is nan"),
        (["kerr.json", "--mean-curvature", "words.npy"], "words.npy does not hold one array of numbers"),
        (["no.json"], "there is no file no.json"),
        (["k.npy"], "not one of .npz .json"),
        (["--json", "--mean-curvature", "k.npy"], "which surface?"),
    ],
)
def test_refusals(run, triangles, monkeypatch, arguments, sentence):
    monkeypatch.setattr(command, "embed_surface", lambda *_, **__: pytest.fail("it computed"))
    np.save("short.npy", np.ones(7))
    np.save("nan.npy", np.where(np.arange(400) == 3, np.nan, 1.0))
    np.save("words.npy", np.array(["a"]))
    status, _, err = run(*arguments)
    assert status == 2
    assert sentence in err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--lengths", "chord"], "--lengths is for a METRIC of triangles"),
        (["--mean-curvature", "short.npy"], "short.npy has the shape (32,)"),
        (["--mean-curvature", "k.npy", "--momentum", "short.npy"], "short.npy has the shape (32,)"),
        (["--momentum", "p.npy"], "the momentum is of use only with the mean curvature"),
    ],
)
def test_refusals_of_grids(run, grid, arguments, sentence):
    np.save("short.npy", np.ones(32))
    status, _, err = run("grid.npz", *arguments)
    assert status == 2
    assert sentence in err


def test_a_grid_that_is_no_metric(run, grid):
    with np.load("grid.npz") as archive:
        tables = dict(archive)
    tables["q_pp"][3, 2] = -1.0
    np.savez("bad.npz", **tables)
    status, _, err = run("bad.npz")
    assert status == 2 and "bad.npz: q_tt, q_tp, q_pp = " in err and "at node [3, 2]" in err
    del tables["q_tt"]
    np.savez("bad.npz", **tables)
    status, _, err = run("bad.npz")
    assert status == 2 and "q_tt missing from a metric on a grid" in err


def test_the_band_of_what_is_not_symmetric_is_refused(run, monkeypatch):
    """The same horizon about the x-axis, on a grid."""

    class Turned:
        def tensor(self, u):
            order = [2, 0, 1]
            q = isoembed.relativity.KerrNewmanHorizon(1.0, 0.9).tensor(u[:, order])
            back = np.argsort(order)
            return q[:, back][:, :, back]

    monkeypatch.setattr(solve, "SOLVE", replace(solve.SOLVE, degrees=(8,)))
    metric = GridMetric.sampled(Turned(), 24, 48)
    np.savez("x.npz", **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})
    status, _, err = run("x.npz", "--band", "band.npz", "--vertices", 60)
    assert status == 3 and not Path("band.npz").exists()
    assert "--band is for surfaces that are symmetric about the z-axis: " in err


def test_the_wang_yau_energy_is_the_least(report, tmp_path):
    """Of a round sphere of Schwarzschild's in a slice that falls: that of the slice at rest, tau = 0."""
    slice_ = ["--spacetime", "schwarzschild", "--surface", "r=4", "--slice", "painleve-gullstrand"]
    found = report(*slice_, "--wang-yau", "--vertices", 60, "-o", "a.npz")
    exact = 4.0 * (1.0 - np.sqrt(0.5))
    assert abs(found["wang_yau"] - exact) <= found["errors"]["wang_yau"] <= 1e-9
    assert found["minimum"]["least_second_derivative"] > 0.0 and found["minimum"]["admissible"] > 0.0
    written = np.load("a.npz")
    np.testing.assert_allclose(np.linalg.norm(written["vertices"], axis=1), 4.0, rtol=1e-9)
    np.testing.assert_allclose(written["tau"], 0.0, atol=1e-9)


def test_where_there_is_no_wang_yau_energy_the_reason_is_said(report):
    found = report(
        "--spacetime", "kerr", "--spin", 0.5, "--surface", "horizon", "--wang-yau", "--vertices", 60
    )
    assert found["wang_yau"] is None and found["errors"]["wang_yau"] is None
    assert "only tau = 0 has a Wang-Yau energy" in found["notes"][-1]
    assert found["liu_yau"] is not None


def test_the_wang_yau_energy_of_a_surface_on_a_grid(run, report):
    """Kerr's r = 3 in a slice with momentum: with K(., n) the energy is known, without it is not."""
    slice_ = isoembed.relativity.KerrSchild(1.0, (0.0, 0.0, 0.5))
    data = StarSurface.from_radius(slice_.spheroid(3.0)).data(slice_)
    metric = GridMetric.sampled(data.metric, 24, 8)
    theta, phi = np.meshgrid(metric.theta, metric.phi, indexing="ij")
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    u = np.stack([x, y, np.cos(theta)], axis=2).reshape(-1, 3)
    np.savez("grid.npz", **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})
    np.save("k.npy", data.mean_curvature(u).reshape(24, 8))
    np.save("p.npy", data.momentum(u).reshape(24, 8))
    e_theta, e_phi = angle_frame(u)
    j = data.normal_momentum(u)
    components = [(j * e_theta).sum(axis=1), (j * e_phi).sum(axis=1) * np.sin(theta).ravel()]
    np.save("j.npy", np.reshape(components, (2, 24, 8)))
    arguments = ["grid.npz", "--mean-curvature", "k.npy", "--momentum", "p.npy", "--wang-yau"]
    found = report(*arguments, "--normal-momentum", "j.npy")
    assert abs(found["wang_yau"] - 1.2474088054291813) <= found["errors"]["wang_yau"] <= 1e-6
    without = report(*arguments)
    assert without["wang_yau"] is None and "needs the normal_momentum K(., n)" in without["notes"][-1]
    status, _, err = run(*arguments, "--normal-momentum", "k.npy")
    assert status == 2 and "k.npy has the shape (24, 8), not (2, n, m)" in err
