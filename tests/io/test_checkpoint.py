"""An interrupted computation goes on from its checkpoint, which belongs to it alone."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import isoembed
import zoo
from counting import STAGE, Counting
from isoembed import Checkpoint, Interrupted, PolyhedralMetric
from isoembed.aim.paper import Paper
from isoembed.io import FileError, read_checkpoint, write_checkpoint

VERTICES, FACES = zoo.icosphere(1)


@pytest.fixture
def metric():
    return PolyhedralMetric.from_mesh(VERTICES, FACES)


def interrupted(metric, method, **options):
    with pytest.raises(Interrupted) as caught:
        isoembed.embed(metric, method=method, **options)
    return caught.value


def at_the_second(snapshot):
    """Do as Ctrl-C does, but from within."""
    if snapshot.iteration == 2:
        raise KeyboardInterrupt


# The verb


def test_it_goes_on_where_it_was(metric):
    whole = isoembed.embed(metric, method=Counting())
    stop = interrupted(metric, Counting(stop=2))
    assert stop.checkpoint.arrays["left"] == 2
    assert [(stage.name, stage.iterations) for stage in stop.stages] == [(STAGE, 3)]
    rest = isoembed.embed(metric, method=Counting(stop=2), resume=stop.checkpoint)
    assert (rest.vertices == whole.vertices).all()
    assert [stage.iterations for stage in rest.stages] == [2]


def test_an_interruption_is_never_swallowed_and_survives_pickling(metric):
    stop = interrupted(metric, Counting(stop=2))
    assert isinstance(stop, KeyboardInterrupt)
    assert not isinstance(stop, Exception)
    assert str(stop) == "interrupted in the stage 'counting'"
    assert type(stop.__cause__) is KeyboardInterrupt
    again = pickle.loads(pickle.dumps(stop))
    assert str(again) == str(stop)
    assert again.checkpoint.fingerprint == stop.checkpoint.fingerprint


def test_a_listener_can_interrupt(metric):
    stop = interrupted(metric, Counting(), progress=at_the_second)
    assert stop.checkpoint.arrays["left"] == 3


def test_every_snapshot_holds_the_checkpoint(metric, tmp_path):
    seen = []
    whole = isoembed.embed(metric, method=Counting(), progress=lambda p: seen.append(p.checkpoint))
    assert seen[0] is None
    assert [int(checkpoint.arrays["left"]) for checkpoint in seen[1:]] == [4, 3, 2, 1, 0]
    write_checkpoint(tmp_path / "c.npz", seen[2])
    rest = isoembed.embed(metric, method=Counting(), resume=read_checkpoint(tmp_path / "c.npz"))
    assert (rest.vertices == whole.vertices).all()
    assert [stage.iterations for stage in rest.stages] == [3]


def test_interrupted_again_it_goes_on_from_the_last(metric):
    first = interrupted(metric, Counting(), progress=at_the_second)
    second = interrupted(metric, Counting(), progress=at_the_second, resume=first.checkpoint)
    assert second.checkpoint.arrays["left"] == 1

    def at_once(snapshot):
        raise KeyboardInterrupt

    third = interrupted(metric, Counting(), progress=at_once, resume=second.checkpoint)
    assert [stage.name for stage in third.stages] == [STAGE]
    assert third.checkpoint.arrays is second.checkpoint.arrays
    assert isoembed.embed(metric, method=Counting(), resume=third.checkpoint).converged


@pytest.mark.parametrize("method", [Counting(stop=2, keeps=False), Paper()])
def test_where_nothing_is_kept_there_is_no_checkpoint(metric, method):
    stop = interrupted(metric, method, progress=at_the_second if method.name == "paper" else None)
    assert stop.checkpoint is None
    assert len(stop.stages) > 0


def test_an_interruption_before_the_first_stage(metric):
    class Early(Counting):
        def run(self, metric, tolerance, log):
            raise KeyboardInterrupt

    assert str(interrupted(metric, Early())) == "interrupted"


# Files


@pytest.fixture
def file(metric, tmp_path):
    path = tmp_path / "run.npz"
    write_checkpoint(path, interrupted(metric, Counting(stop=2)).checkpoint)
    return path


def test_a_file_holds_all_of_it(metric, file):
    kept = interrupted(metric, Counting(stop=2)).checkpoint
    read = read_checkpoint(file)
    assert (read.key, read.fingerprint) == (kept.key, kept.fingerprint)
    assert set(read.arrays) == set(kept.arrays)
    for name, array in kept.arrays.items():
        assert read.arrays[name].dtype == array.dtype
        assert (read.arrays[name] == array).all()
    assert isoembed.embed(metric, method=Counting(stop=2), resume=read).converged


def test_arrays_may_have_any_name(file):
    checkpoint = read_checkpoint(file)
    arrays = {name: np.array([k]) for k, name in enumerate(("file", "key", "kept/x", "state/x", "metric"))}
    write_checkpoint(file, replace(checkpoint, key="way", arrays=arrays, state=arrays))
    read = read_checkpoint(file)
    assert (read.key, read.arrays, read.state) == ("way", arrays, arrays)


def test_other_files_are_refused(file, metric):
    with pytest.raises(FileError, match=r"no\.npz"):
        read_checkpoint(file.with_name("no.npz"))
    with pytest.raises(FileError, match=r"has the ending '\.json', not one of \.npz"):
        read_checkpoint(file.with_name("run.json"))
    with pytest.raises(FileError, match=r"has the ending '\.ply', not one of \.npz"):
        write_checkpoint(file.with_name("run.ply"), read_checkpoint(file))
    isoembed.io.write_metric(file.with_name("metric.npz"), metric)
    with pytest.raises(FileError, match=r"metric\.npz is not a checkpoint: it has no 'key'"):
        read_checkpoint(file.with_name("metric.npz"))
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(FileError, match="is cut short"):
        read_checkpoint(file)


def test_one_of_an_earlier_version_is_refused_as_such(file):
    with np.load(file) as archive:
        tables = dict(archive)
    np.savez(file, stage=tables.pop("key"), **tables)
    with pytest.raises(FileError, match="is a checkpoint of an earlier isoembed"):
        read_checkpoint(file)


@pytest.mark.parametrize("value", ["1e-10", [1e-10], 1])
def test_a_tolerance_that_is_no_number_is_no_tolerance(file, value):
    with np.load(file) as archive:
        tables = dict(archive)
    np.savez(file, **(tables | {"tolerance": value}))
    with pytest.raises(FileError, match="is not a checkpoint: it has no 'tolerance'"):
        read_checkpoint(file)


def test_one_without_a_fingerprint_is_not_written(tmp_path):
    with pytest.raises(ValueError, match="does not say which computation"):
        write_checkpoint(tmp_path / "a.npz", Checkpoint(STAGE, {}))
    assert list(tmp_path.iterdir()) == []
