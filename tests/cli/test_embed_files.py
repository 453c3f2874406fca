"""``isoembed embed`` of many files."""

import csv
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from isoembed import PolyhedralMetric, embed
from isoembed.cli import batch, main
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import read_surface, write_metric
from isoembed.runs import Store
from strict_json import strict
from tasks import Here

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


@pytest.fixture
def run(call, monkeypatch):
    """Call ``isoembed embed`` in an empty folder, without other processes."""
    monkeypatch.setattr(batch, "Workers", Here)
    return partial(call, "embed", "--jobs", 1, "--quiet")


@pytest.fixture(scope="module")
def ellipsoids():
    return [PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3.0, 2.0, float(k))), 50)) for k in (1, 2, 3)]


@pytest.fixture
def metrics(call, ellipsoids):
    """Three metrics in files, and one that is none."""
    for k, metric in enumerate(ellipsoids, 1):
        write_metric(f"m{k}.npz", metric)
    Path("wrong.npz").write_text("no archive")
    return ellipsoids


def rows():
    with open("out/table.csv", newline="") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


def test_every_file_gets_its_surface_its_report_and_its_row(call, metrics):
    """The whole way, with two processes."""
    status, out, err = call(
        "embed", "--jobs", 2, "--quiet", "m1.npz", "m2.npz", "m3.npz", "wrong.npz", "-o", "out"
    )
    assert (status, out) == (3, "")
    assert err == "isoembed: error: wrong: wrong.npz is not an npz archive, or is cut short\n"
    found = rows()
    assert [*found] == ["m1", "m2", "m3", "wrong"]
    assert (found["wrong"]["status"], found["wrong"]["volume"]) == ("refused", "")
    for k, metric in enumerate(metrics, 1):
        surface = embed(metric)
        assert found[f"m{k}"]["status"] == "converged"
        assert float(found[f"m{k}"]["volume"]) == pytest.approx(surface.volume, rel=1e-12)
        assert strict(Path(f"out/m{k}.json").read_text())["area"] == pytest.approx(surface.area, rel=1e-12)
        again = read_surface(f"out/m{k}.ply")
        assert again.volume == pytest.approx(surface.volume, rel=1e-5)  # in single precision
        assert np.array_equal(again.faces, metric.faces)


def test_again_only_what_is_new_is_done(run, metrics):
    run("m1.npz", "m2.npz", "-o", "out")
    before = Path("out/table.csv").read_bytes()
    status, out, _ = run("m1.npz", "m2.npz", "-o", "out", "--json")
    assert (status, strict(out)["computed"]) == (0, 0) and Path("out/table.csv").read_bytes() == before
    write_metric("m2.npz", metrics[2])
    assert strict(run("m1.npz", "m2.npz", "-o", "out", "--json")[1])["computed"] == 1
    volumes = [float(row["volume"]) for row in rows().values()]
    assert volumes[1] == pytest.approx(embed(metrics[2]).volume, rel=1e-12)
    assert strict(run("m1.npz", "m2.npz", "-o", "out", "--json", "--force")[1])["computed"] == 2
    other = ["--method", "alexandrov", "--json"]
    assert strict(run("m2.npz", "m3.npz", "-o", "out", *other)[1])["computed"] == 2


def test_failures_are_tried_again_on_request(run, metrics):
    arguments = ("m1.npz", "wrong.npz", "-o", "out", "--json")
    assert strict(run(*arguments)[1])["computed"] == 2
    assert strict(run(*arguments)[1])["computed"] == 0
    report = strict(run(*arguments, "--retry")[1])
    assert (report["computed"], report["statuses"]) == (1, {"converged": 1, "refused": 1})
    assert len(report["failures"]) == 1 and report["failures"][0].startswith("wrong: ")


def test_polyhedra_keep_their_faces(run, call):
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    text = [*(f"v {x} {y} {z}" for x, y, z in CUBE), *(f"f {' '.join(str(a + 1) for a in q)}" for q in quads)]
    Path("cube.obj").write_text("\n".join(text))
    assert run("cube.obj", "cube.obj", "-o", "out")[0] == 2  # the same name twice
    Path("out").mkdir()
    status, _, _ = run("cube.obj", "-o", "out", "--method", "alexandrov")
    assert status == 0
    [result] = Store(Path("out"))
    assert sorted(result.arrays["sizes"]) == [4] * 6
    assert read_surface("out/cube.ply").volume == pytest.approx(1.0, rel=1e-6)


def test_parts_leave_the_table_to_the_whole(run, metrics):
    files = ["m1.npz", "m2.npz", "-o", "out", "--chunk", 1, "--json"]
    for k in (1, 2):
        report = strict(run(*files, "--shard", f"{k}/2")[1])
        assert (report["of"], report["computed"], report["table"]) == (1, 1, None)
        assert not Path("out/table.csv").exists()
    assert strict(run(*files)[1])["computed"] == 0 and [*rows()] == ["m1", "m2"]
    run("m3.npz", "wrong.npz", "-o", "out")
    assert [*rows()] == ["m3", "wrong"]  # those that were asked for


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["m1.npz", "m2.npz"], "2 files need an --output: the folder for their surfaces"),
        (["m1.npz", "a/m1.json", "-o", "out"], "m1.npz and a/m1.json have the same name: m1"),
        (["m1.npz", "-", "-o", "out"], "standard input, -, cannot be combined with other inputs"),
        (["m1.npz", "m2.npz", "-o", "out", "--html", "x.html"], "--html is for a single input"),
        (["m1.npz", "-o", "m1.ply"], "--jobs is for several files, whose --output is a folder"),
        (["m1.npz", "m2.npz", "-o", "out", "--shard", "3/2"], "'3/2' is not I/N with I from 1 to N"),
        (["m1.json", "m2.npz", "-o", "."], "m1.json would overwrite the input m1.json: take another"),
        (["m1.npz", "m2.npz", "-o", "m1.npz"], "the output m1.npz is not a folder"),
    ],
)
def test_what_makes_no_sense_is_refused(run, metrics, arguments, message):
    status, _, err = run(*arguments)
    assert status == 2 and message in err


def test_all_wrong_is_wrong(metrics, tmp_path, monkeypatch, capfd):
    """Status 2, but unlike other refusals it leaves the table behind."""
    monkeypatch.setattr(batch, "Workers", Here)
    monkeypatch.chdir(tmp_path)
    Path("other.npz").write_text("")
    assert main(["embed", "--quiet", "wrong.npz", "other.npz", "-o", "out"]) == 2
    assert [row["status"] for row in rows().values()] == ["refused"] * 2
    assert capfd.readouterr().err.count("\n") == 2


def test_surfaces_with_a_boundary_are_refused_with_what_to_do(run, metrics):
    disc = PolyhedralMetric.from_mesh(np.eye(3), [[0, 1, 2]])
    write_metric("disc.npz", disc)
    status, _, err = run("disc.npz", "m3.npz", "-o", "out")
    assert status == 3
    assert "disc: " in err and "--boundary free is for such surfaces" in err
