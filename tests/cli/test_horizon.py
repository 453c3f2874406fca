"""``isoembed horizon``: from files, written here from known horizons, to energies and what is written."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from isoembed.cli import horizon as command
from isoembed.cli import main
from isoembed.io import read_metric
from isoembed.relativity import KerrNewmanHorizon, KerrSchild
from isoembed.relativity.energies import report as energy_report
from isoembed.smooth import GridMetric, solve
from places import SHARED

FILES = SHARED / "real" / "einsteintoolkit"
IMC = {0.5: 24.300446945608874, 0.6: 23.898597646410372}
AXES = ("+z", "+x", "+y", "-x", "-y", "-z")
KERR_SCHILD = ["--geometry", "kerr-schild", "--vertices", 100]


def shape_text(radius, center=(0.0, 0.0, 0.0), n=13):
    """A shape file as AHFinderDirect writes it: six patches of n x n points."""
    angles = np.linspace(-45.0, 45.0, n)
    slope = np.tan(np.radians(angles))
    lines = ["# N_patches = 6", "# origin = " + " ".join(map(repr, center)), ""]
    for name in AXES:
        axis, side = "xyz".index(name[1]), 1.0 if name[0] == "+" else -1.0
        j, k = (i for i in range(3) if i != axis)
        u = np.empty((n, n, 3))
        u[..., axis], u[..., j], u[..., k] = side, slope[None, :], slope[:, None]
        u /= np.linalg.norm(u, axis=2, keepdims=True)
        r = radius(u.reshape(-1, 3)).reshape(n, n)
        lines += [f"### {name} patch", f"# N_rho = {n}", f"# N_sigma = {n}"]
        lines += ["# ghosted_gfn=-3", "# dpx = dsigma", "# dpy = drho", "#", "# dpx dpy gridfn x y z"]
        for i in range(n):
            for m in range(n):
                x, y, z = np.array(center) + r[i, m] * u[i, m]
                lines.append(
                    f"{angles[m]:.6g}\t{angles[i]:.6g}\t{r[i, m]:.15g}\t{x:.15g}\t{y:.15g}\t{z:.15g}"
                )
            lines.append("")
        lines.append("")
    return "\n".join(lines)


def write_kerr(name, spin):
    """The horizon of a Kerr black hole of mass 1 in Kerr-Schild coordinates."""
    geometry = KerrSchild(1.0, spin)
    Path(name).write_text(shape_text(geometry.spheroid(geometry.horizon)))


def write_grid(name, a):
    metric = GridMetric.sampled(KerrNewmanHorizon(1.0, a), 32, 8)
    np.savez(name, **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Call the command in an empty folder; return its status, its output and its complaint."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        before = set(os.listdir())
        status = main(["horizon", *map(str, arguments)])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        if status == 2:
            assert set(os.listdir()) == before
            assert out == "" and err.startswith("isoembed: error: ") and err.count("\n") == 1
        return status, out, err

    return call


def strict(text):
    return json.loads(text, parse_constant=lambda constant: pytest.fail(f"{constant} is no JSON"))


def check(found, a, largest=1e-6):
    """A Kerr horizon, within its errors."""
    r = 1.0 + np.sqrt(1.0 - a**2)
    area = 4.0 * np.pi * (r**2 + a**2)
    for name, exact in (
        ("area", area),
        ("integrated_mean_curvature", IMC[a]),
        ("irreducible_mass", np.sqrt(area / (16.0 * np.pi))),
        ("hawking", np.sqrt(area / (16.0 * np.pi))),
        ("liu_yau", IMC[a] / (4.0 * np.pi)),
    ):
        assert abs(found[name] - exact) <= found["errors"][name] <= largest * exact


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.5), (-0.48, 0.36, 0.0)])
def test_a_horizon_in_kerr_schild_coordinates(run, spin):
    write_kerr("h.t0.ah1.gp", spin)
    status, out, err = run("h.t0.ah1.gp", *KERR_SCHILD, "--spin", *spin, "--json")
    assert (status, err) == (0, "")
    found, a = strict(out), round(float(np.linalg.norm(spin)), 12)
    check(found, a)
    assert abs(found["christodoulou_mass"] - 1.0) <= 1e-7  # J about the axis of the spin
    assert found["horizon"]["points"] == 6 * 13**2 - 12 * 13 + 8
    assert found["horizon"]["largest_expansion"] < 1e-4
    assert found["name"] == "h.t0.ah1.gp" and found["status"] == "embedded"
    assert os.listdir() == ["h.t0.ah1.gp"]


def test_about_an_axis_across_the_spin_there_is_no_angular_momentum(run):
    write_kerr("h.gp", (0.0, 0.0, 0.5))
    status, out, _ = run("h.gp", *KERR_SCHILD, "--spin", 0, 0, 0.5, "--axis", 3, 4, 0, "--json")
    found = strict(out)
    assert status == 0
    check(found, 0.5)
    assert found["christodoulou_mass"] == pytest.approx(found["irreducible_mass"], abs=1e-7)


def test_what_is_written(run):
    write_kerr("h.t0.ah1.gp", (0.0, 0.0, 0.5))
    status, out, err = run("h.t0.ah1.gp", *KERR_SCHILD, "--spin", 0, 0, 0.5, "-o", "deep/found")
    assert (status, err) == (0, "")
    assert sorted(os.listdir("deep/found")) == [f"h.t0.ah1.{ending}" for ending in ("json", "png", "vtk")]
    found = strict(Path("deep/found/h.t0.ah1.json").read_text())
    check(found, 0.5)
    assert read_metric("deep/found/h.t0.ah1.vtk").triangulation.n_vertices == 100
    assert Path("deep/found/h.t0.ah1.png").read_bytes().startswith(b"\x89PNG")
    for words in ("h.t0.ah1.gp\n", "Kijowski-Liu-Yau energy", "points, fitted to", "0 on a horizon"):
        assert words in out


def test_without_matplotlib_there_is_no_picture(run, monkeypatch):
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    write_grid("grid.npz", 0.5)
    status, _, err = run("grid.npz", "--vertices", 60, "-o", "found")
    assert status == 0 and "pictures need matplotlib, pip install 'isoembed[plot]'" in err
    assert sorted(os.listdir("found")) == ["grid.json", "grid.vtk"]


def test_a_grid_needs_no_geometry(run):
    write_grid("grid.npz", 0.5)
    status, out, err = run("grid.npz", "--vertices", 60, "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    check(found, 0.5)
    assert found["brown_york"] is None and found["horizon"] == {}
    assert "Brown-York" in found["notes"][0]
    status, out, _ = run("grid.npz", "--vertices", 60)
    assert status == 0 and out.startswith("grid.npz\n")


def test_a_sequence_begins_each_from_the_one_before(run, monkeypatch):
    meshes = []
    graded_mesh = solve.graded_mesh
    monkeypatch.setattr(solve, "graded_mesh", lambda *a, **o: meshes.append(1) or graded_mesh(*a, **o))
    write_grid("a.npz", 0.5)
    write_grid("b.npz", 0.6)
    status, out, err = run("a.npz", "b.npz", "--vertices", 60, "--json", "-o", "found")
    assert (status, err) == (0, "") and len(meshes) == 1
    first, second = strict(out)
    check(first, 0.5)
    check(second, 0.6)
    assert [first["name"], second["name"]] == ["a.npz", "b.npz"]
    assert len(os.listdir("found")) == 6
    assert strict(Path("found/b.json").read_text()) == second


def test_a_sequence_in_text(run):
    write_grid("a.npz", 0.5)
    write_grid("b.npz", 0.6)
    status, out, _ = run("a.npz", "b.npz", "--vertices", 60)
    assert status == 0 and out.index("a.npz\n") < out.index("b.npz\n")
    assert out.count("Kijowski-Liu-Yau energy") == 2


@pytest.mark.parametrize("order", [("bad", "good"), ("good", "bad", "other")])
def test_where_one_does_not_embed_the_others_are_answered(run, monkeypatch, order):
    monkeypatch.setattr(solve, "SOLVE", replace(solve.SOLVE, degrees=(8, 12, 16)))
    spins = {"good": 0.5, "bad": 0.9, "other": 0.6}
    for name in order:
        write_grid(f"{name}.npz", spins[name])
    files = [f"{name}.npz" for name in order]
    status, out, err = run(*files, "--vertices", 60, "--json", "-o", "found")
    assert status == 3
    assert err.startswith("isoembed: error: bad.npz: no surface of revolution has this metric")
    assert err.count("\n") == 1
    reports = {report["name"]: report for report in strict(out)}
    for name in set(order) - {"bad"}:
        check(reports[f"{name}.npz"], spins[name])
    assert {path for path in os.listdir("found") if path.endswith(".vtk")} == {
        f"{name}.vtk" for name in set(order) - {"bad"}
    }
    with open("found/bad.json") as file:  # what needs no embedding is reported all the same
        report = json.load(file)
    assert report["status"] == "not embedded" and report["irreducible_mass"] > 0.0
    assert report["brown_york"] is None and reports["bad.npz"] == report


REFUSED = [
    ([], "arguments are required: FILE"),
    (["no.gp"], "there is no file no.gp"),
    (["h.gp"], "name it with --geometry"),
    (["grid.npz", "--geometry", "kerr-schild"], "grid.npz holds a metric of its own: it needs no --geometry"),
    (["h.gp", "./h.gp", *KERR_SCHILD], "have the same name: h"),
    (["h.gp", "h.npz", *KERR_SCHILD], "h.gp and h.npz have the same name: h"),
    (["h.gp", "--geometry", "flat"], "flat"),
    (["h.gp", "--geometry", "no.h5"], "there is no file no.h5"),
    (["h.gp", "--geometry", "isotropic", "--spin", 0, 0, 0.5], "isotropic has no spin: take kerr-schild"),
    (["h.gp", "--geometry", "painleve-gullstrand", "--spin", 0, 0.1, 0], "has no spin: take kerr-schild"),
    (["h.gp", "--mass", 2], "--mass needs a --geometry among kerr-schild, isotropic, painleve-gullstrand"),
    (["h.gp", "--spin", 0, 0, 0.5], "--spin needs a --geometry among"),
    (["h.gp", "--geometry", "kerr-schild", "--mass", -1], "the mass"),
    (["h.gp", "--geometry", "kerr-schild", "--mass", "nan"], "the mass"),
    (["h.gp", "--geometry", "kerr-schild", "--spin", 0, 0], "--spin: expected 3 arguments"),
    (["h.gp", *KERR_SCHILD, "--axis", 0, 0, 0], "--axis 0 0 0 is no axis"),
    (["h.gp", *KERR_SCHILD[:2], "--vertices", 11], "--vertices must be at least 12, not 11"),
    (["bad.gp", *KERR_SCHILD], "bad.gp"),
    (["grid.npz", "bad.gp", "-o", "found"], "bad.gp"),
    (["grid.npz", "-o", "h.gp"], "cannot make the folder h.gp"),
    (["grid.npz", "-o", "h.gp/found"], "cannot make the folder h.gp/found"),
]


@pytest.mark.parametrize(("arguments", "sentence"), REFUSED)
def test_refusals(run, monkeypatch, arguments, sentence):
    monkeypatch.setattr(energy_report, "embed_surface", lambda *_, **__: pytest.fail("it computed"))
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


@pytest.mark.parametrize("scale", [1e-3, 1e6])
def test_units(run, scale):
    geometry = KerrSchild(scale, (0.0, 0.0, 0.5 * scale))
    Path("h.gp").write_text(shape_text(geometry.spheroid(geometry.horizon)))
    arguments = ["--mass", scale, "--spin", 0, 0, 0.5 * scale, "--json"]
    status, out, _ = run("h.gp", *KERR_SCHILD, *arguments)
    assert status == 0
    found = strict(out)
    assert found["liu_yau"] / scale == pytest.approx(IMC[0.5] / (4.0 * np.pi), rel=1e-7)
    assert found["errors"]["liu_yau"] <= 1e-6 * scale


@pytest.mark.shared
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
