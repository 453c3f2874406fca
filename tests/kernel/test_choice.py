"""A function is compiled when that pays, and does the same before and after."""

import os
import pickle
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from isoembed.kernel import choice, kernel
from isoembed.kernel.worth import INTERPRETING, LARGE_SIZE, Account


@kernel
def root(a, x):
    return a[0] / x, np.sqrt(a[1]), a.size


def twice(a):
    return a * 2


def is_compiled(function):
    return "dispatcher" in vars(function) and bool(function.dispatcher.signatures)


@pytest.fixture
def clock(monkeypatch):
    """A clock that the calls of kernels put forward, by so many seconds; to compile one takes 1."""
    time = [0.0]
    monkeypatch.setattr(choice, "WHEN", "")
    monkeypatch.setattr(choice, "_clock", lambda: time[0])
    monkeypatch.setattr(choice, "_ALL", Account())
    monkeypatch.setattr(choice, "_interpreted", [])
    monkeypatch.setattr(choice.Kernel, "_price", 1.0)
    return time


def taking(seconds, clock):
    """A kernel that takes so many seconds, as Python."""
    function = kernel(twice)
    function.py_func = lambda a: (clock.__setitem__(0, clock[0] + seconds), twice(a))[1]
    return function


def test_a_function_runs_as_python_until_it_took_what_compiling_it_would(clock):
    function, a = taking(0.3, clock), np.ones(3)
    for call in range(3):
        assert np.array_equal(function(a), [2, 2, 2])
        assert not is_compiled(function)
        assert function.account.seconds == pytest.approx(0.3 * (call + 1))
    assert choice._ALL.seconds == pytest.approx(0.9)
    function.py_func = twice
    assert np.array_equal(function(a), [2, 2, 2])  # the next would bring it to 1.2 s
    assert is_compiled(function)
    assert (function.account.seconds, function.account.compiled) == (0.0, True)


def test_many_small_calls_add_up(clock):
    function = taking(0.011, clock)
    for _ in range(90):
        function(1)
    assert not is_compiled(function)
    function.py_func = twice
    for _ in range(2):
        function(1)
    assert is_compiled(function)


def test_other_types_have_to_pay_again(clock):
    function = taking(0.6, clock)
    function(1)
    function.py_func = twice
    assert function(1) == 2
    assert len(function.dispatcher.signatures) == 1
    function(np.ones(1))
    function(1)
    assert len(function.dispatcher.signatures) == 1
    function.account.enter(0.9, 1)
    function(np.ones(1))
    assert len(function.dispatcher.signatures) == 2


def test_a_call_is_expected_to_take_what_the_largest_took_for_an_element():
    account = Account()
    assert account.expected(1000, 20) == pytest.approx(INTERPRETING * 20_000)
    account.enter(0.5, 100)
    account.enter(0.5, 10)  # it is not the small ones that tell
    assert account.expected(1000, 20) == pytest.approx(5.0)
    account.enter(0.0, 200)
    assert account.expected(LARGE_SIZE, 1) == 0.0
    assert account.expected(LARGE_SIZE + 1, 1) == np.inf  # whatever was measured


def test_large_arrays_are_for_compiled_code(clock):
    function = taking(0.0, clock)
    function(np.ones(LARGE_SIZE))
    assert not is_compiled(function)
    function.py_func = twice
    function(np.ones(LARGE_SIZE + 1))
    assert is_compiled(function)


def test_the_tests_have_the_choice(clock, monkeypatch):
    function, a = kernel(twice), np.ones(3)
    monkeypatch.setattr(choice, "WHEN", "interpreted")
    function.account.enter(100.0, 10**5)
    function(a)
    assert not is_compiled(function)  # but if a call took seconds
    function(np.ones(LARGE_SIZE))
    assert is_compiled(function)
    function = kernel(twice)
    monkeypatch.setattr(choice, "WHEN", "compiled")
    function(a)
    assert is_compiled(function)


@pytest.mark.parametrize("when", ["interpreted", "compiled"])
def test_numbers_are_the_same_either_way(monkeypatch, when):
    monkeypatch.setattr(choice, "WHEN", when)
    quotient, square_root, size = root(np.array([1.0, -1.0]), 0.0)
    assert quotient == np.inf
    assert np.isnan(square_root)
    assert [type(x) for x in (quotient, square_root, size)] == [float, float, int]
    assert np.isnan(root(np.zeros(2), 0.0)[0])


def test_kernels_within_one_that_is_interpreted_are_part_of_it(clock):
    inner = taking(0.3, clock)
    outer = kernel(twice)
    outer.py_func = lambda a: [inner(a) for _ in range(5)]
    outer(1)
    assert outer.account.seconds == pytest.approx(1.5)
    assert inner.account.seconds == 0.0
    assert not is_compiled(inner)


def test_an_interruption_leaves_nothing_behind(clock):
    function = kernel(twice)
    function.py_func = lambda a: signal.raise_signal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        function(1)
    assert not choice._THREAD.interpreting
    with np.errstate(all="raise"), pytest.raises(FloatingPointError):
        np.float64(1) / 0
    function.py_func = twice
    assert function(1) == 2


def test_threads_do_not_mind_each_other(clock):
    function, seen = kernel(twice), []

    def look(a):
        thread = threading.Thread(target=lambda: seen.append(choice._THREAD.interpreting))
        thread.start()
        thread.join()
        return a

    function.py_func = look
    function(1)
    assert seen == [False]


def test_kernels_are_pickled_by_name():
    assert pickle.loads(pickle.dumps(root)) is root


def test_numba_is_not_imported_for_what_is_small(tmp_path):
    code = """
import sys
import isoembed
from isoembed.kernel import choice
from isoembed.gallery import Ellipsoid, triangulate
choice._clock = lambda: 0.0  # how fast the machine is does not count
isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 20)))
print("numba" in sys.modules)
"""
    environment = {key: value for key, value in os.environ.items() if key != "ISOEMBED_KERNELS"}
    environment["NUMBA_CACHE_DIR"] = str(tmp_path)
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("False\n", "")
