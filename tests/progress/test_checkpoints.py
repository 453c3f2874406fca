"""Checkpoints: what is kept, what a run goes on from, and the work that counts."""

import numpy as np

from isoembed.progress.checkpoints import Checkpoint, Checkpoints
from isoembed.progress.stages import Log


def test_the_last_that_was_kept_is_the_checkpoint():
    checkpoints, x, known = Checkpoints(), np.zeros(3), np.ones(2)
    assert checkpoints.last is None
    checkpoints.keep(x=np.ones(3))
    assert (checkpoints.last.key, dict(checkpoints.last.state)) == ("", {})
    checkpoints.begin("way", {"known": known})
    checkpoints.keep(x=x, step=2)
    last = checkpoints.last
    assert last.key == "way"
    assert last.arrays["x"] is x  # not copied
    assert last.state["known"] is known
    assert set(last.arrays) == {"x", "step"}
    assert last.arrays["step"].shape == ()


def test_what_is_resumed_is_the_last_until_more_is_kept():
    resumed = Checkpoint("way", {"x": np.arange(3)})
    checkpoints = Checkpoints(resumed)
    assert checkpoints.last is resumed
    checkpoints.begin("way", {})
    checkpoints.keep(y=np.arange(4))
    assert set(checkpoints.last.arrays) == {"y"}
    assert checkpoints.resume() is resumed.arrays


def test_only_the_strategy_that_kept_it_resumes_it_and_once():
    resumed = Checkpoint("way", {"x": np.arange(3)}, factorizations=7)
    checkpoints = Checkpoints(resumed)
    assert checkpoints.resume() is None
    checkpoints.begin("other", {})
    assert checkpoints.resume() is None
    checkpoints.begin("way", {})
    assert checkpoints.resume(x=np.arange(4)) is None
    assert checkpoints.resume(z=np.arange(3)) is None
    assert checkpoints.work.factorizations == 0
    assert checkpoints.resume(x=np.arange(3)) is resumed.arrays
    assert checkpoints.work.factorizations == 7
    assert checkpoints.resume() is None
    assert Checkpoints(Checkpoint("", {})).resume() is None  # nothing is kept but the state


def test_factorizations_are_counted_once_however_often_a_run_is_interrupted():
    def run(log):
        """Three stages; the second keeps what it has, and goes on from it."""
        with log.stage("first") as recorder:
            recorder.factorizations += 3
        kept = log.checkpoints.resume()
        with log.stage("second") as recorder:
            for step in range(int(kept["step"]) + 1 if kept else 0, 4):
                recorder.factorizations += 10
                recorder.keep(step=step)
                yield log
        with log.stage("third") as recorder:
            recorder.factorizations += 1

    whole = Log()
    assert len(list(run(whole))) == 4
    assert whole.work.factorizations == 44
    assert [stage.factorizations for stage in whole.stages] == [3, 40, 1]
    checkpoint = None
    for _ in range(4):
        checkpoint = next(run(Log(checkpoints=Checkpoints(checkpoint)))).checkpoints.last
    assert (int(checkpoint.arrays["step"]), checkpoint.factorizations) == (3, 43)
    rest = Log(checkpoints=Checkpoints(checkpoint))
    assert list(run(rest)) == []
    assert rest.work.factorizations == 44
    assert [stage.factorizations for stage in rest.stages] == [3, 0, 1]
