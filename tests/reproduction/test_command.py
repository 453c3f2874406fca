"""``python -m reproduction``, with a study that takes no time."""

import pytest

pytest.importorskip("matplotlib")

from isoembed import NotEmbedded
from reproduction import __main__ as command
from reproduction.reproduce import Study
from reproduction.section import Section


def nothing():
    return Section("Nothing", ("Nothing was computed.",))


def fails():
    raise NotEmbedded("no surface was found", None)


@pytest.fixture
def nothing_to_make(monkeypatch):
    monkeypatch.setattr(command, "STUDIES", (Study("nothing", nothing, {}, {}),))


def test_it_writes_a_report_and_says_where(nothing_to_make, tmp_path, capsys):
    folder = tmp_path / "report"
    assert command.main(["--quick", "--output", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{folder / 'report.html'}\n"
    assert [line.split(":")[0] for line in err.splitlines()] == ["1/1 nothing ...", "1/1 nothing"]
    assert "Nothing was computed." in (folder / "report.html").read_text()


def test_a_section_that_fails_is_status_1(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(command, "STUDIES", (Study("failing", fails, {}, {}),))
    assert command.main(["-o", str(tmp_path)]) == 1
    assert capsys.readouterr().err.endswith("error: failing: no surface was found\n")
    assert (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["taken", "taken/below", "x" * 300, "a\0b"])
def test_a_bad_folder_is_one_sentence(nothing_to_make, tmp_path, capsys, name):
    (tmp_path / "taken").write_text("")
    with pytest.raises(SystemExit, match=r"^2$"):
        command.main(["--quick", "-o", str(tmp_path / name)])
    assert ": error: cannot " in capsys.readouterr().err.splitlines()[-1]


def test_a_folder_is_needed(capsys):
    with pytest.raises(SystemExit, match=r"^2$"):
        command.main([])
    assert "--output" in capsys.readouterr().err
