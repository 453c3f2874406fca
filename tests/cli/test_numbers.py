"""Arrays of numbers from ``.npy`` files: read, and refused without advice to load them unsafely."""

import io

import numpy as np
import pytest

from isoembed.cli.numbers import read_numbers
from isoembed.io.files import FileError


def saved(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def archive():
    file = io.BytesIO()
    np.savez(file, a=np.ones(3))
    return file.getvalue()


@pytest.mark.parametrize("kind", [np.int32, np.uint8, np.float32, np.float64])
def test_numbers_of_every_kind(kind, tmp_path):
    array = np.arange(12).reshape(3, 4).astype(kind)
    np.save(tmp_path / "k.npy", array)
    found = read_numbers(tmp_path / "k.npy")
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, array)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b'{"format": "isoembed"}', "k.npy is not a .npy file"),
        (b"1.0 2.0 3.0\n", "k.npy is not a .npy file"),
        (b"", "k.npy is not a .npy file"),
        (saved(np.ones(3))[:4], "k.npy is not a .npy file"),
        (archive(), "k.npy is not a .npy file"),
        (saved(np.array(["a", "b"])), "k.npy does not hold one array of numbers"),
        (saved(np.ones(3) * 1j), "k.npy does not hold one array of numbers"),
        (saved(np.array([[1.0, 2.0], [np.inf, 3.0]])), "k.npy: entry (1, 0) is inf"),
    ],
)
def test_files_that_are_refused(content, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "k.npy").write_bytes(content)
    with pytest.raises(FileError) as caught:
        read_numbers((tmp_path / "k.npy").relative_to(tmp_path))
    assert str(caught.value) == sentence


@pytest.mark.parametrize("content", [saved(np.ones(30))[:-8], saved(np.ones(30))[:20]])
def test_files_that_are_cut_short(content, tmp_path):
    (tmp_path / "k.npy").write_bytes(content)
    with pytest.raises(FileError, match=r"k\.npy is not a readable \.npy file: \w+"):
        read_numbers(tmp_path / "k.npy")
