"""The command: every exit status, what is written and what is said."""

from __future__ import annotations

import gc
import io
import json
import os
import pty
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import Embedding, NotEmbedded, PolyhedralMetric
from isoembed.cli import main
from isoembed.cli.advice import in_options
from isoembed.cli.parameters import parsed
from isoembed.io import read_metric, read_surface, write_metric
from isoembed.linalg import OutOfMemory
from strict_json import strict

COMMAND = [sys.executable, "-c", "import sys; from isoembed.cli import main; sys.exit(main())"]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder with the metric of an icosphere in it."""
    monkeypatch.chdir(tmp_path)
    vertices, faces = zoo.icosphere(1)
    write_metric("metric.json", PolyhedralMetric.from_mesh(vertices, faces))
    return tmp_path


@pytest.fixture
def run(here, capfd):
    """Call the command in that folder; return its status, its output and its complaint."""

    def call(*arguments):
        before = set(os.listdir())
        status = main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        if status == 2:
            assert set(os.listdir()) == before
            assert err.startswith("isoembed: error: ")
            assert err.count("\n") == 1
        return status, out, err

    return call


def attempt(metric, **_):
    """Stand in for an embedding that fails: twice the sphere."""
    vertices, _ = zoo.icosphere(1)
    raise NotEmbedded(
        "the path ended\nat t = 0.3", Embedding(metric, 2 * vertices, method="aim", tolerance=1e-10)
    )


def interrupt(metric, **_):
    raise KeyboardInterrupt


# embed


@pytest.mark.parametrize("method", ["aim", "paper"])
def test_embed_writes_what_the_report_says(run, method):
    status, out, err = run(
        "embed", "metric.json", "--method", method, "-o", "surface.npz", "--report", "report.json"
    )
    assert (status, err) == (0, "")
    assert out.startswith("converged: the lengths are within the tolerance 1e-10: the largest residual is ")
    assert "\nsurface.npz, report.json written, " in out
    report = json.loads(Path("report.json").read_text())
    with np.load("surface.npz") as archive:
        vertices, faces = archive["vertices"], archive["faces"]
    metric = read_metric("metric.json")
    np.testing.assert_array_equal(faces, metric.faces)
    a, b = metric.edges.T
    error = np.abs(np.linalg.norm(vertices[a] - vertices[b], axis=1) - metric.lengths) / metric.lengths.mean()
    assert error.max() <= 1e-10
    assert report["residual"]["max"] == pytest.approx(error.max(), rel=0.05, abs=1e-14)
    assert report["status"] == "converged"
    assert report["method"] == method
    counts = {"vertices": 42, "edges": 120, "faces": 80, "negative_deficits": 0}
    mean = metric.lengths.mean()
    assert report["input"] == {**counts, "mean_length": pytest.approx(mean), "precision": None}
    assert {"version", "message", "convexity", "area", "volume", "integrated_mean_curvature"} <= set(report)
    assert set(report["stages"][0]) == {"name", "seconds", "iterations", "factorizations"}


def test_embed_without_output_says_a_summary(run):
    status, out, err = run("embed", "metric.json")
    assert (status, err) == (0, "")
    for words in (
        "converged",
        "residual",
        "inverted",
        "volume",
        "H = (k1 + k2)/2",
    ):
        assert words in out
    assert "factorizations" not in out
    assert not out.endswith(" s\n")  # what is piped is the same every time
    said = run("embed", "metric.json", "--verbose")[1]
    assert "factorizations" in said and "total" in said
    assert run("embed", "metric.json", "--quiet") == (0, "", "")


def test_embed_reads_standard_input(run, monkeypatch):
    data = Path("metric.json").read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    status, _, _ = run("embed", "-", "-o", "surface.ply")
    assert status == 0
    np.testing.assert_allclose(
        read_metric("surface.ply").lengths, read_metric("metric.json").lengths, rtol=1e-9
    )


def test_embed_takes_parameters_of_the_method(run, monkeypatch):
    seen = []

    def listen(metric, *, method, tolerance, progress, resume):
        seen.append((method, tolerance, callable(progress), resume))
        return Embedding(metric, zoo.icosphere(1)[0], method="paper", tolerance=tolerance)

    monkeypatch.setattr(isoembed, "embed", listen, raising=False)
    arguments = ["--parameter", "Tsteps=20", "--parameter", "path=exponential", "--parameter", "alpha=0.25"]
    assert run("embed", "metric.json", "--method", "paper", "--tolerance", "1e-6", *arguments)[0] == 0
    assert seen == [(isoembed.Paper(Tsteps=20, path="exponential", alpha=0.25), 1e-6, True, None)]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "arguments are required: INPUT"),
        (["no.npz"], "there is no file no.npz"),
        (["metric.txt"], "not one of .npz .json"),
        (["metric.json", "--method", "magic"], "invalid choice: 'magic'"),
        (["metric.json", "--tolerance", "0"], "0 is not a positive finite number"),
        (["metric.json", "--tolerance", "nan"], "nan is not a positive finite number"),
        (["metric.json", "--tolerance", "small"], "'small' is not a number"),
        (["metric.json", "-o", "a.txt"], "a.txt has the ending '.txt'"),
        (["metric.json", "-o", "no/a.npz"], "there is no folder"),
        (["metric.json", "--report", "report.txt"], "not one of .json"),
        (["metric.json", "-o", "a.json", "--report", "./a.json"], "are the same file"),
        (["metric.json", "--keep"], "--keep needs an --output"),
        (["metric.json", "--tol", "1"], "unrecognized arguments: --tol"),
        (["metric.json", "--parameter", "Tsteps"], "is not of the form NAME=VALUE"),
        (["metric.json", "--parameter", "speed=1"], "has no parameter 'speed'; it has "),
        (["metric.json", "--method", "paper", "--parameter", "Tsteps=1.5"], "'1.5' is not a whole number"),
        (["metric.json", "--method", "paper", "--parameter", "alpha=big"], "'big' is not a number"),
        (["metric.json", "--method", "paper", "--parameter", "path=straight"], "is not one of linear, "),
        (["metric.json", "--method", "paper", "--parameter", "Tsteps=-1"], "Tsteps is -1, not positive"),
        (["metric.json", "--method", "paper", "--parameter", "name=x"], "has no parameter 'name'"),
    ],
)
def test_embed_refuses(run, monkeypatch, arguments, sentence):
    monkeypatch.setattr(isoembed, "embed", lambda *_, **__: pytest.fail("it computed"), raising=False)
    status, out, err = run("embed", *arguments)
    assert (status, out) == (2, "")
    assert sentence in err


def test_embed_refuses_what_is_not_a_metric(run, here):
    (here / "bad.json").write_text('{"faces": [[0, 1, 2]], "lengths": [1, 1, 1]}')
    status, _, err = run("embed", "bad.json", "-o", "a.npz", "--report", "r.json")
    assert status == 2
    assert "the surface is not closed" in err


def test_embed_that_fails_says_why_and_keeps_on_request(run, here, monkeypatch):
    monkeypatch.setattr(isoembed, "embed", attempt, raising=False)
    status, _, err = run("embed", "metric.json", "-o", "a.npz", "--report", "r.json")
    assert status == 3
    assert err == "isoembed: error: the path ended at t = 0.3\n"
    assert sorted(os.listdir()) == ["metric.json", "r.json"]
    report = json.loads((here / "r.json").read_text())
    assert report["status"] == "not converged"
    assert report["message"].startswith("the path ended")
    assert report["residual"]["max"] == pytest.approx(1, rel=0.2)
    assert run("embed", "metric.json", "-o", "a.npz", "--keep")[0] == 3
    with np.load("a.npz") as archive:
        assert np.abs(np.linalg.norm(archive["vertices"], axis=1) - 2).max() < 1e-12


@pytest.mark.parametrize("beside", [(), ("-o", "a.npz"), ("--quiet",)])
def test_embed_prints_the_report_as_json(run, here, beside):
    status, out, err = run("embed", "metric.json", "--json", "--report", "r.json", *beside)
    assert (status, err) == (0, "")
    assert out == (here / "r.json").read_text()
    assert strict(out)["status"] == "converged"


def test_embed_that_fails_says_so_in_json(run, here, monkeypatch):
    monkeypatch.setattr(isoembed, "embed", attempt, raising=False)
    status, out, err = run("embed", "metric.json", "--json", "-o", "a.npz")
    assert (status, err) == (3, "isoembed: error: the path ended at t = 0.3\n")
    report = strict(out)
    assert (report["status"], report["message"]) == ("not converged", "the path ended\nat t = 0.3")
    assert report["evidence"] == "searched"
    assert os.listdir() == ["metric.json"]


def test_status_and_file_agree_with_the_residual(run, here):
    metric = read_metric("metric.json")
    lengths = metric.lengths * np.random.default_rng(5).uniform(0.75, 1.3, len(metric.lengths))
    write_metric("crumpled.json", metric.with_lengths(lengths))
    status, _, err = run("embed", "crumpled.json", "-o", "a.npz", "--report", "r.json")
    report = json.loads((here / "r.json").read_text())
    assert status in (0, 3)
    assert (status == 0) == (report["residual"]["max"] <= 1e-10) == os.path.exists("a.npz")
    assert (status == 3) == err.startswith("isoembed: error: ")


def test_embed_interrupted(run, monkeypatch):
    monkeypatch.setattr(isoembed, "embed", interrupt, raising=False)
    status, _, err = run("embed", "metric.json", "-o", "a.npz", "--report", "r.json")
    assert status == 130
    assert err == "isoembed: error: interrupted\n"
    assert os.listdir() == ["metric.json"]


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (MemoryError(), "there is not enough memory for this"),
        (
            MemoryError("Unable to allocate 9 TiB"),
            "there is not enough memory for this: Unable to allocate 9 TiB",
        ),
        (OutOfMemory("the factors need 9 TB"), "the factors need 9 TB"),
    ],
)
def test_embed_without_memory(run, monkeypatch, error, sentence):
    def exhaust(*_, **__):
        raise error

    monkeypatch.setattr(isoembed, "embed", exhaust, raising=False)
    assert run("embed", "metric.json") == (2, "", f"isoembed: error: {sentence}\n")


def test_a_file_that_cannot_be_written_loses_no_other(run, here, monkeypatch):
    def full(path, text, **_):
        raise OSError(28, "No space left on device")

    (here / "a.npz").write_text("old")
    (here / "p.html").write_text("old")
    monkeypatch.setattr(Path, "write_text", full)
    status, _, err = run("embed", "metric.json", "-o", "a.npz", "--report", "r.json", "--html", "p.html")
    assert status == 2
    assert err == (
        "isoembed: error: cannot write r.json: No space left on device; "
        "cannot write p.html: No space left on device; a.npz is written\n"
    )
    assert len(read_surface("a.npz").vertices) == 42
    assert (here / "p.html").read_text() == "old"


# inspect


def test_inspect_a_convex_metric(run):
    status, out, _ = run("inspect", "metric.json")
    assert status == 0
    assert "42 vertices, 120 edges, 80 faces" in out
    assert "warning" not in out


def test_inspect_measures_in_json(run):
    vertices, faces = zoo.cube()
    write_metric("cube.json", PolyhedralMetric.from_mesh(vertices, faces))
    found = json.loads(run("inspect", "cube.json", "--json")[1])
    assert found["area"]["total"] == pytest.approx(6)
    assert found["angles"] == pytest.approx({"min_degrees": 45, "max_degrees": 90})
    assert found["deficits"]["min"] == pytest.approx(np.pi / 2)
    assert found["deficits"]["sum_minus_4_pi"] == pytest.approx(0, abs=1e-13)
    assert found["delaunay"]["violations"] == 0
    assert found["dual_areas"]["max"] == pytest.approx(0.75)


def dented(depth):
    vertices, faces = (np.array(part) for part in zoo.icosphere(1))
    vertices[0] *= depth
    return PolyhedralMetric.from_mesh(vertices, faces)


def flat_box():
    vertices, faces = zoo.subdivided(*zoo.cube())
    return PolyhedralMetric.from_mesh(vertices, faces)


def stretched():
    vertices, faces = zoo.icosphere(1)
    return PolyhedralMetric.from_mesh(vertices * [1e4, 1, 1], faces)


def pointed():
    points, faces = zoo.tetrahedron()
    return PolyhedralMetric.from_mesh(points, faces)


@pytest.mark.parametrize(
    ("metric", "kinds"),
    [
        (dented(0.2), {"negative_deficits"}),
        (flat_box(), {"flat_vertices"}),
        (stretched(), {"needles", "dual_areas", "not_delaunay", "length_ratio"}),
        (pointed(), {"degree_three"}),
    ],
    ids=["dented", "flat", "stretched", "pointed"],
)
def test_inspect_warns(run, metric, kinds):
    write_metric("m.npz", metric)
    found = json.loads(run("inspect", "m.npz", "--json")[1])["warnings"]
    assert kinds <= {warning["kind"] for warning in found}
    text = run("inspect", "m.npz")[1]
    assert all(f"warning: {in_options(warning['message'])}" in text for warning in found)


@pytest.mark.parametrize("size", [1e-200, 1e12, 1e200])
def test_inspect_at_any_size(run, size):
    metric = read_metric("metric.json")
    write_metric("m.npz", metric.with_lengths(size * metric.lengths))
    status, out, err = run("inspect", "m.npz", "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["warnings"] == []


def test_inspect_refuses(run, here):
    (here / "bad.json").write_text("{}")
    assert run("inspect", "bad.json")[0] == 2


# surface


def test_surface_writes_the_metric_alone(run):
    status, out, _ = run("surface", "ellipsoid", "--axes", 3, 2, 1, "--vertices", 100, "-o", "m.npz")
    assert status == 0
    assert "int H dA 26.404857388" in out
    with np.load("m.npz") as archive:
        assert set(archive.files) == {"faces", "edges", "lengths"}
    assert read_metric("m.npz").triangulation.n_vertices == 100


def test_surface_writes_the_mesh(run):
    assert run("surface", "sphere", "--radius", 2, "--vertices", 50, "-o", "m.off")[0] == 0
    sphere = ("sphere", "--vertices", 12, "-o", "quiet.off")
    assert run("surface", "--quiet", *sphere) == run("surface", *sphere, "--quiet") == (0, "", "")
    points = np.array([line.split() for line in Path("m.off").read_text().splitlines()[2:52]], dtype=float)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 2, rtol=1e-14)


def test_surface_has_sheets_and_a_torus(run):
    status, out, _ = run("surface", "enneper", "--radius", 0.5, "--vertices", 60, "-o", "m.npz")
    assert status == 0
    assert "int k1^2 + k2^2 dA 5.02654824574, int H^2 dA 0" in out  # 8 pi / 5
    assert len(read_metric("m.npz", any_surface=True).triangulation.boundaries) == 1
    assert run("surface", "torus", "--vertices", 80, "-o", "t.npz")[0] == 0
    assert read_metric("t.npz", any_surface=True).triangulation.genus == 1


def test_triangulate_makes_discs_and_bands(run):
    assert run("triangulate", "--disc", -1, 1, "--vertices", 50, "-o", "d.npz")[0] == 0
    with np.load("d.npz") as archive:
        u, edges, lengths = (archive[name] for name in ("directions", "edges", "lengths"))
    r, phi = np.arccos(u[:, 2]), np.arctan2(u[:, 1], u[:, 0])
    assert r.max() == pytest.approx(1)
    x = np.stack([np.cosh(r), np.sinh(r) * np.cos(phi), np.sinh(r) * np.sin(phi)], axis=1)
    d = x[edges[:, 0]] - x[edges[:, 1]]
    exact = np.arccosh(1 + 0.5 * (d[:, 1] ** 2 + d[:, 2] ** 2 - d[:, 0] ** 2))
    np.testing.assert_allclose(lengths, exact, rtol=1e-6)
    horizon = ("--spacetime", "kerr", "--spin", 0.95, "--surface", "horizon", "--zone", 1.0, 2.0)
    assert run("triangulate", *horizon, "--vertices", 60, "-o", "b.npz")[0] == 0
    assert len(read_metric("b.npz", any_surface=True).triangulation.boundaries) == 2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--disc", 1, 4], "with curvature 1 the radius must be less than 3.14159, not 4"),
        (["--disc", 0, -1], "the radius must be positive, not -1"),
        (["--disc", 0, 1, "--zone", 0, 1], "--zone does not go with a --disc"),
        (["grid.npz", "--disc", 0, 1], "the input grid.npz does not go with a --disc"),
        (
            ["--disc", 0, 1, "--spacetime", "kerr", "--surface", "horizon"],
            "--disc does not go with a --spacet",
        ),
        (
            ["--spacetime", "kerr", "--surface", "horizon", "--zone", 2, 1],
            "two angles with 0 <= start < stop",
        ),
        ([], "which metric? Give a GRID, a --spacetime and a --surface, or a --disc"),
    ],
)
def test_triangulate_refuses(run, arguments, sentence):
    status, _, err = run("triangulate", *arguments, "--vertices", 50, "-o", "m.npz")
    assert status == 2
    assert sentence in err


def test_surface_draws_irregular_triangles(run):
    options = ("--axes", 3, 2, 1, "--vertices", 100)
    seeds = {
        "a.npz": ("--irregular", 1),
        "b.npz": ("--irregular", 1),
        "c.npz": ("--irregular", 2),
        "d.npz": (),
    }
    for name, seed in seeds.items():
        status, out, _ = run("surface", "ellipsoid", *options, *seed, "-o", name)
        assert status == 0
        assert "Ellipsoid(axes=(3.0, 2.0, 1.0)), 100 vertices" in out
    a, b, c, d = (np.sort(read_metric(name).lengths) for name in seeds)
    np.testing.assert_array_equal(a, b)
    assert not np.allclose(a, c, rtol=1e-3)
    assert a[-1] / a[0] > 1.3 * d[-1] / d[0]


def test_surface_lists_its_names(run):
    out = run("surface", "--list")[1]
    for words in ("ellipsoid", "drum", "kerr-horizon", "--spin", "ergosphere", "--epsilon"):
        assert words in out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "which surface? There are ellipsoid, drum"),
        (["blob", "--vertices", 100, "-o", "m.npz"], "invalid choice: 'blob'"),
        (["sphere", "-o", "m.npz"], "required: --vertices"),
        (["sphere", "--vertices", 100], "required: -o/--output"),
        (["sphere", "--vertices", 3, "-o", "m.npz"], "at least 12, not 3"),
        (["sphere", "--vertices", 1e3, "-o", "m.npz"], "'1000.0' is not a whole number"),
        (["sphere", "--radius", -1, "--vertices", 100, "-o", "m.npz"], "radius must be positive, not -1.0"),
        (["ellipsoid", "--axes", 1, 2, "--vertices", 100, "-o", "m.npz"], "--axes: expected 3 arguments"),
        (["sphere", "--vertices", 100, "-o", "m.xyz"], "not one of"),
        (["sphere", "--vertices", 100, "--irregular", -1, "-o", "m.npz"], "must be at least 0, not -1"),
        (["harmonic", "--degree", 2.5, "--vertices", 100, "-o", "m.npz"], "'2.5' is not a whole number"),
    ],
)
def test_surface_refuses(run, arguments, sentence):
    status, _, err = run("surface", *arguments)
    assert status == 2
    assert sentence in err


# The command itself


def test_no_command_and_a_wrong_one(run):
    assert "required: COMMAND" in run()[2]
    assert run("melt")[2] == "isoembed: error: unknown command 'melt' (see 'isoembed --help')\n"


def test_without_a_command_five_that_work_are_shown(run):
    status, out, _ = run()
    steps = [line.split()[1:] for line in out.splitlines()[1:]]
    assert (status, len(steps)) == (2, 5)
    for step in steps:
        assert run(*step)[0] == 0


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("embd", "embed"), ("unfld", "unfold"), ("horizons", "horizon"), ("Realizations", "realizations")],
)
def test_a_mistyped_command_is_answered_with_the_nearest_one(run, typed, meant):
    status, out, err = run(typed, "metric.json")
    assert (status, out) == (2, "")
    assert f"unknown command {typed!r}; did you mean {meant!r}?" in err


@pytest.mark.parametrize(
    ("typed", "answer"),
    [
        ("--tolerence=1e-9", "--tolerence; did you mean '--tolerance'?"),
        ("--ouput", "--ouput; did you mean '--output'?"),
        ("--image", "--image; did you mean '--picture'?"),
        ("--zzz", "--zzz (see"),
    ],
)
def test_a_mistyped_option_is_answered_with_the_nearest_one(run, typed, answer):
    status, _, err = run("embed", "metric.json", typed)
    assert status == 2
    assert f"unrecognized arguments: {answer}" in err


def test_the_package_runs_as_the_command():
    done = subprocess.run([sys.executable, "-m", "isoembed", "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"isoembed {isoembed.__version__}\n")
    wrong = subprocess.run([sys.executable, "-m", "isoembed"], capture_output=True, text=True)
    assert wrong.returncode == 2
    assert wrong.stderr.startswith("isoembed: error: ")


def test_help_everywhere(run):
    for arguments in ([], ["embed"], ["inspect"], ["surface"], ["surface", "drum"]):
        status, out, _ = run(*arguments, "--help")
        assert status == 0
        assert "usage: isoembed" in out
    assert run("--version") == (0, f"isoembed {isoembed.__version__}\n", "")


@pytest.mark.parametrize("option", ["--version", "--help"])
def test_start_imports_nothing_heavy(option):
    code = (
        "import sys; from isoembed.cli import main; assert main(sys.argv[1:]) == 0; "
        "heavy = {'numpy', 'scipy', 'rich', 'meshio', 'matplotlib'} & set(sys.modules); "
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code, option], check=True, capture_output=True)


def test_a_convex_surface_is_found_without_what_only_others_need(here):
    program = (
        "import sys; from isoembed.cli import main; assert main(sys.argv[1:]) == 0; "
        "print(*{'isoembed.gluing', 'isoembed.aim.anneal', 'isoembed.alexandrov.method', "
        "'isoembed.proof.certificate', 'isoembed.surface.rigidity', 'isoembed.plot.picture', "
        "'scipy.optimize', 'scipy.spatial', 'numpy.f2py.crackfortran', "
        "'numpy.testing._private'} & set(sys.modules))"
    )
    command = [sys.executable, "-c", program, "embed", "metric.json", "-o", "surface.ply", "--quiet"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == ""


def test_what_libraries_bring_is_not_looked_through_for_garbage(run):
    known = gc.get_freeze_count()
    run("inspect", "metric.json")  # in a process that is not the command's alone
    assert gc.get_freeze_count() == known
    program = (
        "import gc, sys; from isoembed.cli import main; sys.argv[1:] = ['inspect', 'metric.json']; "
        "assert main() == 0; print(gc.isenabled(), gc.get_freeze_count())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    enabled, count = done.stdout.split()[-2:]
    assert enabled == "True" and int(count) > 10_000


def test_a_reader_who_leaves_is_no_error(here):
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [*COMMAND, "inspect", "metric.json"], stdout=write, stderr=subprocess.PIPE, text=True
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_standard_output_is_said(here):
    with open("/dev/full", "w") as full:
        done = subprocess.run([*COMMAND, "surface", "--list"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert done.stderr == "isoembed: error: cannot write to standard output: No space left on device\n"


STOPPED = """
import os, signal, sys
from isoembed.cli import main
from isoembed.cli.advice import in_options
from isoembed.progress.stages import StageRecorder
show = StageRecorder.show
def shown(recorder, **said):
    show(recorder, **said)
    if recorder.iterations == 2:
        os.kill(os.getpid(), signal.SIGINT)
