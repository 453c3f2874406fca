"""Threads: what runs, in which order, and what becomes of BLAS."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import ThreadpoolController, threadpool_info, threadpool_limits

import isoembed
from isoembed import PolyhedralMetric
from isoembed import threads as own_threads
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.linalg import tasks
from isoembed.threads import MAX_THREADS, TaskGraph, reserve_threads, run_ranges, thread_count


def blas_threads():
    """Threads of every BLAS."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_the_number_is_that_of_blas():
    for limit in (1, 3):
        with threadpool_limits(limit):
            assert thread_count() == limit


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 30), st.integers(1, 4), st.randoms(use_true_random=False))
def test_each_task_runs_once_and_after_those_that_it_depends_on(count, threads, random):
    before = [random.sample(range(t), random.randint(0, min(t, 3))) for t in range(count)]
    done = []

    def task(t):
        assert set(before[t]) <= set(done)
        done.append(t)

    with threadpool_limits(threads):
        TaskGraph(before).run(task)
    assert sorted(done) == list(range(count))


def test_tasks_run_at_once_and_start_no_more_threads():
    both = threading.Barrier(2, timeout=60)
    inside = []

    def task(t):
        both.wait()
        inside.append((thread_count(), blas_threads()))

    with threadpool_limits(2):
        TaskGraph([(), ()]).run(task)
        assert thread_count() == 2 and blas_threads() == {2}
    assert inside == [(2, {1})] * 2


def test_threads_without_a_task_take_part_in_the_runs_within_others():
    both = threading.Barrier(2, timeout=60)
    done = []

    def inner(t):
        both.wait()  # another thread runs the other one
        done.append(t)

    with threadpool_limits(2):
        TaskGraph([(), (0,)]).run(lambda t: TaskGraph([(), ()]).run(inner))
    assert sorted(done) == [0, 0, 1, 1]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(0, 9), min_size=1, max_size=9), st.integers(1, 4))
