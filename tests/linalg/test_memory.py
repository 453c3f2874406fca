"""Memory is asked for before it is taken: what is free, what factors need, and the sentence that refuses."""

import subprocess
import sys

import numpy as np
import pytest

import isoembed.linalg.memory as memory
from grids import grid
from isoembed.linalg import OutOfMemory, analyze
from isoembed.linalg.memory import UNKNOWN, available_memory, readable, require_memory
from places import SUPPORT

MB = 1_000_000


@pytest.fixture
def system(tmp_path, monkeypatch):
    """A machine without files: write(name, text) adds one."""
    monkeypatch.setattr(memory, "PROC", tmp_path / "proc")
    monkeypatch.setattr(memory, "CGROUPS", tmp_path / "cgroup")
    monkeypatch.setattr(memory, "_address_space", lambda: UNKNOWN)

    def write(name, text):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    return write


def test_the_machine_has_memory_left():
    assert 10 * MB < available_memory() < UNKNOWN


def test_what_linux_calls_available(system):
    system("proc/meminfo", "MemTotal: 16000 kB\nMemFree: 1000 kB\nMemAvailable:    4000 kB\n")
    assert available_memory() == 4000 * 1024


def test_without_linux_the_free_pages_count(system, monkeypatch):
    assert available_memory() == pytest.approx(memory.os.sysconf("SC_AVPHYS_PAGES") * 4096, rel=0.5)
    monkeypatch.delattr(memory.os, "sysconf")
    assert available_memory() == UNKNOWN


def test_control_groups_of_version_2(system):
    system("proc/meminfo", "MemAvailable: 900000 kB\n")
    system("proc/self/cgroup", "0::/user/session\n")
    system("cgroup/user/session/memory.max", "max\n")
    system("cgroup/user/session/memory.current", f"{200 * MB}\n")
    assert available_memory() == 900_000 * 1024
    system("cgroup/user/session/memory.max", f"{500 * MB}\n")
    assert available_memory() == 300 * MB
    system("cgroup/user/session/memory.stat", f"anon 5\ninactive_file {40 * MB}\nactive_file 7\n")
    assert available_memory() == 340 * MB
    # the group above holds other processes, too
    system("cgroup/user/memory.max", f"{600 * MB}\n")
    system("cgroup/user/memory.current", f"{590 * MB}\n")
    assert available_memory() == 10 * MB
    system("cgroup/user/memory.current", f"{610 * MB}\n")
    assert available_memory() == 0


@pytest.mark.parametrize("group", ["docker/abc/", ""])  # seen from outside and from inside a container
def test_control_groups_of_version_1(system, group):
    system("proc/meminfo", "MemAvailable: 900000 kB\n")
    system("proc/self/cgroup", "5:cpu,cpuacct:/docker/abc\n4:memory:/docker/abc\n0::/\n")
    system(f"cgroup/memory/{group}memory.limit_in_bytes", f"{500 * MB}\n")
    system(f"cgroup/memory/{group}memory.usage_in_bytes", f"{450 * MB}\n")
    system(f"cgroup/memory/{group}memory.stat", f"inactive_file 1\ntotal_inactive_file {25 * MB}\n")
    assert available_memory() == 75 * MB


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="macOS does not enforce this limit")
def test_a_limit_on_the_address_space_is_seen_and_kept():
    code = """
import resource
import numpy as np
from isoembed.linalg import OutOfMemory, analyze
from isoembed.linalg.memory import (available_memory)
import scipy.sparse as sp
dense = sp.csc_matrix(np.ones((30, 30)))
analyze(dense, np.arange(30)).factor((np.eye(30) + 1).ravel())  # libraries are loaded
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 100_000_000, resource.RLIM_INFINITY))
print(available_memory())
n = 6000  # an arrow's factor, in the wrong order, is dense: 144 MB
arrow = sp.lil_matrix((n, n))
arrow[0] = 1.0
arrow[:, 0] = 1.0
arrow.setdiag(1.0)
try:
    analyze(arrow, np.arange(n))
except OutOfMemory as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    free, sentence = done.stdout.splitlines()
    assert 90 * MB < int(free) <= 100 * MB
    assert sentence.startswith("the factors of a matrix of 6000 unknowns need about ")
    assert sentence.endswith(" MB are free")


def test_what_does_not_fit_is_refused_when_analyzed_and_when_factored(monkeypatch):
    matrix, order = grid(30)
    monkeypatch.setattr(memory, "UNASKED", 0)
    solver = analyze(matrix, order)
    monkeypatch.setattr(memory, "available_memory", lambda: 39_000)
    sentence = r"^the factors of a matrix of 900 unknowns need about \d+ kB of memory, and 39.0 kB are free$"
    with pytest.raises(OutOfMemory, match=sentence):
        solver.factor(matrix.data)
    with pytest.raises(MemoryError, match=sentence):
        analyze(matrix, order)
    monkeypatch.setattr(memory, "available_memory", lambda: 10**9)
    b = np.ones(900)
    assert matrix @ solver.factor(matrix.data).solve(b) == pytest.approx(b)


def test_a_loop_that_replaces_its_factors_is_not_refused(monkeypatch):
    matrix, order = grid(30)
    solver = analyze(matrix, order)
    needs = solver.needs
    solver.factor(matrix.data)  # let go at once
    monkeypatch.setattr(memory, "UNASKED", 0)
    monkeypatch.setattr(memory, "available_memory", lambda: needs)
    solver.factor(matrix.data)


def test_small_factors_ask_nobody(monkeypatch):
    matrix, order = grid(5)
    monkeypatch.setattr(memory, "available_memory", lambda: 0)
    analyze(matrix, order).factor(matrix.data)
    with pytest.raises(OutOfMemory, match=r"^the rest need about 1\.0 GB of memory, and 0 bytes are free"):
        require_memory(10**9, "the rest")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads Linux's record of the peak")
@pytest.mark.parametrize("definite", [True, False])
def test_the_estimates_are_of_what_is_taken(definite):
    code = f"""
import sys
sys.path.insert(0, {str(SUPPORT)!r})
from grids import grid
from isoembed.linalg import analyze
def status(key):
    with open("/proc/self/status") as lines:
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(key))
small, order = grid(60)
analyze(small, order, definite={definite}).factor(small.data)  # libraries are loaded
matrix, order = grid(280)
before = status("VmRSS")
solver = analyze(matrix, order, definite={definite})
needs = solver.needs
factor = solver.factor(matrix.data)
print(needs, status("VmHWM") - before)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    needs, taken = map(int, done.stdout.split())
    # Beside the factors there are the matrix, several times, and vectors.
    assert needs < taken + 4 * MB
    assert taken < 1.3 * needs + 20 * MB


def test_numbers_of_bytes_are_readable():
    sizes = [0, 999, 1000, 99_940, 99_960, 6_140_000_000, 3.2e15, 1e19]
    assert [readable(size) for size in sizes] == [
        "0 bytes",
        "999 bytes",
        "1.0 kB",
        "99.9 kB",
        "100 kB",
        "6.1 GB",
        "3.2 PB",
        "10000 PB",
    ]


@pytest.mark.skipif(sys.platform != "linux", reason="mallopt is glibc's")
def test_what_is_freed_is_kept_for_arrays_to_come():
    code = """
import resource
import numpy as np
from isoembed.linalg.memory import (keep_freed_memory)
keep_freed_memory()
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
np.ones(2**22)
before = faults()
for _ in range(10):
    np.ones(2**22)
print(faults() - before)
"""
    assert int(subprocess.check_output([sys.executable, "-c", code], text=True)) < 2**13  # pages of one array
