"""``isoembed reproduce``, with a plan that takes no time."""

import pytest

from isoembed.cli import main
from isoembed.errors import NotEmbedded
from isoembed.studies import reproduce
from isoembed.studies.reproduce import Plan, Study
from isoembed.studies.section import Section


def nothing():
    return Section("Nothing", ("Nothing was computed.",))


def fails():
    raise NotEmbedded("no surface was found", None)


@pytest.fixture
def plans(monkeypatch):
    """Replace both plans; the full one fails."""
    monkeypatch.setattr(reproduce, "QUICK", Plan("quick", (Study("nothing", nothing, {}),)))
    monkeypatch.setattr(reproduce, "FULL", Plan("full", (Study("failing", fails, {}),)))


def test_it_writes_a_report_and_tells_where(plans, tmp_path, capsys):
    folder = tmp_path / "report"
    assert main(["reproduce", "--quick", "--output", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{folder / 'report.html'}\n"
    assert [line.split(":")[0] for line in err.splitlines()] == ["1/1 nothing ...", "1/1 nothing"]
    assert "Nothing was computed." in (folder / "report.html").read_text()


def test_quiet_is_quiet(plans, tmp_path, capsys):
    assert main(["reproduce", "--quick", "--quiet", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_section_that_fails_is_status_3(plans, tmp_path, capsys):
    assert main(["reproduce", "-o", str(tmp_path), "--quiet"]) == 3
    assert capsys.readouterr().err == "isoembed: error: failing: no surface was found\n"
    assert (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["taken", "taken/below", "x" * 300, "a\0b"])
def test_a_bad_folder_is_one_sentence(plans, tmp_path, capsys, name):
    (tmp_path / "taken").write_text("")
    assert main(["reproduce", "--quick", "-o", str(tmp_path / name)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("isoembed: error: cannot ")
    assert err.count("\n") == 1


def test_a_folder_is_needed(capsys):
    assert main(["reproduce"]) == 2
    assert "--output" in capsys.readouterr().err
