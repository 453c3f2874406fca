"""``isoembed reproduce``, with a study that takes no time."""

import pytest

from isoembed.cli import main
from isoembed.errors import NotEmbedded
from isoembed.studies import reproduce
from isoembed.studies.reproduce import Study
from isoembed.studies.section import Section


def nothing():
    return Section("Nothing", ("Nothing was computed.",))


def fails():
    raise NotEmbedded("no surface was found", None)


@pytest.fixture
def nothing_to_make(monkeypatch):
    monkeypatch.setattr(reproduce, "STUDIES", (Study("nothing", nothing, {}, {}),))


def test_it_writes_a_report_and_tells_where(nothing_to_make, tmp_path, capsys):
    folder = tmp_path / "report"
    assert main(["reproduce", "--quick", "--output", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{folder / 'report.html'}\n"
    assert [line.split(":")[0] for line in err.splitlines()] == ["1/1 nothing ...", "1/1 nothing"]
    assert "Nothing was computed." in (folder / "report.html").read_text()


def test_quiet_is_quiet(nothing_to_make, tmp_path, capsys):
    assert main(["reproduce", "--quick", "--quiet", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_section_that_fails_is_status_3(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(reproduce, "STUDIES", (Study("failing", fails, {}, {}),))
    assert main(["reproduce", "-o", str(tmp_path), "--quiet"]) == 3
    assert capsys.readouterr().err == "isoembed: error: failing: no surface was found\n"
    assert (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["taken", "taken/below", "x" * 300, "a\0b"])
def test_a_bad_folder_is_one_sentence(nothing_to_make, tmp_path, capsys, name):
    (tmp_path / "taken").write_text("")
    assert main(["reproduce", "--quick", "-o", str(tmp_path / name)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("isoembed: error: cannot ")
    assert err.count("\n") == 1


def test_a_folder_is_needed(capsys):
    assert main(["reproduce"]) == 2
    assert "--output" in capsys.readouterr().err
