"""The tutorials run from top to bottom, with the asserts in their cells, and are kept without outputs."""

import json

import pytest

from pages import DOCS

TUTORIALS = sorted((DOCS / "tutorials").glob("*.ipynb"))


def cells(tutorial):
    return json.loads(tutorial.read_text(encoding="utf-8"))["cells"]


def code(cell):
    """The text of a cell without IPython's magics, which only show pictures."""
    return "".join("\n" if line.startswith("%") else line for line in cell["source"])


@pytest.mark.slow
@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda file: file.stem)
def test_a_tutorial_runs(tutorial, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space = {"__name__": "__main__"}
    asserts = 0
    for number, cell in enumerate(cells(tutorial)):
        if cell["cell_type"] == "code":
            exec(compile(code(cell), f"{tutorial.name}, cell {number}", "exec"), space)
            asserts += code(cell).count("assert ")
    assert asserts >= 3


@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda file: file.stem)
def test_a_tutorial_is_kept_without_outputs(tutorial):
    for cell in cells(tutorial):
        assert not cell.get("outputs") and cell.get("execution_count") is None


def test_there_are_tutorials():
    assert len(TUTORIALS) >= 3
