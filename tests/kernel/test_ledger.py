"""What functions took in earlier processes."""

import pytest

from isoembed.kernel import ledger
from isoembed.kernel.worth import IMPORTING, LOADING, lasting


@pytest.fixture
def file(tmp_path, monkeypatch):
    """Where the ledger of a test is."""
    monkeypatch.setattr(ledger, "_file", lambda: tmp_path / "made" / ledger.NAME)
    return tmp_path / "made" / ledger.NAME


def test_seconds_of_processes_add_up_until_a_function_is_compiled(file):
    assert ledger._read(file) == {}
    ledger.write({"a": 1.0, "b": 2.0}, set())
    ledger.write({"a": 0.5}, set())
    assert ledger._read(file) == {"a": 1.5, "b": 2.0}
    ledger.write({"b": 0.25}, {"a", "b"})  # b for other types than it was compiled for
    assert ledger._read(file) == {"b": 0.25}
    assert [path.name for path in file.parent.iterdir()] == [ledger.NAME]


@pytest.mark.parametrize("text", ["", "[]", '{"a": "b"}', "\0"])
def test_a_damaged_ledger_is_begun_anew(file, text):
    file.parent.mkdir()
    file.write_text(text)
    ledger.write({"a": 1.0}, set())
    assert ledger._read(file) == {"a": 1.0}


def test_where_nothing_can_be_written_nothing_is(file, monkeypatch):
    file.parent.write_text("no folder")
    ledger.write({"a": 1.0}, set())
    assert file.parent.read_text() == "no folder"
    monkeypatch.setattr(ledger, "_file", lambda: None)
    ledger.write({"a": 1.0}, set())
    assert [entry.name for entry in file.parent.parent.iterdir()] == [file.parent.name]


def test_a_file_that_cannot_be_replaced_leaves_no_other(file):
    (file / "in the way").mkdir(parents=True)
    ledger.write({"a": 1.0}, set())
    assert [entry.name for entry in file.parent.iterdir()] == [file.name]


def test_only_what_compiled_code_would_have_saved_counts():
    assert lasting(1.0, 5.0, True) == pytest.approx(1.0 - LOADING)
    assert lasting(LOADING / 2, 5.0, True) == 0.0
    assert lasting(0.1, IMPORTING, False) == 0.0  # as long as numba takes to be imported
    assert lasting(0.1, 2 * IMPORTING, False) == pytest.approx((0.1 - LOADING) / 2)