StageRecorder.show = shown
sys.exit(main())
"""


def test_control_c_in_a_real_process(here):
    write_metric("m.npz", PolyhedralMetric.from_mesh(*zoo.icosphere(2)))
    command = [sys.executable, "-c", STOPPED, "embed", "m.npz", "--method", "paper", "-o", "a.npz"]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 130
    assert done.stderr.startswith("isoembed: error: interrupted in the stage '")
    assert done.stderr.endswith("there is no checkpoint, as the method 'paper' kept nothing to go on from\n")
    assert sorted(os.listdir()) == ["m.npz", "metric.json"]


@pytest.mark.parametrize("quiet", [False, True])
def test_the_live_view_is_for_terminals(here, quiet):
    main_end, terminal = pty.openpty()
    command = [*COMMAND, "embed", "metric.json", "--method", "paper", "-o", "a.npz"]
    command += ["--quiet"] if quiet else []
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(command, stderr=terminal, stdout=subprocess.PIPE, env=environment) as process:
        os.close(terminal)
        shown = b""
        with suppress(OSError):  # the terminal is closed: that was all
            while chunk := os.read(main_end, 65536):  # as it comes: a terminal holds little
                shown += chunk
        os.close(main_end)
        assert process.wait() == 0
        assert process.stdout.read().startswith(b"converged: ") is not quiet
    assert (b"residual" in shown and b"pull back" in shown) is not quiet
    assert bool(shown) is not quiet


@pytest.mark.parametrize(
    ("text", "type_", "value"),
    [
        ("1e-3", float, 1e-3),
        ("7", int, 7),
        ("yes", bool, True),
        ("False", bool, False),
        ("none", int | None, None),
        ("5", int | None, 5),
        ("a b", str, "a b"),
    ],
)
def test_parameter_values(text, type_, value):
    assert parsed(text, type_) == value


def test_parameter_values_refused():
    with pytest.raises(ValueError, match="'maybe' is not true or false"):
        parsed("maybe", bool)


def test_an_output_that_is_given_twice_is_refused(tmp_path, capsys):
    assert main(["nets", "platonic", "-o", str(tmp_path / "a.obj"), "-o", str(tmp_path / "b.obj")]) == 2
    assert "argument -o: given twice" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
