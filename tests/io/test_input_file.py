"""Files to read: opened once, decompressed where they are gzipped, closed in the end."""

import gzip
import io
import os
import subprocess
import sys

import numpy as np
import pytest

import zoo
from isoembed.io import (
    METRIC_ENDINGS,
    SURFACE_ENDINGS,
    FileError,
    InputFile,
    check_output,
    read_metric,
    read_surface,
)
from isoembed.io.hdf5 import listing
from isoembed.io.input_file import opened
from isoembed.io.registry import FORMATS
from isoembed.relativity import read_horizon, read_metric_or_grid

h5py = pytest.importorskip("h5py")

VERTICES, FACES = zoo.icosahedron()
WATCHED = set()
OPENED = []


def watch(event, arguments):
    if event == "open" and str(arguments[0]) in WATCHED:
        OPENED.append(arguments[0])


@pytest.fixture(scope="module")
def openings():
    """Counts how often a file is opened while it is read."""
    sys.addaudithook(watch)  # there is no way to take it away

    def counted(read, path):
        WATCHED.add(str(path))
        OPENED.clear()
        read(path)
        WATCHED.remove(str(path))
        return len(OPENED)

    return counted


def written(path):
    FORMATS[path.suffix].write(path, {"vertices": VERTICES, "faces": FACES})
    return path


@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_surfaces_are_opened_once(ending, openings, tmp_path):
    path = written(tmp_path / f"a{ending}")
    assert openings(read_metric, path) == 1
    assert openings(read_surface, path) == 1
    assert openings(read_metric_or_grid, path) == 1
    if ending not in METRIC_ENDINGS:
        assert openings(read_horizon, path) == 1
        zipped = tmp_path / f"a{ending}.gz"
        zipped.write_bytes(gzip.compress(path.read_bytes()))
        assert openings(read_horizon, zipped) == 1


def test_horizons_are_opened_once(openings, tmp_path):
    u = VERTICES / np.linalg.norm(VERTICES, axis=1, keepdims=True)
    np.savez(tmp_path / "points.npz", points=u)
    with h5py.File(tmp_path / "points.h5", "w") as file:
        file["ah/points"] = u
    with h5py.File(tmp_path / "spectre.h5", "w") as file:
        group = file.create_group("Ah.vol/ObservationId1")
        group.attrs["observation_value"] = 0.5
        for i, axis in enumerate("xyz"):
            group[f"InertialCoordinates_{axis}"] = u[:, i]
    for name in ("points.npz", "points.h5", "spectre.h5"):
        assert openings(read_horizon, tmp_path / name) == 1
        assert len(read_horizon(tmp_path / name).points) == 12


def test_contents_are_read_as_they_are_asked_for(tmp_path):
    (tmp_path / "A.TXT.gz").write_bytes(gzip.compress("é\n".encode() * 50_000))
    with InputFile(tmp_path / "A.TXT.gz") as file:
        assert file.ending == ".txt" and os.fspath(file) == str(tmp_path / "A.TXT.gz") == str(file)
        assert file.head.startswith("é\né\n") and 1000 < len(file.head) < len(file.text) == 100_000
        assert file.data is file.data
        with opened(file) as same:
            assert same is file
    (tmp_path / "latin.txt").write_bytes("é".encode("latin-1"))
    with InputFile(tmp_path / "latin.txt") as file:
        assert (file.head, file.text) == ("\ufffd", "é")
    (tmp_path / "wide.txt").write_bytes("é".encode("utf-16"))
    with InputFile(tmp_path / "wide.txt") as file:
        assert file.text == "é"
    for damaged in (b"\x89\x00", b"\xe9\x85", "é".encode("utf-16")[:-1]):
        (tmp_path / "damaged.txt").write_bytes(damaged)
        with (
            InputFile(tmp_path / "damaged.txt") as file,
            pytest.raises(FileError, match=r"damaged\.txt is not a text file"),
        ):
            file.text  # noqa: B018


