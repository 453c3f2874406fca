"""``isoembed horizon`` of several files: each begins from the one before, and failures do not end them."""

import os
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from horizons import check, write_grid
from isoembed.smooth import solve
from strict_json import strict


@pytest.fixture
def run(call):
    """Call ``isoembed horizon`` in an empty folder."""
    return partial(call, "horizon")


def test_a_sequence_begins_each_from_the_one_before(run, monkeypatch):
    meshes = []
    graded_mesh = solve.graded_mesh
    monkeypatch.setattr(solve, "graded_mesh", lambda *a, **o: meshes.append(1) or graded_mesh(*a, **o))
    write_grid("a.npz", 0.5)
    write_grid("b.npz", 0.6)
    status, out, err = run("a.npz", "b.npz", "--marginal", "--vertices", 60, "--json", "-o", "found")
    assert (status, err) == (0, "") and len(meshes) == 1
    first, second = strict(out)
    check(first, 0.5)
    check(second, 0.6)
    assert [first["name"], second["name"]] == ["a.npz", "b.npz"]
    assert len(os.listdir("found")) == 6
    assert strict(Path("found/b.json").read_text()) == second


@pytest.mark.parametrize(
    ("order", "form"), [(("bad", "good"), ["--json"]), (("good", "bad", "other"), [])], ids=("json", "text")
)
@pytest.mark.slow
def test_where_one_does_not_embed_the_others_are_answered(run, monkeypatch, order, form):
    monkeypatch.setattr(solve, "SOLVE", replace(solve.SOLVE, degrees=(8, 12, 16)))
    spins = {"good": 0.5, "bad": 0.9, "other": 0.6}
    for name in order:
        write_grid(f"{name}.npz", spins[name])
    files = [f"{name}.npz" for name in order]
    status, out, err = run(*files, "--marginal", "--vertices", 60, *form, "-o", "found")
    assert status == 3
    assert err.startswith("isoembed: error: bad.npz: no surface of revolution has this metric")
    assert err.count("\n") == 1
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
