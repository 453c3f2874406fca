"""Methods of other packages: by their entry points they are names of the command and have its pages."""

import json

import pytest

import isoembed
import zoo
from isoembed.cli import main
from isoembed.io import write_metric
from isoembed.metric.polyhedral import PolyhedralMetric

PACKAGE = '''
"""A package that brings a method: the default one, and the surface is turned upside down."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import isoembed


@dataclass(frozen=True)
class Turned(isoembed.Method):
    """The default method, turned."""

    times: int
    label: str | None = None
    weight: int | float = 1
    path: Path = Path()

    name: ClassVar[str] = "turned"

    def run(self, metric, tolerance, log):
        found = isoembed.Aim().run(metric, tolerance, log)
        turned = found.vertices * ((-1) ** self.times, (-1) ** self.times, 1)
        return isoembed.Embedding(
            metric,
            turned,
            method=self.name,
            tolerance=tolerance,
            stages=log.stages,
            message=f"{self.label} {self.weight!r}",
        )


class Plain(isoembed.Method):
    """It has no parameters, and fails."""

    name = "plain"

    def run(self, metric, tolerance, log):
        vertices = isoembed.Aim().run(metric, tolerance, log).vertices
        found = isoembed.Embedding(metric, 2 * vertices, method=self.name, tolerance=tolerance)
        raise isoembed.NotEmbedded("it is plain", found)
'''


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Call ``isoembed embed m.npz`` where a package is installed that brings two methods and what is none."""
    metadata = tmp_path / "turning-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: turning\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[isoembed.methods]\nturned = turning:Turned\nplain = turning:Plain\nbroken = turning:missing\n"
    )
    (tmp_path / "turning.py").write_text(PACKAGE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    write_metric("m.npz", PolyhedralMetric.from_mesh(*zoo.icosphere(1)))

    def call(*arguments):
        status = main(["embed", "m.npz", *arguments])
        return status, *capfd.readouterr()

    return call


def test_a_method_of_another_package_does_what_ours_do(run):
    given = ("times=1", "label=x", "weight=2.5")
    status, out, err = run(
        *("--method", "turned"),
        *(word for one in given for word in ("--parameter", one)),
        *("-o", "a.npz", "--report", "r.json", "--html", "p.html"),
    )
    assert (status, err) == (0, "")
    assert out.startswith("converged: ")
    with open("r.json") as file:
        report = json.load(file)
    assert (report["method"], report["message"]) == ("turned", "x 2.5")
    with open("p.html") as file:
        assert "This method reached the surface in one step" in file.read()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["turned"], "the method 'turned' needs --parameter times=VALUE"),
        (["turned", "--parameter", "path=x"], "a parameter of type Path can only be set in Python"),
        (["turned", "--parameter", "times=1.5"], "'1.5' is not a whole number"),
        (["plain", "--parameter", "times=1"], "the method 'plain' has no parameter 'times'; it has none"),
        (["plain", "--best-fit"], "the method 'plain' has no best fit"),
        (["plain", "--effort", "2"], "the method 'plain' does not search"),
        (["plain", "--effort", "0"], "the method 'plain' does not search"),
        (["aim", "--effort", "-1"], "effort is -1.0, not a finite number of at least 0"),
        (["broken"], "the method 'broken' cannot be loaded from turning:missing: AttributeError"),
        (["magic"], "choose from aim, paper, alexandrov, sheet, broken, plain, turned"),
    ],
)
def test_what_it_does_not_take_is_one_line(run, arguments, said):
    status, out, err = run("--method", *arguments)
    assert (status, out) == (2, "")
    assert said in err or said in err.replace("'", "")  # some versions of argparse quote the names
    assert err.count("\n") == 1


def test_a_failure_is_in_the_unit_of_the_metric(run):
    assert run("--method", "plain")[::2] == (3, "isoembed: error: it is plain\n")
    metric = PolyhedralMetric.from_mesh(*zoo.icosphere(1)).scaled(2.0**40)
    with pytest.raises(isoembed.NotEmbedded, match="it is plain") as failure:
        isoembed.embed(metric, method="plain")
    attempt = failure.value.embedding
    assert attempt.metric is metric
    assert 0.5 < attempt.residual < 2  # twice the size