def test_runs_within_tasks_end_before_these(counts, threads):
    done = []

    def task(t):
        inside = []
        run_ranges(inside.extend, counts[t], 1)
        assert sorted(inside) == list(range(counts[t]))
        done.append(t)

    with threadpool_limits(threads):
        TaskGraph([() if t == 0 else (t // 2,) for t in range(len(counts))]).run(task)
    assert sorted(done) == list(range(len(counts)))


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_an_exception_within_a_task_ends_it_and_may_be_caught(threads):
    def task(t):
        with pytest.raises(ZeroDivisionError):
            TaskGraph([(), (0,), (0,)]).run(lambda k: 1 / k)

    with threadpool_limits(threads):
        TaskGraph([(), (), (0,)]).run(task)
        with pytest.raises(ZeroDivisionError):
            TaskGraph([(), ()]).run(lambda t: TaskGraph([(), (0,)]).run(lambda k: 1 / k))
    assert threading.active_count() == 1


@pytest.mark.parametrize("threads", [1, 3])
def test_an_exception_ends_the_run_and_is_raised(threads):
    begun = []

    def task(t):
        begun.append(t)
        raise ZeroDivisionError(t)

    with threadpool_limits(threads):
        with pytest.raises(ZeroDivisionError):
            TaskGraph([()] + [(t,) for t in range(9)]).run(task)
        assert thread_count() == threads and blas_threads() == {threads}
    assert begun == [0]


def test_an_interrupt_of_the_main_thread_ends_the_run_and_is_not_replaced():
    begun = threading.Event()
    done = []

    def task(t):
        if t == 0:
            begun.set()
            signal.raise_signal(signal.SIGINT)
            time.sleep(0.05)
            raise ZeroDivisionError
        done.append(t)

    with threadpool_limits(2):
        with pytest.raises(KeyboardInterrupt):
            TaskGraph([()] + [(0,)] * 5).run(task)
        assert thread_count() == 2 and blas_threads() == {2}
    assert begun.is_set() and not done
    assert threading.active_count() == 1


def test_threads_are_used_again_and_keep_nothing_alive():
    class Kept:
        pass

    both = threading.Barrier(2, timeout=60)
    threads = []
    with reserve_threads(2):
        for _ in range(2):
            kept = Kept()
            alive = weakref.ref(kept)

            def task(t, kept=kept):
                both.wait()
                threads.append(threading.get_ident())

            TaskGraph([(), ()]).run(task)
            del kept, task
            limit = time.monotonic() + 60  # a thread may be about to let go
            while alive() is not None and time.monotonic() < limit:
                time.sleep(0.001)
            assert alive() is None
    assert len(set(threads)) == 2 and threading.active_count() == 1


def test_a_failed_run_keeps_nothing_alive():
    class Kept:
        pass

    kept = Kept()
    alive = weakref.ref(kept)

    def task(t, kept=kept):
        raise ZeroDivisionError

    gc.collect()
    gc.disable()
    try:
        with threadpool_limits(2), pytest.raises(ZeroDivisionError):
            TaskGraph([(), ()]).run(task)
        del kept, task
        assert alive() is None
    finally:
        gc.enable()


def test_ranges_cover_everything_once():
    for count, fewest in ((0, 3), (1, 3), (100, 3), (1000, 7)):
        parts = []
        with threadpool_limits(3):
            run_ranges(parts.append, count, fewest)
        assert sorted(k for part in parts for k in part) == list(range(count))
        assert all(len(part) >= fewest for part in parts) or len(parts) == 1


def test_reserved_threads_are_taken_from_blas_and_given_back():
    with threadpool_limits(2):
        with reserve_threads(), reserve_threads():
            assert thread_count() == 2 and blas_threads() == {1}
        assert thread_count() == 2 and blas_threads() == {2}


@pytest.mark.parametrize(
    ("variables", "count"),
    [
        ({"OMP_NUM_THREADS": "3"}, 3),
        ({"OMP_NUM_THREADS": "2,4"}, 2),
        ({"OMP_NUM_THREADS": "3", "OPENBLAS_NUM_THREADS": "1"}, 3),
        ({"MKL_NUM_THREADS": "5"}, 5),
        ({"OMP_NUM_THREADS": "0", "BLIS_NUM_THREADS": "2"}, 2),
        ({"OMP_NUM_THREADS": "99"}, MAX_THREADS),
    ],
)
def test_where_blas_cannot_be_limited_variables_count(monkeypatch, variables, count):
    monkeypatch.setattr(own_threads, "_blas", lambda: ThreadpoolController().select(user_api="none of these"))
    for name in ("OMP", "OPENBLAS", "MKL", "BLIS"):
        monkeypatch.delenv(f"{name}_NUM_THREADS", raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert thread_count() == count
    with reserve_threads():
        assert thread_count() == count


def test_a_process_leaves_the_cores_to_these_threads():
    lines = "from isoembed.threads import reserve_threads_of_process as reserve, thread_count; reserve(); " \
        "import scipy.linalg, threadpoolctl; print(thread_count(), *{library['num_threads'] for library " \
        "in threadpoolctl.threadpool_info() if library['user_api'] == 'blas'})"  # fmt: skip
    inherited = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    for threads, expected in ("3", "3 1"), ("64", f"{MAX_THREADS} 1"), ("1", "1 1"), ("auto", None):
        run = subprocess.run(
            [sys.executable, "-c", lines],
            env=inherited | {"OMP_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        )
        cores = min(len(os.sched_getaffinity(0)), MAX_THREADS) if hasattr(os, "sched_getaffinity") else 1
        assert run.stdout.strip() == (expected or f"{cores} 1")


def test_other_threads_start_none():
    counts = []
    with threadpool_limits(2):
        other = threading.Thread(target=lambda: counts.append(thread_count()))
        other.start()
        other.join()
    assert counts == [1]


def test_surfaces_have_the_same_bits_for_any_number_of_threads(monkeypatch):
    monkeypatch.setattr(tasks, "SMALL", 0.0)
    metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 2500))
    found = []
    for count in (1, 2, 3):
        with threadpool_limits(count):
            found.append(isoembed.embed(metric, length_errors=0).vertices)
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])
