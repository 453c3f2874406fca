"""Runs of tasks: chunks, what is there already, failures, lost processes."""

import itertools
import os
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

import pytest

from isoembed.errors import InvalidParameter
from isoembed.runs import Shard, Store, Wish, Workers, run
from tasks import Square


@pytest.fixture
def store(tmp_path):
    return Store.made(tmp_path / "run")


@pytest.fixture
def calls(tmp_path):
    (tmp_path / "calls").mkdir()
    return tmp_path / "calls"


def squares(calls, n, **fails):
    return [Square(k, calls, fails.get(f"n{k}", "")) for k in range(n)]


def counts(calls):
    return {path.name: len(path.read_text()) for path in calls.iterdir()}


def totals(outcomes):
    return {outcome.result.label: outcome.result.report.get("total") for outcome in outcomes}


def in_chunks(n, size):
    """The totals, each chunk summed for itself."""
    return {
        f"square{k}": sum_of
        for first in range(0, n, size)
        for k, sum_of in zip(
            range(first, min(first + size, n)),
            itertools.accumulate(float(k) ** 2 / 3.0 for k in range(first, min(first + size, n))),
            strict=True,
        )
    }


@pytest.mark.parametrize("size", [1, 3, 100])
def test_neighbors_start_from_each_other_in_a_chunk(calls, size):
    assert totals(run(squares(calls, 7), chunk=size)) == in_chunks(7, size)


def test_tasks_are_taken_as_they_are_needed():
    def endless():
        yield from map(Square, itertools.count())

    first = list(itertools.islice(run(endless(), chunk=2), 5))
    assert [outcome.result.report["square"] for outcome in first] == [0.0, 1.0, 4.0, 9.0, 16.0]


def test_what_is_there_is_not_done_again_and_comes_to_the_same(calls, store):
    tasks = squares(calls, 7)
    whole = totals(run(tasks, chunk=4))
    list(itertools.islice(run(tasks, store=store, chunk=4), 6))
    outcomes = list(run(tasks, store=store, chunk=4))
    assert [outcome.computed for outcome in outcomes] == [False] * 6 + [True]
    assert totals(outcomes) == whole
    assert counts(calls) == {f"square{k}": 2 for k in range(7)}
    store.path("square2", next(store.folder.glob("results/square2.*")).name.split(".")[1]).write_bytes(b"cut")
    assert [o.result.label for o in run(tasks, store=store, chunk=4) if o.computed] == ["square2"]


def test_other_options_are_other_results(calls, store):
    list(run([Square(2, calls)], store=store))
    [outcome] = run([Square(2, calls, options="finer")], store=store)
    assert outcome.computed
    assert len(list(store.folder.glob("results/*"))) == 2 and len(list(store)) == 1
    [outcome] = run([Square(2, calls)], store=store)
    assert not outcome.computed


def test_failures_are_kept_and_tried_again_on_request(calls, store):
    tasks = squares(calls, 6, n1="no answer", n2="memory", n3="mistake", n4="unreadable")
    outcomes = list(run(tasks, store=store))
    assert [outcome.result.status for outcome in outcomes] == [
        *("done", "none", "failed", "failed", "refused", "done")
    ]
    messages = [outcome.result.message for outcome in outcomes]
    assert messages[1:5] == [
        "1 has no square",
        "not enough memory",
        "ZeroDivisionError: a mistake",
        "there is no file square4",
    ]
    assert "in compute" in outcomes[3].result.report["traceback"]
    assert [outcome.result.report["number"] for outcome in outcomes[2:5]] == [2, 3, 4]
    assert outcomes[5].result.report["total"] == 25.0 / 3.0  # from square0, over what failed
    assert not any(outcome.computed for outcome in run(tasks, store=store))
    again = list(run(tasks, store=store, wish=Wish(retry=True)))
    assert [outcome.computed for outcome in again] == [False, True, True, True, True, False]
    assert all(outcome.computed for outcome in run(tasks, store=store, wish=Wish(again=True)))


def test_shards_are_parts_of_the_whole(calls, store):
    tasks = squares(calls, 11)
    parts = [totals(run(tasks, store=store, chunk=2, shard=Shard(k, 3))) for k in (1, 2, 3)]
    assert [len(part) for part in parts] == [4, 4, 3]
    assert parts[0] | parts[1] | parts[2] == in_chunks(11, 2)
    assert set(counts(calls).values()) == {1}


