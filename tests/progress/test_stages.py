"""Stages: snapshots, and how long a computation will still take."""

from itertools import pairwise

import pytest

from isoembed.progress.stages import Log


class Clock:
    """Stands until it is told to go on."""

    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def seen():
    return []


@pytest.fixture
def log(clock, seen):
    return Log(seen.append, clock=clock)


def work(log, clock, name, seconds, reports=0):
    """Take so long for a stage, and say how far it is so many times."""
    with log.stage(name) as recorder:
        for k in range(reports):
            clock.now += seconds / reports
            recorder.show(done=(k + 1) / reports)
        if not reports:
            clock.now += seconds


# Progress


def test_the_level_stays_until_the_stage_ends(log, clock, seen):
    with log.stage("coarse") as recorder:
        recorder.show(level="100 vertices")
        clock.now += 1.5
        recorder.show(residual=0.5)
    with log.stage("fine"):
        pass
    assert [(p.stage, p.level, p.residual, p.seconds) for p in seen] == [
        ("coarse", None, None, 0.0),
        ("coarse", "100 vertices", None, 0.0),
        ("coarse", "100 vertices", 0.5, 1.5),
        ("fine", None, None, 1.5),
    ]
    (coarse, fine) = log.stages
    assert (coarse.seconds, fine.seconds) == (1.5, 0.0)


# The time left


def test_without_expectations_nothing_is_foreseen(log, clock, seen):
    work(log, clock, "walk", 10, reports=4)
    assert [p.remaining for p in seen] == [None] * 5


@pytest.mark.parametrize("pace", [0.25, 1.0, 40.0])
def test_it_is_exact_where_the_weights_are(log, clock, seen, pace):
    costs = {"start": 2.0, "walk": 10.0, "finish": 3.0}
    log.expect(costs)
    for name, seconds in costs.items():
        work(log, clock, name, pace * seconds, reports=4)
    left = [15 * pace - p.seconds for p in seen]
    assert [p.remaining for p in seen][1:] == pytest.approx(left[1:], abs=1e-9 * pace)
    assert seen[0].remaining is None  # there is nothing to go by
    assert seen[-1].remaining == pytest.approx(0, abs=1e-9 * pace)


def test_a_few_percent_have_to_be_done(log, clock, seen):
    log.expect({"start": 1.0, "walk": 99.0})
    work(log, clock, "start", 1.0)
    with log.stage("walk") as recorder:
        for percent in range(1, 5):
            clock.now += 0.99
            recorder.show(done=percent / 100)
    assert [p.remaining is None for p in seen] == [True, True, True, True, False, False]


def test_between_reports_it_counts_down_but_never_below_what_follows(log, clock):
    log.expect({"start": 1.0, "walk": 4.0, "finish": 5.0})
    work(log, clock, "start", 2.0)
    with log.stage("walk"):
        left = []
        for _ in range(6):
            left.append(log.time_left.remaining)
            clock.now += 2.0
    assert left == pytest.approx([18, 16, 14, 12, 10, 10])


def test_a_stage_trusts_its_own_pace_the_more_the_further_it_is(log, clock, seen):
    log.expect({"start": 10.0, "walk": 10.0})  # which takes 40
    work(log, clock, "start", 10.0)
    work(log, clock, "walk", 40.0, reports=4)
    # At half way: at its own pace 20 seconds are left, at the pace of all that is done 10.
    assert [p.remaining for p in seen[1:]] == pytest.approx(
        [10, 0.75 * (10 + 0.75 * 16), 15, 7.5 + 5 / 3.5, 0]
    )
    errors = [p.remaining - (50 - p.seconds) for p in seen[1:]]
    assert all(error < later <= 1e-9 for error, later in pairwise(errors))


def test_plans_change(log, clock, seen):
    log.expect({"leap": 2.0, "finish": 1.0})
    with log.stage("leap") as recorder:
        clock.now += 1.0
        recorder.show(done=0.5)  # and it was lost
    assert seen[-1].remaining == pytest.approx(2)
    log.expect({"walk": 20.0})
    work(log, clock, "walk", 20.0, reports=2)
    assert [p.remaining for p in seen[-3:]] == pytest.approx([21, 11, 1])
    work(log, clock, "finish", 1.0)
    assert seen[-1].remaining == pytest.approx(1)


def test_a_stage_of_a_method_within_a_method_comes_before_what_was_expected(log, clock, seen):
    log.expect({"way": 1.0, "inner": 4.0, "back": 5.0})
    work(log, clock, "way", 3.0)
    log.expect({"inner": 4.0})
    work(log, clock, "inner", 12.0)
    work(log, clock, "back", 15.0)
    assert [p.remaining for p in seen[1:]] == pytest.approx([27, 15])


def test_what_was_skipped_is_not_waited_for(log, clock, seen):
    log.expect({"way": 1.0, "inner": 4.0, "back": 5.0})
    work(log, clock, "way", 1.0)
    work(log, clock, "back", 5.0, reports=5)
    assert [p.remaining for p in seen[1:]] == pytest.approx([5, 4, 3, 2, 1, 0])


def test_a_stage_comes_again(log, clock, seen):
    log.expect({"walk": 4.0, "finish": 1.0})
    work(log, clock, "walk", 8.0)
    work(log, clock, "walk", 8.0)
    work(log, clock, "finish", 2.0)
    assert [p.remaining for p in seen[1:]] == pytest.approx([10, 2])


def test_an_unexpected_stage_has_no_end_in_sight(log, clock, seen):
    log.expect({"start": 1.0, "finish": 1.0})
    work(log, clock, "start", 1.0)
    work(log, clock, "detour", 5.0, reports=1)
    work(log, clock, "finish", 1.0)
    assert [p.remaining for p in seen] == [None, None, None, pytest.approx(1)]
