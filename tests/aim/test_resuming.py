"""The methods go on from wherever they kept something, and arrive at the same surface."""

import os
import subprocess
import sys

import pytest

import isoembed
from isoembed import PolyhedralMetric
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.io import read_checkpoint, write_checkpoint, write_metric
from isoembed.progress.stages import StageRecorder

STOPPED = """
import os, signal, sys
from isoembed.cli import main
from isoembed.progress.stages import StageRecorder
keep, stage = StageRecorder.keep, sys.argv.pop()
def kept(recorder, **arrays):
    keep(recorder, **arrays)
    if recorder.name == stage:
        os.kill(os.getpid(), signal.SIGINT)
StageRecorder.keep = kept
sys.exit(main())
"""


def kept_checkpoints(metric, method, monkeypatch):
    """Every checkpoint of a run, as an interruption right there hands it out; and the surface."""
    keep, count = StageRecorder.keep, 0

    def counted(recorder, **arrays):
        nonlocal count
        keep(recorder, **arrays)
        count += 1
        if count == stop:
            raise KeyboardInterrupt

    found, stop = [], 0
    monkeypatch.setattr(StageRecorder, "keep", counted)
    while True:
        count, stop = 0, stop + 1
        try:
            surface = isoembed.embed(metric, method=method)
        except isoembed.Interrupted as interrupted:
            found.append(interrupted.checkpoint)
        else:
            monkeypatch.setattr(StageRecorder, "keep", keep)
            return found, surface


@pytest.mark.slow
@pytest.mark.parametrize("body", [Ellipsoid((3, 2, 1)), Ergosphere(epsilon=0.3)], ids=["convex", "K < 0"])
def test_from_every_checkpoint_the_same_surface_comes(body, monkeypatch, tmp_path):
    mesh = triangulate(body, 400)
    metric = PolyhedralMetric.from_mesh(*mesh)
    found, whole = kept_checkpoints(metric, "aim", monkeypatch)
    assert found
    for checkpoint in found:
        write_checkpoint(tmp_path / "c.npz", checkpoint)
        begun = []
        rest = isoembed.embed(
            metric,
            resume=read_checkpoint(tmp_path / "c.npz"),
            progress=lambda p, begun=begun: begun.append(p.stage),
        )
        assert whole.distance(rest) < 1e-9
        assert len(dict.fromkeys(begun)) <= len(whole.stages)


def test_control_c_leaves_a_checkpoint_in_a_real_process(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_metric("m.npz", PolyhedralMetric.from_mesh(*triangulate(Drum(), 3000)))
    arguments = ["embed", "m.npz", "-o", "a.npz"]
    stage = "polytopes"  # the stage that keeps
    done = subprocess.run([sys.executable, "-c", STOPPED, *arguments, stage], capture_output=True, text=True)
    assert done.returncode == 130
    assert f"the stage {stage!r}; the checkpoint is in a.npz.checkpoint.npz" in done.stderr
    assert sorted(os.listdir()) == ["a.npz.checkpoint.npz", "m.npz"]
    again = "import sys; from isoembed.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", again, *arguments, "--resume", "a.npz.checkpoint.npz"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
