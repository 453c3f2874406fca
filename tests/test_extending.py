"""The package of the page on extending: a method and two formats from outside, in Python and the command."""

import importlib.util
import json
import os
import subprocess
import sys
import tomllib

import numpy as np
import pytest

import isoembed
from isoembed import Interrupted, InvalidParameter, NotEmbedded, PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import FileError, InputFile
from page_blocks import blocks
from pages import DOCS

DRIVER = """
import json, sys
from isoembed.cli import main
commands, code = json.load(sys.stdin)
statuses = [main(command) for command in commands]
exec(code)
print(statuses)
"""


@pytest.fixture(scope="module")
def texts():
    """The blocks of the page by their languages."""
    found = {}
    for language, _, text in blocks(DOCS / "extending.md"):
        found.setdefault(language, []).append(text)
    return found


@pytest.fixture(scope="module")
def folder(texts, tmp_path_factory):
    """A folder in which the package is installed."""
    folder = tmp_path_factory.mktemp("installed")
    (folder / "shells.py").write_text(texts["python"][0])
    project = tomllib.loads(texts["toml"][0])["project"]
    about = folder / f"{project['name']}-{project['version']}.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 1.0\n")
    lines = []
    for group, entries in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())]
    (about / "entry_points.txt").write_text("\n".join(lines))
    return folder


@pytest.fixture(scope="module")
def shells(folder):
    """The module, imported by its path: nothing is registered in this process."""
    spec = importlib.util.spec_from_file_location("shells", folder / "shells.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["shells"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["shells"]


@pytest.fixture(scope="module")
def metric():
    return PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((1.5, 1.2, 1.0)), 80)[:2])


def test_the_command_and_python_know_what_is_installed(texts, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(texts["python"][1], {})
    (tmp_path / "bad.shell").write_text("# shell at time one\n")
    (tmp_path / "bad.tri").write_text("4 4\n0 0 0\n")
    good = [line.split()[1:] for line in texts["sh"][0].splitlines()]
    bad = [
        ["embed", "lengths.json", "--method", "isomap", "--parameter", "steps=1"],
        ["embed", "lengths.json", "--method", "isomap", "--best-fit"],
        ["horizon", "bad.shell"],
        ["embed", "bad.tri"],
    ]
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", DRIVER],
        input=json.dumps([good + bad, texts["py"][0]]),
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[0, 0, 0, 0, 3, 2, 2, 2]", done.stderr
    missed, no_best_fit, shell, tri = done.stderr.splitlines()[-4:]
    assert "miss the tolerance" in missed
    assert "'isomap' has no best fit" in no_best_fit
    assert shell.endswith("bad.shell is not a shell: could not convert string to float: 'one'")
    assert "bad.tri is not a .tri file: cannot reshape array" in tri
    page = (tmp_path / "ellipsoid.html").read_text()
    assert "isomap" in page and "range" in page
    first = (tmp_path / "ellipsoid.tri").read_text().splitlines()[0]
    assert first == "100 196"


def test_it_is_embedded_by_a_method_that_is_passed(shells, metric):
    surface = isoembed.embed(metric, method=shells.Isomap())
    assert surface.converged
    scaling, newton = surface.stages
    assert (scaling.name, newton.name) == ("scaling", "Newton")
    assert newton.iterations > 2
    with pytest.raises(NotEmbedded, match="miss the tolerance"):
        isoembed.embed(metric, method=shells.Isomap(steps=1))


def test_what_a_method_returns_is_checked(metric):
    class Points(isoembed.Method):
        name = "points"

        def run(self, metric, tolerance, log):
            return np.zeros((6, 3))

    with pytest.raises(InvalidParameter, match="the method 'points' returned ndarray, not an Embedding"):
        isoembed.embed(metric, method=Points())


@pytest.mark.parametrize(
    ("size", "looser", "named"),
    [(1.0, 1e12, r"the tolerance 100, not the given 1e-10"), (100.0, 1.0, "of a different metric")],
)
def test_a_method_embeds_the_metric_and_to_the_tolerance_it_is_given(metric, size, looser, named):
    class Other(isoembed.Method):
        name = "other"

        def run(self, metric, tolerance, log):
            points = np.random.default_rng(0).standard_normal((metric.triangulation.n_vertices, 3))
            return isoembed.Embedding(
                metric.scaled(size), points, method="other", tolerance=looser * tolerance
            )

    with pytest.raises(InvalidParameter, match=f"the method 'other' returned an Embedding .*{named}"):
        isoembed.embed(metric, method=Other())


def test_a_method_has_a_name(metric):
    class Nameless(isoembed.Method):
        def run(self, metric, tolerance, log):
            raise AssertionError

    with pytest.raises(InvalidParameter, match="the class Nameless has no name"):
        isoembed.embed(metric, method=Nameless())


def test_it_goes_on_from_a_checkpoint(shells, metric):
    def stop(snapshot):
        if snapshot.iteration == 2:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        isoembed.embed(metric, method=shells.Isomap(), progress=stop)
    rest = isoembed.embed(metric, method=shells.Isomap(), resume=caught.value.checkpoint)
    whole = isoembed.embed(metric, method=shells.Isomap())
    assert [stage.name for stage in rest.stages] == ["Newton"]
    np.testing.assert_allclose(rest.vertices, whole.vertices, atol=1e-12)


def test_its_files_are_read_without_being_installed(shells, tmp_path):
    vertices, faces = triangulate(Ellipsoid((1.5, 1.2, 1.0)), 80)[:2]
    shells.TRI.write(tmp_path / "a.tri", {"vertices": vertices, "faces": faces})
    np.savetxt(tmp_path / "a.shell", vertices, header="shell at time 0.5")
    with InputFile(tmp_path / "a.tri") as file:
        tables = shells.TRI.read(file)
        assert not shells.SHELL.recognizes(file)
    np.testing.assert_array_equal(tables["vertices"], vertices)
    np.testing.assert_array_equal(tables["faces"], faces)
    with InputFile(tmp_path / "a.shell") as file:
        assert shells.SHELL.recognizes(file)
        shape = shells.SHELL.read(file)
    assert shape.time == 0.5 and len(shape.points) == 80
    (tmp_path / "flat.shell").write_text("# shell at time 1\n" + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n")
    with InputFile(tmp_path / "flat.shell") as file, pytest.raises(FileError, match="lie in a plane"):
        shells.SHELL.read(file)
