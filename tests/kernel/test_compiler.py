"""Compiled functions and where their code is kept, whatever the place is like."""

import os
import pickle
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import isoembed
from isoembed.kernel import numba_hooks

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from halved import halved
print(halved(3), halved.stats.cache_path, sum(halved.stats.cache_hits.values()))
"""
MODULE = """
from isoembed.kernel import kernel

@kernel
def halved(a):
    return a / 2
"""


@pytest.fixture
def place(tmp_path):
    """A folder with a module that has a kernel; nothing can be written beside it, nor in a home."""
    source = tmp_path / "source"
    source.mkdir()
    (source / "halved.py").write_text(MODULE)
    (source / "__pycache__").write_text("no folder")
    (tmp_path / "home").write_text("no folder")
    (tmp_path / "temporary").mkdir()
    return tmp_path


def call(place, script=SCRIPT, **environment):
    """Call the kernel in a process; return where its code is kept, and whether it was there before."""
    usual = {key: value for key, value in os.environ.items() if not key.startswith(("NUMBA", "XDG"))}
    places = {"HOME": place / "home", "TMPDIR": place / "temporary", "PYTHONDONTWRITEBYTECODE": "1"}
    paths = {"PYTHONPATH": Path(isoembed.__file__).parents[1], "ISOEMBED_KERNELS": "compiled"}
    done = subprocess.run(
        [sys.executable, "-c", script, place / "source"],
        env=usual | {key: str(value) for key, value in (places | paths | environment).items()},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    value, path, hits = done.stdout.split()
    assert value == "1.5"
    return Path(path), bool(int(hits))


def test_a_temporary_folder_takes_the_place_of_the_others(place):
    path, _ = call(place)
    assert path.parent == place / "temporary" / f"isoembed-{os.getuid()}"
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert call(place) == (path, True)


def test_the_folder_of_the_environment(place):
    path, _ = call(place, NUMBA_CACHE_DIR=place / "kept")
    assert path.parent == place / "kept"
    assert not os.listdir(place / "temporary")


@pytest.mark.parametrize("kind", ["open to others", "a link"])
def test_nothing_is_run_from_a_folder_that_is_not_ours_alone(place, kind):
    theirs = place / "temporary" / f"isoembed-{os.getuid()}"
    if kind == "a link":
        (place / "elsewhere").mkdir(mode=0o700)
        theirs.symlink_to(place / "elsewhere")
    else:
        theirs.mkdir()
        theirs.chmod(0o770)
    assert call(place) == (Path("None"), False)


@pytest.mark.parametrize("what", ["index", "code"])
def test_damaged_files_are_written_again(place, what):
    (place / "source" / "__pycache__").unlink()
    path, _ = call(place)
    (damaged,) = path.glob("*.nbi" if what == "index" else "*.nbc")
    damaged.write_bytes(b"")
    assert call(place) == (path, False)
    assert call(place) == (path, True)


def test_code_for_types_that_are_gone_is_compiled_again(place):
    (place / "source" / "__pycache__").unlink()
    path, _ = call(place)
    (index,) = path.glob("*.nbi")
    version = index.read_bytes()[: first_pickle(index)]
    index.write_bytes(version + b"cisoembed.kernel\nNoSuchType\n.")
    assert call(place) == (path, False)
    assert call(place) == (path, True)


def first_pickle(path):
    """Where the first pickle of a file ends."""
    with path.open("rb") as file:
        pickle.load(file)
        return file.tell()


def test_what_was_kept_can_be_compiled_with_others(place):
    (place / "source" / "quartered.py").write_text(
        MODULE.replace("halved(a)", "quartered(a)")
        .replace("a / 2", "halved(halved(a))")
        .replace("\n@", "\nfrom halved import halved\n\n@")
    )
    script = SCRIPT + "from quartered import quartered\nassert quartered(3.0) == 0.75\n"
    kept = [call(place, script)[1] for _ in range(3)]
    assert kept == [False, True, True]
    (next(place.rglob("quartered.quartered*.nbi"))).unlink()
    assert call(place, script)[1]  # compiled with a kept one, for other numbers too


def of_arrays(place, value, check):
    """A script that calls a kernel with arrays in it, which is kept if `halved` is, and checks it."""
    module = MODULE.replace("halved(a)", "arrays(a)").replace("a / 2", value)
    (place / "source" / "arrays.py").write_text(f"import numpy as np\n{module}")
    return f"""{SCRIPT}
import numpy as np
from arrays import arrays
found, kept = arrays(3.0), bool(sum(arrays.stats.cache_hits.values()))
assert kept is bool(sum(halved.stats.cache_hits.values()))
{check}
"""


def test_what_was_kept_is_loaded_without_what_numba_compiles_arrays_with(place):
    value = "np.linspace(0.0, a, 3).max() + np.zeros(2).sum()"
    script = of_arrays(
        place, value, "assert found == 3.0 and kept is not ('numba.np.arrayobj' in sys.modules)"
    )
    assert [call(place, script)[1] for _ in range(2)] == [False, True]


def test_arrays_of_what_was_kept_are_of_the_types_that_numpy_knows_at_once(place):
    value = "np.array([a, a * a]), np.arange(2), np.array([a > 0])"
    check = "assert [x.dtype is np.dtype(t) for x, t in zip(found, (float, np.int64, bool))] == [True] * 3"
    script = of_arrays(place, value, check)
    assert [call(place, script)[1] for _ in range(2)] == [False, True]


def test_what_an_interruption_leaves_is_told_the_next_time(monkeypatch):
    told = []

    def interrupted():
        if not told:
            told.append("begun")
            raise KeyboardInterrupt

    monkeypatch.setattr(numba_hooks, "_waiting", [interrupted, lambda: told.append("second")])
    with pytest.raises(KeyboardInterrupt):
        numba_hooks.tell_numba()
    numba_hooks.tell_numba()
    assert told == ["begun", "second"]
    numba_hooks.with_numba(lambda: told.append("at once"))
    assert told[-1] == "at once"