@pytest.mark.parametrize(("number", "of"), [(0, 3), (4, 3), (1, 0)])
def test_no_such_shard(number, of):
    with pytest.raises(InvalidParameter, match=f"^shard number must be from 1 to {of}, not {number}"):
        Shard(number, of)


def test_no_such_chunk():
    with pytest.raises(InvalidParameter, match=r"^chunk must be at least 1, not 0$"):
        next(run([], chunk=0))


def test_any_executor_does(calls, store):
    with ThreadPoolExecutor(2) as executor:
        outcomes = list(run(squares(calls, 9), store=store, executor=executor, chunk=2))
    assert totals(outcomes) == in_chunks(9, 2)
    assert set(counts(calls).values()) == {1}


def test_a_digest_may_fail_as_well(calls, store):
    tasks = squares(calls, 4, n1="no digest", n2="digest in memory")
    outcomes = list(run(tasks, store=store))
    assert [outcome.result.status for outcome in outcomes] == ["done", "refused", "failed", "done"]
    assert not any(outcome.computed for outcome in run(tasks, store=store))
    with Lost(9) as executor:
        lost = {o.result.label: o.result for o in run(tasks, store=Store.made(calls), executor=executor)}
    assert lost["square1"].message == "the machine is gone"


def test_a_cluster_that_is_gone_is_one_sentence(calls, store):
    class Gone(Lost):
        def submit(self, function, tasks, *others):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    with (
        Gone(0) as executor,
        pytest.raises(InvalidParameter, match=r"^the executor canceled the running"),
    ):
        list(run(squares(calls, 2), store=store, executor=executor))


def test_what_cannot_be_kept_is_said(calls, store, monkeypatch):
    monkeypatch.setattr(Store, "path", lambda self, label, key: self.folder / "gone" / label)
    [outcome] = run([Square(3)], store=store)
    assert outcome.result.answered and outcome.complaint.startswith("cannot write")


class Lost(ThreadPoolExecutor):
    """An executor that loses tasks, as a cluster does whose machines go away."""

    def __init__(self, often):
        super().__init__(1)
        self.often, self.sizes = often, []

    def submit(self, function, tasks, *others):
        self.sizes.append(len(tasks))
        if any(self.sizes.count(len(tasks)) <= self.often and task.number == 1 for task in tasks):
            future = Future()
            future.set_exception(RuntimeError("the machine is gone"))
            return future
        return super().submit(function, tasks, *others)


@pytest.mark.parametrize(("often", "sizes"), [(1, [4, 4]), (2, [4, 4, 1, 1, 1, 1]), (9, [4, 4, 1, 1, 1, 1])])
def test_lost_chunks_are_done_again_and_then_task_by_task(calls, store, often, sizes):
    with Lost(often) as executor:
        outcomes = {o.result.label: o for o in run(squares(calls, 4), store=store, executor=executor)}
        assert executor.sizes == sizes
    lost = outcomes["square1"].result
    assert lost.message == ("the machine is gone" if often > 1 else "")
    assert sum(outcome.result.answered for outcome in outcomes.values()) == (3 if often > 1 else 4)
    assert not any(outcome.computed for outcome in run(squares(calls, 4), store=store))


def test_a_killed_process_takes_nothing_with_it(calls, store):
    """One dies once, one whenever it is tried: only that has no result, and says why."""
    tasks = squares(calls, 9, n1="killed once", n4="killed")
    with Workers(2) as executor:
        outcomes = {o.result.label: o for o in run(tasks, store=store, executor=executor, chunk=3)}
    assert len(outcomes) == 9
    [lost] = [outcome.result for outcome in outcomes.values() if not outcome.result.answered]
    assert lost.label == "square4" and lost.status == "failed" and lost.report["number"] == 4
    assert lost.message.startswith("the system ended its process")
    first = {
        label: total for label, total in in_chunks(9, 3).items() if label in ("square0", "square1", "square2")
    }
    assert {label: outcomes[label].result.report["total"] for label in first} == first
    assert counts(calls)["square0"] == 1 and counts(calls)["square4"] == 3
    assert (
        len({outcome.result.report.get("process") for outcome in outcomes.values()} - {None, os.getpid()})
        >= 2
    )


def test_what_cannot_be_sent_to_a_process_is_said():
    task = partial(Square, 1)
    with Workers(1) as executor:
        [outcome] = run([Unsendable(task)], executor=executor)
    assert outcome.result.status == "failed" and "pickle" in outcome.result.message


class Unsendable:
    """A task with a function in it."""

    label, facts = "unsendable", {}

    def __init__(self, task):
        self._task = lambda: task

    def digest(self):
        return "unsendable"
