"""Ctrl-C and SIGTERM: what the command leaves, what it says, and how it goes on."""

import os
import signal
import subprocess
import sys
import tempfile
import threading

import numpy as np
import pytest

import counting
import zoo
from isoembed import PolyhedralMetric, methods
from isoembed.cli import checkpoints, main
from isoembed.cli.signals import Interruption, handled
from isoembed.io import read_checkpoint, read_metric, write_metric
from isoembed.progress.stages import StageRecorder
from places import SUPPORT

STOP = ("--method", "counting", "--parameter", "stop=2")
SILENT = ("--parameter", "keeps=false")
LEFT = "a.ply.checkpoint.npz"
COMMAND = [
    sys.executable,
    "-c",
    f"import sys; sys.path.insert(0, {str(SUPPORT)!r}); from isoembed import methods; "
    f"methods.METHODS['counting'] = {counting.HOME!r}; from isoembed.cli import main; sys.exit(main())",
]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder with the metric of an icosphere in it, and a method that can be stopped."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(methods.METHODS, "counting", counting.HOME)
    write_metric("metric.npz", PolyhedralMetric.from_mesh(*zoo.icosphere(1)))
    return tmp_path


@pytest.fixture
def run(here, capfd):
    """Call the command in that folder; return its status and its complaint."""

    def call(*arguments):
        status = main(["embed", "metric.npz", *(str(argument) for argument in arguments)])
        _, err = capfd.readouterr()
        assert "Traceback" not in err
        assert err.count("\n") <= 1
        assert not [name for name in os.listdir() if name.startswith(".")]
        return status, err

    return call


def files():
    return sorted(set(os.listdir()) - {"metric.npz"})


def is_the_answer(path):
    np.testing.assert_allclose(read_metric(path).lengths, read_metric("metric.npz").lengths, rtol=1e-9)


# What is left, and going on


def test_it_leaves_a_checkpoint_beside_the_output_and_goes_on_from_it(run):
    status, err = run(*STOP, "-o", "a.ply", "--report", "r.json", "--quiet")
    assert status == 130
    assert err == (
        "isoembed: error: interrupted in the stage 'counting'; the checkpoint is in a.ply.checkpoint.npz: "
        "resume with the same command and --resume a.ply.checkpoint.npz\n"
    )
    assert files() == [LEFT]
    assert read_checkpoint(LEFT).arrays["left"] == 2
    assert run(*STOP, "-o", "a.ply", "--resume", LEFT) == (0, "")
    assert files() == ["a.ply", LEFT]
    is_the_answer("a.ply")


def test_sigterm_does_the_same_under_its_own_status(run):
    status, err = run(*STOP, "--parameter", f"number={int(signal.SIGTERM)}", "-o", "a.ply")
    assert status == 143
    assert "the checkpoint is in a.ply.checkpoint.npz" in err
    assert files() == [LEFT]


def test_the_checkpoint_may_have_a_name_of_its_own(run):
    status, err = run(*STOP, "-o", "a.ply", "--checkpoint", "my run.npz")
    assert status == 130
    assert "is in my run.npz: resume with the same command and --resume 'my run.npz'" in err
    assert files() == ["my run.npz"]
    assert run(*STOP, "--resume", "my run.npz", "--checkpoint", "my run.npz") == (0, "")


def test_without_an_output_there_is_a_checkpoint_only_on_demand(run):
    status, err = run(*STOP)
    assert status == 130
    assert err.endswith("; there is no checkpoint: neither --output nor --checkpoint names its file\n")
    assert files() == []
    assert run(*STOP, "--checkpoint", "c.npz")[0] == 130
    assert files() == ["c.npz"]


def test_without_an_output_the_resumed_checkpoint_is_replaced(run, monkeypatch):
    run(*STOP, "--checkpoint", "c.npz")
    keep = StageRecorder.keep

    def stop(recorder, **arrays):
        keep(recorder, **arrays)
        raise KeyboardInterrupt

    monkeypatch.setattr(StageRecorder, "keep", stop)
    status, err = run(*STOP, "--resume", "c.npz")
    assert (status, files()) == (130, ["c.npz"])
    assert "is in c.npz" in err
    assert read_checkpoint("c.npz").arrays["left"] == 1


def test_where_nothing_was_kept_it_says_so(run):
    status, err = run(*STOP, *SILENT, "-o", "a.ply")
    assert status == 130
    assert err.endswith("; there is no checkpoint, as the method 'counting' kept nothing to go on from\n")
    assert files() == []


