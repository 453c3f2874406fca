"""``isoembed series``: from files of a simulation to results, a table and pictures."""

import csv
import os
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from horizons import write_kerr
from isoembed.cli import batch
from isoembed.relativity import KerrSchild
from isoembed.runs import Result, Store
from strict_json import strict
from tasks import Here

GEOMETRY = ["--geometry", "slices/{iteration:04d}.npz"]
TIMES = {0: 0.0, 64: 0.5, 128: 1.0}
SPINS = {0: (0.5, 0.0, 0.0), 64: (0.3, 0.4, 0.0), 128: (0.0, 0.5, 0.0)}


@pytest.fixture
def run(call, monkeypatch):
    """Call ``isoembed series`` in an empty folder, without other processes."""
    monkeypatch.setattr(batch, "Workers", Here)
    return partial(call, "series", "--quiet")


@pytest.fixture
def simulation(call):
    """Horizons of a hole whose spin precesses, their times, and its slices on grids."""
    os.mkdir("slices")
    for iteration, spin in SPINS.items():
        write_kerr(f"h.t{iteration}.ah1.gp", spin)
        write_slice(f"slices/{iteration:04d}.npz", spin)
    lines = [f"{iteration} {time}" for iteration, time in TIMES.items()]
    Path("BH_diagnostics.ah1.gp").write_text(
        "\n".join(["# column  1 = cctk_iteration", "# column  2 = cctk_time", *lines, ""])
    )
    return [f"h.t{iteration}.ah1.gp" for iteration in SPINS]


@cache
def slice_of(spin, spacing=0.25, n=32):
    """A Kerr-Schild hole on a grid, no point of which is on its disk."""
    origin = np.array([-3.93, -3.91, -3.87])
    x = origin + spacing * np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    hole = KerrSchild(1.0, spin)
    tensors = {"g": hole.metric(x), "k": hole.extrinsic_curvature(x)}
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    arrays = {
        f"{name}{'xyz'[i]}{'xyz'[j]}": tensor[:, i, j].reshape(n, n, n)
        for name, tensor in tensors.items()
        for i, j in pairs
    }
    return {"origin": origin, "spacing": spacing, **arrays}


def write_slice(path, spin):
    np.savez(path, **slice_of(spin))


def rows(folder="out"):
    with open(f"{folder}/table.csv", newline="") as file:
        return {row["label"]: row for row in csv.DictReader(file)}


def test_films_of_earlier_commands_are_told_of(call):
    moment = {"series": "ah1", "time": 0.0, "iteration": 0}
    Store.made(Path("out")).keep(Result.without_answer("ah1.t0", "failed", "wrong", moment=moment), "0")
    assert call("series", "-o", "out")[2].count("of an earlier command") == 0
    Path("out/horizons.gif").write_bytes(b"")
    note = "isoembed: note: of an earlier command: horizons.gif; --film makes a new one\n"
    assert note in call("series", "-o", "out")[2]
    assert note not in call("series", "-o", "out", "--quiet")[2]


def test_a_folder_of_refused_horizons_says_so(call):
    moment = {"series": "ah1", "time": 0.0, "iteration": 0}
    for label, status in (("ah1.t0", "refused"), ("ah1.t1", "failed")):
        Store.made(Path("out")).keep(Result.without_answer(label, status, "wrong", moment=moment), "0")
    status, out, err = call("series", "-o", "out", "--film")
    assert status == 3 and "2 of 2: 1 refused, 1 failed" in out
    assert err.startswith("isoembed: error: ah1.t0: wrong\nisoembed: error: ah1.t1: wrong\n")
    assert err.endswith("isoembed: note: there is no film: no horizon is embedded\n")


@pytest.mark.slow
def test_a_precessing_hole(run, simulation):
    few = [*GEOMETRY, "--vertices", 60]
    status, out, err = run(*simulation, *few, "-o", "out", "--json")
    report = strict(out)
    assert (status, err, report["statuses"]) == (0, "", {"embedded": 3})
    assert {"table.csv", "horizons.pvd", "masses.png", "spin.png", "energies.png"} <= set(report["files"])
    assert all(Path("out", name).stat().st_size for name in report["files"])
    found = rows()
    assert [*found] == ["ah1.t0", "ah1.t64", "ah1.t128"]
    for row, (iteration, spin) in zip(found.values(), SPINS.items(), strict=True):
        assert (float(row["time"]), float(row["iteration"])) == (TIMES[iteration], iteration)
        assert abs(float(row["christodoulou_mass"]) - 1.0) <= float(row["christodoulou_mass_error"]) < 1e-2
        axis = np.array([float(row[f"axis_{letter}"]) for letter in "xyz"])
        assert np.linalg.norm(axis - np.array(spin) / 0.5) < 10.0 * float(row["axis_error"]) + 1e-3

    before = Path("out/table.csv").read_bytes()
    status, out, _ = run(*simulation, *few, "-o", "out", "--json")
    assert strict(out)["computed"] == 0 and Path("out/table.csv").read_bytes() == before
    Path("out/table.csv").unlink()
    assert run("-o", "out") == (0, "", "")
    assert Path("out/table.csv").read_bytes() == before

    for k, number in ((1, 2), (2, 1)):
        shard = ["--chunk", 1, "--shard", f"{k}/2"]
        report = strict(run(*simulation, *few, *shard, "-o", "parts", "--json")[1])
        assert (report["of"], report["files"]) == (number, [])
    assert run("-o", "parts") == (0, "", "")
    assert [float(row["area"]) for row in rows("parts").values()] == pytest.approx(
        [float(row["area"]) for row in found.values()], rel=1e-6
    )


@pytest.mark.slow
def test_what_is_in_the_way_of_some_is_a_row_of_theirs(run, simulation):
    Path("slices/0000.npz").write_bytes(Path("slices/0000.npz").read_bytes()[:5000])
    Path("slices/0064.npz").unlink()
    Path("h.t192.ah1.gp").write_text("no horizon")
    write_slice("slices/0192.npz", (0.0, 0.0, 0.0))
    files = [*simulation, "h.t192.ah1.gp"]
    status, out, err = run(*files, *GEOMETRY, "--vertices", 60, "-o", "out", "--json")
    assert (status, strict(out)["statuses"]) == (3, {"embedded": 1, "refused": 3})
    reasons = [row["reason"] for row in rows().values()]
    assert "slices/0000.npz" in reasons[0] and "there is no slice for ah1 at iteration 64" in reasons[1]
    assert reasons[2] == "" and reasons[3].startswith("h.t192.ah1.gp ")
    assert err.count("\n") == 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "out"], "there are no results in out"),
        (["-o", "out", "--axis", 0, 0, 1], "--axis needs HORIZONS"),
        (["-o", "out", "--jobs", 2], "--jobs needs HORIZONS"),
        (["h.t0.ah1.gp", *GEOMETRY, "--mass", 1, "-o", "out"], "--mass needs a --geometry in closed form"),
        (["h.t0.ah1.gp", "--mass", 1, "-o", "out"], "--mass needs a --geometry"),
        (["h.t9.ah1.gp", *GEOMETRY, "-o", "out"], "there is no file h.t9.ah1.gp"),
        (["h.t0.ah1.gp", *GEOMETRY, "--vertices", 3, "-o", "out"], "--vertices must be at least 12, not 3"),
        (
            ["h.t0.ah1.gp", "--geometry", "s/{iteration}.h5", "-o", "out"],
            "no file is named like s/{iteration}",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(run, simulation, arguments, message):
    status, _, err = run(*arguments)
    assert status == 2 and message in err
