"""The folder of the report: what is written, what is refused."""

import inspect
import json

import pytest

from isoembed import NotEmbedded
from isoembed.io import FileError
from reproduction.reproduce import STUDIES, Study, reproduce
from sections import a_section


def studies(make=a_section, **sizes):
    return (Study("sizes", make, {}, sizes),)


def test_a_plan_leaves_a_report_figures_and_numbers(tmp_path):
    told = []
    folder = tmp_path / "a" / "b"
    (folder / "figures").mkdir(parents=True)
    (folder / "figures" / "squares.png").write_text("of an earlier run")
    outcome = reproduce(studies(title="sized"), folder, told.append, quick=True)
    assert outcome.report == folder / "report.html"
    assert outcome.failures == ()
    written = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    assert written == ["figures/squares.svg", "numbers.json", "report.html"]
    numbers = json.loads((folder / "numbers.json").read_text())
    assert numbers["plan"] == "quick"
    found = numbers["sections"]["sizes"]
    assert found["numbers"] == {"n": 3, "list": [1.0, None], "none": None}
    assert found["comparisons"][0]["paper"] == "0.62 %"
    assert str(tmp_path) not in (folder / "report.html").read_text() + json.dumps(numbers)
    assert told[0] == "1/1 sizes ..."
    assert told[1].startswith("1/1 sizes: ")


def test_a_section_that_fails_is_replaced_by_the_reason(tmp_path):
    def fails():
        raise NotEmbedded("it did not embed", None)

    outcome = reproduce(studies(fails), tmp_path, lambda line: None)
    assert outcome.failures == ("sizes: it did not embed",)
    assert "could not be made: it did not embed" in outcome.report.read_text()


def test_a_folder_that_is_a_file_is_refused_before_anything_is_made(tmp_path):
    (tmp_path / "taken").write_text("")

    def never():
        raise AssertionError("made too early")

    for folder in (tmp_path / "taken", tmp_path / "taken" / "below"):
        with pytest.raises(FileError, match=r"^cannot (write|make the folder) .*taken"):
            reproduce(studies(never), folder, lambda line: None)


@pytest.mark.parametrize("name", ["report.html", "numbers.json"])
def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_made(tmp_path, name):
    (tmp_path / name).mkdir()

    def never():
        raise AssertionError("made too early")

    with pytest.raises(FileError, match=rf"^cannot write .*{name}: it is a folder$"):
        reproduce(studies(never), tmp_path, lambda line: None)


def test_sizes_fit_their_studies():
    assert len({study.name for study in STUDIES}) == len(STUDIES) == 18
    for study in STUDIES:
        for sizes in (study.full, study.quick):
            inspect.signature(study.make).bind(**sizes)
