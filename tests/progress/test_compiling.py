"""What is compiled is not the time of a stage."""

import time

from numba import njit

import isoembed.kernel.compiler  # noqa: F401 -- numba's events are heard
from isoembed.progress.compiling import COMPILING, Compiling, working_clock
from isoembed.progress.stages import COMPILATION, Log


def fresh():
    """Two functions that nobody has called."""

    @njit
    def inner(x):
        return 2 * x

    @njit
    def outer(x):
        return inner(x) + 1

    return outer


def test_a_stage_in_which_functions_are_compiled():
    log, outer = Log(), fresh()
    begun = time.perf_counter()
    with log.stage("work") as recorder:
        assert outer(3) == 7
        recorder.iterations += 1
    real = time.perf_counter() - begun
    compilation, work = log.stages
    assert (compilation.name, compilation.iterations, compilation.factorizations) == (COMPILATION, 2, 0)
    assert (work.name, work.iterations) == ("work", 1)
    assert 0 < compilation.seconds <= real
    assert compilation.seconds + work.seconds <= real
    with log.stage("again"):
        outer(4)
    assert [stage.name for stage in log.stages] == [COMPILATION, "work", "again"]


def test_the_clock_stands_still():
    compiling = Compiling()
    compiling.on_start(None)
    compiling.on_start(None)
    time.sleep(0.02)
    compiling.on_end(None)
    assert compiling.now
    time.sleep(0.02)
    assert compiling.seconds >= 0.04
    compiling.on_end(None)
    whole = compiling.seconds
    time.sleep(0.02)
    assert (compiling.seconds, compiling.now, compiling.functions) == (whole, False, 2)


def test_the_working_clock_is_the_clock_but_for_that():
    outer, compiled = fresh(), COMPILING.seconds
    begun = time.perf_counter()
    before = working_clock()
    outer(1)
    worked = working_clock() - before
    passed, compiled = time.perf_counter() - begun, COMPILING.seconds - compiled
    assert compiled > 0
    assert 0 < worked <= passed - 0.999 * compiled  # but for rounding