@pytest.fixture
def temporary(tmp_path_factory, monkeypatch):
    """The folder for temporary files."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_a_checkpoint_that_cannot_be_written_goes_to_a_second_place(run, here, temporary):
    (here / LEFT).mkdir()
    status, err = run(*STOP, "-o", "a.ply")
    assert status == 130
    (folder,) = temporary.iterdir()
    second = folder / LEFT
    assert "; cannot write a.ply.checkpoint.npz: Is a directory; the checkpoint is in " in err
    assert f"is in {second}: resume with the same command and --resume {second}" in err
    assert os.listdir(LEFT) == []
    assert run(*STOP, "-o", "a.ply", "--resume", second) == (0, "")
    is_the_answer("a.ply")


def test_without_a_second_place_it_is_lost_and_said(run, here, monkeypatch):
    def refused(prefix):
        raise FileNotFoundError("no usable temporary directory")

    (here / LEFT).mkdir()
    monkeypatch.setattr(tempfile, "mkdtemp", refused)
    status, err = run(*STOP, "-o", "a.ply")
    assert status == 130
    assert err.endswith("cannot write a.ply.checkpoint.npz: Is a directory; there is no checkpoint\n")


# Every few minutes


@pytest.fixture
def always(monkeypatch):
    """Every new checkpoint is written; the paths of those that were, in order."""
    monkeypatch.setattr(checkpoints, "PERIOD", 0.0)
    written, write = [], checkpoints.write_atomically

    def seen(writers):
        write(writers)
        written.extend(str(path) for path in writers)

    monkeypatch.setattr(checkpoints, "write_atomically", seen)
    return written


def test_a_long_run_leaves_checkpoints_and_removes_them_in_the_end(run, always):
    assert run("--method", "counting", "-o", "a.ply") == (0, "")
    assert always == [LEFT] * 5
    assert files() == ["a.ply"]


def test_a_short_one_leaves_none(run, monkeypatch):
    monkeypatch.setattr(checkpoints, "write_atomically", None)
    assert run("--method", "counting", "-o", "a.ply") == (0, "")


def test_without_a_place_nothing_is_written(run, always, capfd):
    assert main(["embed", "metric.npz", "--method", "counting"]) == 0
    assert (always, files()) == ([], [])


def test_what_is_resumed_is_not_written_again_and_removed_if_it_was_replaced(run, always):
    run(*STOP, "--checkpoint", "c.npz")
    assert always == ["c.npz"] * 4  # of 4, 3 and 2 left; and the interruption's
    always.clear()
    assert run(*STOP, "--resume", "c.npz", "--quiet") == (0, "")
    assert (always, files()) == (["c.npz"] * 2, [])


def test_the_second_place_is_said_once_and_cleared(run, always, here, temporary):
    (here / LEFT).mkdir()
    status, err = run("--method", "counting", "-o", "a.ply")
    assert status == 0
    assert err.startswith(
        "isoembed: error: cannot write a.ply.checkpoint.npz: Is a directory; the checkpoint is in"
    )
    assert len(always) == 5
    assert list(temporary.iterdir()) == []


def test_if_the_answer_cannot_be_written_the_checkpoint_stays(run, always, monkeypatch):
    def full(path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("isoembed.cli.embedding_output.surface_writer", lambda path, surface: full)
    status, err = run("--method", "counting", "-o", "a.ply")
    assert status == 2
    assert "cannot write a.ply: No space left on device; the checkpoint is in a.ply.checkpoint.npz: " in err
    assert files() == [LEFT]


# What is refused


def test_that_of_another_computation_is_refused(run):
    run(*STOP, "-o", "a.ply")
    for options, words in (
        (("--method", "counting"), "written by another method: Counting(steps=5, stop=2, "),
        ((*STOP, "--tolerance", "1e-8"), "written with another tolerance: 1e-10, not 1e-08"),
    ):
        status, err = run(*options, "-o", "a.ply", "--resume", LEFT)
        assert status == 2
        assert words in err
    metric = read_metric("metric.npz")
    write_metric("metric.npz", metric.with_lengths(1.1 * metric.lengths))
    status, err = run(*STOP, "-o", "a.ply", "--resume", LEFT)
    assert status == 2
    assert "the checkpoint belongs to another metric" in err
    assert files() == [LEFT]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--resume", "no.npz"], "there is no file no.npz"),
        (["--resume", "metric.npz"], "INPUT and the checkpoint are the same file metric.npz"),
        (["--resume", "metric.npz", "-o", "a.ply"], "metric.npz is not a checkpoint: it has no 'key'"),
        (["--checkpoint", "a.ply"], "a.ply has the ending '.ply', not one of .npz"),
        (["--checkpoint", "no/a.npz"], "there is no folder"),
        (["--checkpoint", "a.npz", "-o", "./a.npz"], "--output and the checkpoint are the same file a.npz"),
        (["--checkpoint", "metric.npz"], "INPUT and the checkpoint are the same file"),
    ],
)
def test_refusals(run, options, sentence):
    status, err = run(*STOP, *options)
    assert status == 2
    assert sentence in err
    assert files() == []


# Signals


def test_signals_that_come_together_are_one(monkeypatch):
    monkeypatch.setattr("isoembed.cli.signals.SAME", 1e3)
    interruption = Interruption()
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with handled(interruption):
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)  # as timeout(1) does
        signal.raise_signal(signal.SIGINT)
        interruption._came -= 1e4
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert interruption.status == 130
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_what_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with handled(Interruption()):
            signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_thread_may_call_the_command(here, capfd):
    statuses = []
    thread = threading.Thread(target=lambda: statuses.append(main(["embed", "metric.npz", "-o", "a.ply"])))
    thread.start()
    thread.join(timeout=300)
    assert statuses == [0]


def test_another_signal_while_the_checkpoint_is_written_does_not_tear_it(run, monkeypatch):
    from isoembed.io import npz

    write = npz.write

    def disturbed(path, tables):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.raise_signal(number)
        write(path, tables)

    monkeypatch.setattr(npz, "write", disturbed)
    monkeypatch.setattr("isoembed.cli.signals.SAME", 0.0)
    assert run(*STOP, "-o", "a.ply")[0] == 130
    assert read_checkpoint(LEFT).arrays["left"] == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_in_a_real_process(here, number):
    command = [*COMMAND, "embed", "metric.npz", *STOP, "--parameter", "wait=true", "-o", "a.ply"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "kept\n"
        for _ in range(3):
            process.send_signal(number)
        out, err = process.communicate(timeout=300)
    assert (process.returncode, out) == (128 + number, "")
    assert err.startswith("isoembed: error: interrupted in the stage 'counting'; the checkpoint is in ")
    assert err.count("\n") == 1
    assert files() == [LEFT]
    done = subprocess.run([*command, "--resume", LEFT], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("converged: ")
    is_the_answer("a.ply")
