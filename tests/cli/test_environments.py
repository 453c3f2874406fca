"""The command where something is missing or closed: a sentence, an exit status, and files whole or none."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from itertools import combinations
from pathlib import Path

import pytest

import isoembed
import zoo
from isoembed import PolyhedralMetric
from isoembed.io import read_metric, read_surface, write_metric
from isoembed.io.registry import SURFACE_ENDINGS

SOURCE = Path(isoembed.__file__).parents[1]
COMMAND = [sys.executable, "-c", "import sys; from isoembed.cli import main; sys.exit(main())"]
CLOSED = [closed for count in range(4) for closed in combinations(range(3), count)]
IN, OUT, ERR = range(3)
UNREADABLE = "isoembed: error: cannot write to standard output: it is closed\n"


def limited(**limits):
    """What sets limits of these names in a new process."""

    def set_limits():
        for name, limit in limits.items():
            resource.setrlimit(getattr(resource, name), (limit, limit))

    return set_limits


def run(*arguments, folder, closed=(), environment=None, prepare=None, **options):
    """Run the command in a folder; return its status, its output and its complaint."""

    def before():
        for number in closed:
            os.close(number)
        if prepare is not None:
            prepare()

    done = subprocess.run(
        [*COMMAND, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(SOURCE), **(environment or {})},
        preexec_fn=before,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        timeout=300,
        **options,
    )
    err = done.stderr.decode()
    assert "Traceback" not in err, err
    return done.returncode, done.stdout.decode(errors="replace"), err


@pytest.fixture
def here(tmp_path):
    write_metric(tmp_path / "m.npz", PolyhedralMetric.from_mesh(*zoo.icosphere(1)))
    return tmp_path


# Standard streams


def test_without_standard_output(here):
    status = run("surface", "drum", "--vertices", 50, "-o", "drum.npz", folder=here, closed=[OUT])
    assert status == (0, "", "")
    assert read_metric(here / "drum.npz").triangulation.n_vertices == 50
    assert run("inspect", "drum.npz", folder=here, closed=[OUT]) == (2, "", UNREADABLE)


@pytest.mark.slow
@pytest.mark.parametrize("closed", CLOSED, ids=lambda closed: "".join(map(str, closed)) or "none")
def test_streams_closed_in_every_combination(here, closed):
    def called(*arguments):
        status, out, err = run(*arguments, folder=here, closed=closed)
        assert not (out and OUT in closed) and not (err and ERR in closed)
        return status, err

    answered = (2, "" if ERR in closed else UNREADABLE) if OUT in closed else (0, "")
    assert called("embed", "m.npz", "-o", "a.obj", "--report", "r.json", "--html", "p.html") == (0, "")
    assert called("embed", "m.npz", "--report", "r.json") == (0, "")
    assert called("inspect", "a.obj") == answered
    assert called("--help") == answered
    status, err = called("inspect", "-")
    assert status == 2 and (err == "" if ERR in closed else err.count("\n") == 1)
    assert len(read_surface(here / "a.obj").vertices) == 42
    assert (here / "p.html").read_text().startswith("<!doctype html>")
    assert sorted(os.listdir(here)) == ["a.obj", "m.npz", "p.html", "r.json"]


# Disks


@pytest.mark.slow
def test_a_file_that_grows_too_large(here):
    outputs = ("-o", "a.vtk", "--report", "r.json", "--html", "p.html")
    status, _, err = run("embed", "m.npz", *outputs, folder=here, prepare=limited(RLIMIT_FSIZE=20_000))
    assert (status, err) == (
        2,
        "isoembed: error: cannot write p.html: File too large; a.vtk is written; r.json is written\n",
    )
    assert sorted(os.listdir(here)) == ["a.vtk", "m.npz", "r.json"]


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 16 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=16k", "none", str(place)]
    allowed = os.geteuid() == 0 and shutil.which("mount")
    if not allowed or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("nothing can be mounted here")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.slow
def test_a_full_disk(here, small_disk):
    outputs = ("-o", "a.vtk", "--html", small_disk / "p.html")
    status, _, err = run("embed", "m.npz", *outputs, folder=here)
    full = f"isoembed: error: cannot write {small_disk}/p.html: No space left on device"
    assert (status, err) == (2, f"{full}; a.vtk is written\n")
    assert not os.listdir(small_disk)
    (small_disk / "filled").write_bytes(bytes(16_384))
    (here / "a.vtk").unlink()
    assert run("embed", "m.npz", *outputs, folder=here) == (2, "", f"{full}\n")  # before anything is computed
    assert sorted(os.listdir(here)) == ["disk", "m.npz"]


# Places


@pytest.fixture
def nobody():
    """A copy of the package that nobody can write to, and the options and places of a process of nobody."""
    place = Path(tempfile.mkdtemp())
    place.chmod(0o755)
    package = place / "site-packages"
    shutil.copytree(SOURCE / "isoembed", package / "isoembed", ignore=shutil.ignore_patterns("__pycache__"))
    root = os.geteuid() == 0
    subprocess.run(["chmod", "-R", "a+rX,a-w", package], check=True)
    (place / "tmp").mkdir()
    (place / "tmp").chmod(0o777)
    options = {"user": 65534, "group": 65534, "extra_groups": []} if root else {}
    places = {"HOME": "/nonexistent", "TMPDIR": str(place / "tmp"), "PYTHONPATH": str(package)}
    try:
        probe = [sys.executable, "-c", "import scipy"]
        try:
            readable = subprocess.run(probe, cwd=place, capture_output=True, **options).returncode == 0
        except PermissionError:
            readable = False
        if not readable:
            pytest.skip("nobody cannot read this Python")
        yield {"environment": places, **options, "folder": place / "tmp"}
    finally:
        subprocess.run(["chmod", "-R", "u+w", package], check=True)
        shutil.rmtree(place)


@pytest.mark.slow
def test_without_a_home_and_a_writable_package(nobody):
    status, out, err = run("surface", "--list", **nobody)
    assert (status, err) == (0, "")
    assert "ellipsoid" in out
    assert run("surface", "sphere", "--vertices", 12, "-o", "s.npz", **nobody)[::2] == (0, "")


def test_a_folder_that_is_gone(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    for arguments in (("embed", "m.npz", "-o", "a.npz"), ("embed", "m.npz", "--checkpoint", "c.npz")):
        status, _, err = run(*arguments, folder=gone, prepare=lambda: shutil.rmtree(gone))
        assert status == 2 and err.startswith("isoembed: error: ") and err.count("\n") == 1
        gone.mkdir()


# Encodings and terminals


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [
        {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"},
        {"PYTHONIOENCODING": "ascii", "TERM": "dumb", "NO_COLOR": "1"},
    ],
    ids=["C locale", "ASCII"],
)
def test_names_beyond_ascii(here, environment):
    outputs = ("-o", "Fläche.ply", "--report", "Bericht ∫.json", "--html", "p.html")
    status, out, err = run("embed", "m.npz", *outputs, folder=here, environment=environment)
    assert (status, err) == (0, "")
    assert out.startswith("converged: ")
    status, out, err = run("inspect", "Fläche.ply", folder=here, environment=environment)
    assert (status, err) == (0, "")
    assert ": a polyhedral metric on the sphere" in out
    assert (here / "Bericht ∫.json").exists()
    assert run("inspect", "∂.ply", folder=here, environment=environment)[0] == 2


# Memory


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="macOS does not enforce this limit")
def test_limits_of_the_address_space(here):
    complaint = "isoembed: error: an address space of {} bytes is too small: libraries need 800000000\n"
    for limit in (100_000_000, 454_000_000, 799_999_999):  # in the first two, libraries break while loaded
        prepare = limited(RLIMIT_AS=limit)
        done = run("embed", "m.npz", "-o", "a.vtk", folder=here, prepare=prepare)
        assert done == (2, "", complaint.format(limit))
        assert os.listdir(here) == ["m.npz"]
    prepare = limited(RLIMIT_AS=4 * 10**9)
    assert run("embed", "m.npz", "-o", "a.vtk", "--quiet", folder=here, prepare=prepare) == (0, "", "")


# Formats


@pytest.mark.parametrize("limit", [0, 1000, 4096])
@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_formats_that_do_not_fit(here, ending, limit, monkeypatch):
    from isoembed import Embedding
    from isoembed.io import FileError, write_surface

    vertices, faces = zoo.icosphere(2)
    surface = Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-9)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        with pytest.raises(FileError, match=r"cannot write .*a\.\w+: File too large$"):
            write_surface(here / f"a{ending}", surface)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert os.listdir(here) == ["m.npz"]
