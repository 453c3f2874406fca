"""The folder of results."""

import os

import numpy as np
import pytest

from isoembed.io import FileError
from isoembed.runs import Result, Store

ANSWER = Result("a", "done", {"x": 1}, {"x": np.ones(3)})


@pytest.fixture
def store(tmp_path):
    return Store.made(tmp_path / "deep" / "folder")


def test_what_is_kept_is_found_under_its_key(store):
    store.keep(ANSWER, "k1")
    assert store.find("a", "k2") is None and store.find("b", "k1") is None
    found = store.find("a", "k1")
    assert found is not None and found.report == {"x": 1}


def test_a_damaged_file_is_no_result(store):
    store.keep(ANSWER, "k1")
    path = store.path("a", "k1")
    data = path.read_bytes()
    for cut in (0, 10, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:cut])
        assert store.find("a", "k1") is None and list(store) == []
    path.write_bytes(data[:200] + bytes([data[200] ^ 1]) + data[201:])
    assert store.find("a", "k1") is None


def test_of_several_the_one_asked_for_last_counts(store):
    for k in (1, 2):
        store.keep(Result("a", "done", {"x": k}, {"x": np.ones(1)}), f"k{k}")
        os.utime(store.path("a", f"k{k}"), (k, k))
    assert [result.report["x"] for result in store] == [2]
    store.find("a", "k1")
    assert [result.report["x"] for result in store] == [1]


def test_without_tasks_an_answer_counts_before_a_later_refusal(store):
    store.keep(Result("a", "done", {"x": 1}, {"x": np.ones(1)}), "k1")
    store.keep(Result.without_answer("a", "refused", "wrong"), "k2")
    for old, new in (("k1", "k2"), ("k2", "k1")):  # a copy may have any order
        os.utime(store.path("a", old), (1, 1))
        os.utime(store.path("a", new), (2, 2))
        assert [result.status for result in store] == ["done"]
    os.utime(store.path("a", "k2"), (3, 3))
    assert [result.status for result in store.of(["a"])] == ["refused"]  # it was asked for


def test_results_come_by_label_and_unfinished_files_are_none(store):
    for label in ("b.t10", "a.t2", "b.t9"):
        store.keep(Result(label, "done", {}, {"x": np.ones(1)}), "0")
    (store.path("a", "0").parent / ".isoembed-12.npz").write_bytes(b"half")
    assert [result.label for result in store] == ["a.t2", "b.t10", "b.t9"]


def test_the_results_of_some(store):
    for label in ("a", "b", "c"):
        store.keep(Result(label, "done", {}, {"x": np.ones(1)}), "0")
    assert [result.label for result in store.of(["c", "a", "z"])] == ["a", "c"]


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match=r"^cannot make the folder .*results: Not a directory$"):
        Store.made(tmp_path / "file")
