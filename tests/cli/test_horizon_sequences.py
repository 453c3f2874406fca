"""``isoembed horizon`` of several files: each begins from the one before, and failures do not end them."""

import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from horizons import check, write_grid
from isoembed.smooth import solve
from isoembed.smooth.start import Start
from strict_json import strict


@pytest.fixture
def run(call):
    """Call ``isoembed horizon`` in an empty folder."""
    return partial(call, "horizon")


def test_a_sequence_begins_each_from_the_one_before(run, monkeypatch):
    starts = []
    restored = Start.restored
    monkeypatch.setattr(Start, "restored", lambda arrays: starts.append(1) or restored(arrays))
    write_grid("a.npz", 0.5)
    write_grid("b.npz", 0.6)
    status, out, err = run("a.npz", "b.npz", "--marginal", "--vertices", 60, "--json", "-o", "found")
    assert (status, err) == (0, "") and len(starts) == 1
    first, second = strict(out)
    check(first, 0.5)
    check(second, 0.6)
    assert [first["name"], second["name"]] == ["a.npz", "b.npz"]
    assert len(os.listdir("found")) == 6
    assert strict(Path("found/b.json").read_text()) == second


def test_where_one_is_refused_the_others_are_answered(run):
    write_grid("a.npz", 0.5)
    write_grid("flat.npz", 0.5)
    with np.load("flat.npz") as archive:
        tables = dict(archive) | {"q_tt": 0.0 * archive["q_tt"]}
    np.savez("flat.npz", **tables)
    Path("bad.gp").write_text("# N_patches = 6\n# origin = 0 0 0\n")
    files = ["no.npz", "a.npz", "bad.gp", "flat.npz"]
    status, out, err = run(*files, "--marginal", "--vertices", 60, "--json", "-o", "found")
    assert status == 3
    lines = err.splitlines()
    assert len(lines) == 3 and lines[0] == "isoembed: error: there is no file no.npz"
    assert "bad.gp" in lines[1] and "flat.npz" in lines[2]
    reports = strict(out)
    assert [report["name"] for report in reports] == files
    assert [report["status"] for report in reports] == ["refused", "embedded", "refused", "refused"]
    check(reports[1], 0.5)
    assert reports[0]["message"] == "there is no file no.npz"
    assert sorted(os.listdir("found")) == ["a.json", "a.png", "a.vtk"]


def test_where_all_are_refused_nothing_is_done(run):
    """By the embedding, which finds the metric beyond the range of numbers."""
    write_grid("a.npz", 0.5)
    with np.load("a.npz") as arrays:
        scaled = {name: values * (1e210 if name[0] == "q" else 1.0) for name, values in arrays.items()}
    np.savez("a.npz", **scaled)
    status, _, err = run("a.npz", "--marginal", "--json")
    assert status == 2 and "isoembed: error: a.npz: products of squared lengths of about" in err


@pytest.mark.parametrize(
    ("order", "form"), [(("bad", "good"), ["--json"]), (("good", "bad", "other"), [])], ids=("json", "text")
)
@pytest.mark.slow
def test_where_one_does_not_embed_the_others_are_answered(run, monkeypatch, order, form):
    monkeypatch.setattr(solve, "DEGREES", (8, 12, 16))
    spins = {"good": 0.5, "bad": 0.9, "other": 0.6}
    for name in order:
        write_grid(f"{name}.npz", spins[name])
    files = [f"{name}.npz" for name in order]
    status, out, err = run(*files, "--marginal", "--vertices", 60, *form, "-o", "found")
    assert status == 3
    assert err.startswith("isoembed: error: bad.npz: no surface of revolution has this metric")
    assert err.count("isoembed: error: ") == 1
    reports = {f"{name}.npz": strict(Path(f"found/{name}.json").read_text()) for name in order}
    if form:
        assert strict(out) == [reports[name] for name in files]
    else:
        assert out.index("good.npz\n") < out.index("other.npz\n")
        assert out.count("Kijowski-Liu-Yau energy") == 2
    for name in set(order) - {"bad"}:
        check(reports[f"{name}.npz"], spins[name])
    assert {path for path in os.listdir("found") if path.endswith(".vtk")} == {
        f"{name}.vtk" for name in set(order) - {"bad"}
    }
    report = reports["bad.npz"]  # what needs no embedding is reported all the same
    assert report["status"] == "not embedded" and report["irreducible_mass"] > 0.0
    assert report["brown_york"] is None
