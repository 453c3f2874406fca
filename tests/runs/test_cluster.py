"""A real cluster of Dask on the loopback: a scheduler, two workers, one of which is killed in the middle."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from isoembed.errors import InvalidParameter
from isoembed.runs import Store, run
from isoembed.runs.cluster import dask_workers
from tasks import Slow

pytest.importorskip("distributed")
pytestmark = pytest.mark.slow
SUPPORT = Path(__file__).parents[1] / "support"
LOOPBACK = ["--host", "127.0.0.1", "--no-dashboard"]


@pytest.fixture
def begin(tmp_path):
    """Begin ``dask scheduler`` or ``dask worker``; both end with the test."""
    begun = []

    def begin(*arguments):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(SUPPORT), *sys.path])}
        command = [sys.executable, "-m", "dask", *map(str, arguments)]
        with (tmp_path / f"log{len(begun)}").open("w") as log:
            begun.append(subprocess.Popen(command, stdout=log, stderr=log, env=environment, cwd=tmp_path))
        return begun[-1]

    yield begin
    for process in begun:
        process.kill()
        process.wait()


@pytest.fixture
def scheduler(tmp_path, begin):
    """The address of a scheduler with two workers, and these."""
    file = tmp_path / "scheduler.json"
    begin("scheduler", *LOOPBACK, "--port", 0, "--scheduler-file", file)
    wait_for(file.exists)
    workers = [
        begin("worker", *LOOPBACK, "--nthreads", 1, "--no-nanny", "--scheduler-file", file) for _ in range(2)
    ]
    return json.loads(file.read_text())["address"], workers


def wait_for(condition, seconds=300.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_worker_that_is_killed_changes_nothing(tmp_path, scheduler):
    address, workers = scheduler
    tasks = [Slow(k, seconds=0.1) for k in range(40)]
    alone = {o.result.label: o.result.report["total"] for o in run(tasks, chunk=4)}
    store, found = Store.made(tmp_path / "run"), {}
    with dask_workers(address) as executor:
        for outcome in run(tasks, store=store, executor=executor, chunk=4):
            found[outcome.result.label] = outcome.result
            if len(found) == 8:
                workers[0].send_signal(signal.SIGKILL)
    assert {label: result.report["total"] for label, result in found.items()} == alone
    assert {result.label: result.report["total"] for result in store} == alone
    assert {result.report["process"] for result in found.values()} <= {worker.pid for worker in workers}


@pytest.mark.parametrize("address", ["foo", "", "http://x:1", "tcp://x"])
def test_what_is_no_address(address):
    with pytest.raises(InvalidParameter, match="is not a scheduler address"), dask_workers(address):
        pass


def test_nobody_answers(monkeypatch):
    monkeypatch.setattr("isoembed.runs.cluster.PATIENCE", 0.5)
    with (
        pytest.raises(InvalidParameter, match=r"^there is no scheduler of Dask at tcp://127\.0\.0\.1:9: "),
        dask_workers("tcp://127.0.0.1:9"),
    ):
        pass
