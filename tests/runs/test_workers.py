"""Processes side by side."""

import os
import subprocess
import sys
import time
from concurrent.futures import wait
from contextlib import suppress
from pathlib import Path

import pytest

from isoembed.runs import Workers

SLEEPS = """
import os, sys, time
from isoembed.runs import Workers
if __name__ == "__main__":
    workers = Workers(2)
    numbers = [workers.submit(os.getpid).result() for _ in range(2)]
    for _ in range(2):
        workers.submit(time.sleep, 600.0)
    print(*numbers, flush=True)
    {then}
"""


def alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    with suppress(FileNotFoundError):
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def ends(numbers, seconds=120.0):
    end = time.monotonic() + seconds
    while any(map(alive, numbers)) and time.monotonic() < end:
        time.sleep(0.05)
    return not any(map(alive, numbers))


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="looks at processes in /proc")
@pytest.mark.parametrize(
    "then", ["os.kill(os.getpid(), 9)", "workers.shutdown(wait=True, cancel_futures=True)"]
)
def test_processes_end_with_the_one_that_began_them(tmp_path, then):
    script = tmp_path / "script.py"
    script.write_text(SLEEPS.format(then=then))
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300)
    numbers = [int(number) for number in done.stdout.split()]
    assert len(numbers) == 2, done.stderr
    assert ends(numbers)


def test_as_many_processes_as_are_asked_for():
    with Workers(2) as workers:
        futures = [workers.submit(time.sleep, 0.2) for _ in range(2)]
        wait(futures)
        numbers = {workers.submit(os.getpid).result() for _ in range(4)}
    assert os.getpid() not in numbers and len(numbers) <= 2
