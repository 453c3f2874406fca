"""Runs of many files that are interrupted: by Ctrl-C, and by SIGKILL at any moment."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from isoembed import PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import write_metric
from strict_json import strict

pytestmark = pytest.mark.slow
COMMAND = [sys.executable, "-c", "import sys; from isoembed.cli import main; sys.exit(main())", "embed"]
N = 12


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = []
    for k in range(N):
        metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3.0, 2.0, 1.0 + 0.1 * k)), 200))
        names.append(f"m{k:02d}.npz")
        write_metric(names[-1], metric)
    return names


def begun(files, folder):
    arguments = [*COMMAND, *files, "--jobs", "2", "--chunk", "2", "--json", "-o", folder]
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def done(process):
    out, err = process.communicate(timeout=300)
    assert (process.returncode, err) == (0, "")
    return strict(out)


def results(folder):
    return {path.name for path in Path(folder, "results").glob("m*.npz")} if Path(folder).exists() else set()


def test_ctrl_c_keeps_what_is_done(files):
    process = begun(files, "out")
    while len(results("out")) < 3:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=300)
    assert (process.returncode, out) == (130, "")
    assert err.startswith("isoembed: interrupted: ") or err.startswith("isoembed: error: interrupted: ")
    assert f"of {N}" in err and err.rstrip().endswith("the same command continues with the rest")
    there = results("out")
    assert 3 <= len(there) < N
    assert done(begun(files, "out"))["computed"] == N - len(there)


def test_killed_at_any_moment_nothing_is_lost_or_done_twice(files):
    done(begun(files, "whole"))
    moments, computed = random.Random(1), 0
    for _ in range(6):
        before = results("out")
        process = begun(files, "out")
        time.sleep(moments.uniform(0.5, 6.0))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()  # until its processes have ended, which hold the pipes, too
        assert before <= results("out")
        computed += len(results("out") - before)
    report = done(begun(files, "out"))
    assert report["computed"] + computed == N
    assert Path("out/table.csv").read_bytes() == Path("whole/table.csv").read_bytes()
    assert {path.name for path in Path("out").glob("*.ply")} == {f"m{k:02d}.ply" for k in range(N)}