def test_archives_and_hdf5_may_be_zipped(tmp_path):
    buffer = io.BytesIO()
    np.savez(buffer, points=VERTICES)
    (tmp_path / "a.npz.gz").write_bytes(gzip.compress(buffer.getvalue()))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["points"] = VERTICES
    (tmp_path / "a.h5.gz").write_bytes(gzip.compress((tmp_path / "a.h5").read_bytes()))
    for name in ("a.npz.gz", "a.h5.gz"):
        with InputFile(tmp_path / name) as file:
            np.testing.assert_array_equal(file.arrays[""]["points"], VERTICES)


@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_surfaces_may_be_zipped(ending, tmp_path):
    path = written(tmp_path / f"a{ending}")
    zipped = tmp_path / f"a{ending}.gz"
    zipped.write_bytes(gzip.compress(path.read_bytes()))
    for read in (read_metric, read_metric_or_grid):
        np.testing.assert_array_equal(read(zipped).lengths, read(path).lengths)
    np.testing.assert_array_equal(read_surface(zipped).vertices, read_surface(path).vertices)
    (tmp_path / "a.gz").write_bytes(zipped.read_bytes())
    with pytest.raises(FileError, match=r"a\.gz has no ending, not one of \.npz"):
        read_metric(tmp_path / "a.gz")
    with pytest.raises(FileError, match=r"has the ending '\.gz', not one of \.npz"):
        check_output(zipped, SURFACE_ENDINGS)


def test_what_cannot_be_decompressed(tmp_path):
    whole = gzip.compress(b"v 0 0 0\n" * 100)
    for cut in (3, 20, len(whole) - 3):
        (tmp_path / "a.obj.gz").write_bytes(whole[:cut])
        with pytest.raises(FileError, match=r"cannot decompress .*a\.obj\.gz: "):
            InputFile(tmp_path / "a.obj.gz")


def test_it_is_closed(tmp_path):
    path = written(tmp_path / "a.npz")
    with InputFile(path) as file:
        stream = file._stream
        assert not stream.closed
    assert stream.closed


def test_names_that_are_bytes_in_damaged_files():
    """As h5py passes them where they are not UTF-8."""

    class Damaged:
        def visititems(self, visit):
            visit("mass", 1.0)
            visit(b"m\xffss", 1.0)

    assert listing(Damaged()) == "the data sets mass, m�ss"


def test_a_header_whose_parenthesis_stays_open(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, faces=np.arange(30_000))  # of a small array the checksum is looked at first
    path.write_bytes(path.read_bytes().replace(b"(30000,), }", b"(30000,    "))
    with InputFile(path) as file, pytest.raises(FileError, match="cannot read faces of the archive"):
        _ = file.arrays


def test_refusals_quote_little_of_a_damaged_archive(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, faces=np.arange(3))
    data = path.read_bytes()
    begin = data.index(b"{'descr'")
    path.write_bytes(data[:begin] + b"\x01" * 60 + data[begin + 60 :])
    with InputFile(path) as file, pytest.raises(FileError) as error:
        _ = file.arrays
    message = str(error.value).replace(str(path), "")
    assert message.isprintable() and len(message) < 200


@pytest.mark.parametrize("error", [TypeError, KeyError, RuntimeError])
def test_what_h5py_raises_of_damaged_files(error, tmp_path):
    h5py.File(tmp_path / "a.h5", "w").close()
    sentence = "is not a readable HDF5 file: Unknown string encoding"
    with InputFile(tmp_path / "a.h5") as file, pytest.raises(FileError, match=sentence), file.hdf5():
        raise error("Unknown string encoding (value 2)")


def test_damaged_hdf5_files_do_not_crash_the_interpreter_at_its_exit(tmp_path):
    (tmp_path / "a.h5").write_bytes(b"")
    command = [sys.executable, "-m", "isoembed", "horizon", tmp_path / "a.h5"]
    assert subprocess.run(command, capture_output=True).returncode == 2
