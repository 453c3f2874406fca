"""A run that is killed: what is there afterwards is whole, and another run goes on from it."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import isoembed
from isoembed import PolyhedralMetric
from isoembed.gallery import Drum, triangulate
from isoembed.io import read_checkpoint, write_metric
from strict_json import strict

MOMENTS = 20

KILLED = """
import os, shutil, signal, sys, time
from isoembed.cli import checkpoints, main
checkpoints.PERIOD = 0.0

def run(folder):
    os.mkdir(folder)
    shutil.copy("metric.npz", folder)
    os.chdir(folder)
    return main(["embed", "metric.npz", "-o", "a.npz", "--report", "r.json", "--quiet"])

def child(folder):
    process = os.fork()
    if not process:
        os._exit(run(folder))
    return process

assert os.waitpid(child("warm"), 0)[1] == 0
begun = time.perf_counter()
assert os.waitpid(child("whole"), 0)[1] == 0
seconds = time.perf_counter() - begun
for k in range({moments}):
    process = child(str(k))
    time.sleep(seconds * (k + 0.5) / {moments})
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_killed_at_any_moment(tmp_path):
    metric = PolyhedralMetric.from_mesh(*triangulate(Drum(), 700))
    write_metric(tmp_path / "metric.npz", metric)
    script = KILLED.replace("{moments}", str(MOMENTS))
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, timeout=600)
    whole = np.load(tmp_path / "whole" / "a.npz")["vertices"]
    assert sorted(os.listdir(tmp_path / "whole")) == ["a.npz", "metric.npz", "r.json"]
    left = set()
    for folder in (tmp_path / str(k) for k in range(MOMENTS)):
        names = {name for name in os.listdir(folder) if not name.startswith(".isoembed-")}
        assert names <= {"metric.npz", "a.npz", "r.json", "a.npz.checkpoint.npz"}
        assert (folder / "metric.npz").read_bytes() == (tmp_path / "metric.npz").read_bytes()
        if "a.npz" in names:
            assert (np.load(folder / "a.npz")["vertices"] == whole).all()
        if "r.json" in names:
            assert strict(Path(folder / "r.json").read_text())["status"] == "converged"
        if "a.npz.checkpoint.npz" in names:
            checkpoint = read_checkpoint(folder / "a.npz.checkpoint.npz")
            if checkpoint.key not in left:
                again = isoembed.embed(metric, resume=checkpoint).vertices
                assert (again == whole).all()
            left.add(checkpoint.key)
    assert left
