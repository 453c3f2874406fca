"""``isoembed energy`` of surfaces from files, and what is refused."""

import os
from functools import cache, partial
from pathlib import Path

import h5py
import numpy as np
import pytest

import isoembed
import zoo
from isoembed import plot
from isoembed.cli import energy as command
from isoembed.io import write_metric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity import KerrNewmanSphere
from isoembed.smooth import GridMetric, solve, triangulate_metric
from strict_json import strict

KERR = KerrNewmanSphere(3.0, 1.0, 0.8)
BROWN_YORK = 1.2196541460073282
NAMES = ("area", "integrated_mean_curvature", "irreducible_mass", "hawking", "brown_york", "liu_yau")


@pytest.fixture
def run(call):
    """Call ``isoembed energy`` in an empty folder."""
    return partial(call, "energy")


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


@pytest.mark.slow
@pytest.mark.parametrize("space", [[], ["--space", "hyperbolic"]], ids=["flat", "hyperbolic"])
def test_pictures_show_the_curvature_of_the_smooth_surface(run, space, monkeypatch):
    drawn = []
    monkeypatch.setattr(plot, "picture_writer", lambda *_, **given: drawn.append(given) or no_bytes)
    status, out, _ = run(*HORIZON, *space, "--vertices", 60, "--picture", "a.png", "--html", "a.html")
    assert status == 0 and "a.png, a.html written" in out
    color, caption = drawn[0]["color"], drawn[0]["caption"]
    assert caption.startswith("area 46.898334 ") and "= 24.300447$" in caption
    assert "as in the file" in color.label and "as in the file" in Path("a.html").read_text()
    assert np.ptp(color.values) > 0.05
    assert 0.4 < color.values.min() < color.values.max() < 0.6


def test_a_picture_of_a_surface_of_triangles(run, triangles):
    status, out, _ = run("kerr.json", "--picture", "a.svg")
    assert status == 0 and "a.svg written" in out and Path("a.svg").exists()


def no_bytes(path):
    path.touch()


GRID = (32, 1)


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
    assert unknown["lengths"] == "not known" and "allow for chords" in unknown["notes"][-1]
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
    unwritten = "isoembed: error: a.npz not written: there is no surface\n"
    assert (status, err) == (3, f"isoembed: error: the path ended\n{unwritten}")
    assert not os.path.exists("a.npz")


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
        (["--spacetime", "kerr", "--surface", "cube"], "--surface cube is not one of horizon, r=R and"),
        (["--spacetime", "kerr", "--surface", "horizon=3"], "--surface horizon=3 is not one of"),
        (["--spacetime", "kerr", "--surface", "r=big"], "--surface r=big: 'big' is not a number"),
        (["--spacetime", "kerr", "--surface", "r"], "--surface r"),
        (["--spacetime", "kerr", "--surface", "r="], "--surface r="),
        (["--spacetime", "kerr", "--surface", "ergosphere"], "give a number, for instance ergosphere=0.1"),
        (["--spacetime", "kerr-newman"], "kerr-newman is kerr with a --charge"),
        (["--spacetime", "kerr", "--surface", "r=nan"], "r must be finite, not nan"),
        (["--spacetime", "kerr", "--surface", "r=1.5"], "r must be at least r_+ = 2, not 1.5"),
        (["--spacetime", "kerr", "--surface", "ergosphere=-1"], "epsilon must be between"),
        (["--spacetime", "kerr", "--surface", "horizon", "--spin", "1.1"], "must be at most mass^2"),
        (["--spacetime", "kerr", "--surface", "horizon", "--spin", "fast"], "'fast' is not a number"),
        (["--spacetime", "kerr", "--surface", "horizon", "--mass", "0"], "mass must be positive, not 0"),
        (["--spacetime", "kerr", "--surface", "horizon", "--mass", "-1"], "mass must be positive, not -1"),
        (
            ["--spacetime", "schwarzschild", "--surface", "r=6", "--spin", ".5"],
            "a Schwarzschild black hole has neither spin nor charge: take --spacetime kerr",
        ),
        ([*HORIZON, "--slice", "painleve-gullstrand"], "requires zero spin, not 0.5"),
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
        ([*HORIZON, "--vertices", "many"], "'many' is not a whole number"),
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
        (["kerr.json", "--momentum", "p.npy"], "the momentum requires the mean curvature"),
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
        (["--momentum", "p.npy"], "the momentum requires the mean curvature"),
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
    tables["q_pp"][3, 0] = -1.0
    np.savez("bad.npz", **tables)
    status, _, err = run("bad.npz")
    assert status == 2 and "bad.npz: q_tt, q_tp, q_pp = " in err and "at node [3, 0]" in err
    del tables["q_tt"]
    np.savez("bad.npz", **tables)
    status, _, err = run("bad.npz")
    assert status == 2 and "q_tt missing from a metric on a grid" in err


@pytest.mark.parametrize(("factor", "agrees"), [(1.0, True), (1.2, False)])
def test_the_curvature_in_a_file_is_compared(run, grid, factor, agrees):
    with np.load("grid.npz") as archive:
        tables = dict(archive)
    theta, phi = np.meshgrid(tables["theta"], tables["phi"], indexing="ij")
    u = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=2)
    K = KERR.gaussian_curvature(u.reshape(-1, 3)).reshape(theta.shape)
    np.savez("grid.npz", **tables, gaussian_curvature=factor * K)
    status, out, err = run("grid.npz", "--vertices", 60, "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["curvature_check"]["agrees"] is agrees
    assert any("is not that of the metric in use" in note for note in found["notes"]) is not agrees
    status, out, _ = run("grid.npz", "--vertices", 60)
    assert status == 0 and "K from gaussian_curvature in the file and of this metric differ by" in out


def test_the_band_of_what_is_not_symmetric_is_refused(run, monkeypatch):
    """The same horizon about the x-axis, on a grid."""

    class Turned:
        def tensor(self, u):
            order = [2, 0, 1]
            q = isoembed.relativity.KerrNewmanHorizon(1.0, 0.9).tensor(u[:, order])
            back = np.argsort(order)
            return q[:, back][:, :, back]

    monkeypatch.setattr(solve, "DEGREES", (8,))
    metric = GridMetric.sampled(Turned(), 24, 48)
    np.savez("x.npz", **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})
    status, _, err = run("x.npz", "--band", "band.npz", "--vertices", 60)
    assert status == 3 and not Path("band.npz").exists()
    assert "--band is for surfaces that are symmetric about the z-axis: " in err
