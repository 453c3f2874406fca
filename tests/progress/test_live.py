"""The live view: what it shows of a running computation."""

import io
import subprocess
import sys
import time
import types

import pytest
from rich.console import Console
from rich.table import Table

import isoembed
import zoo
from isoembed import PolyhedralMetric
from isoembed.progress import live
from isoembed.progress.live import StageTable, duration
from isoembed.progress.stages import Progress


class Clock:
    """Stands until it is told to go on."""

    now = 100.0

    def __call__(self):
        return self.now


def shown(table):
    console = Console(file=io.StringIO(), width=100)
    console.print(table)
    return [line.split() for line in console.file.getvalue().splitlines() if line.strip()]


def test_it_shows_the_last_snapshot_of_each_stage():
    table = StageTable(Clock())
    table.listen(Progress("layout", 1, None, None, None, None, 0.5))
    table.listen(Progress("pull back", 1, 0.9, 1e-3, 4, 7, 1.0))
    table.listen(Progress("pull back", 2, 0.25, 2e-7, 0, 3, 3.5, level="1,000 vertices", remaining=4.1))
    heading, layout, pull_back, left = shown(table)
    assert heading == [
        "stage", "iteration", "level", "t", "residual", "inverted", "partially", "seconds",
    ]  # fmt: skip
    assert layout == ["layout", "1", "0.0"]
    assert pull_back == ["pull", "back", "2", "1,000", "vertices", "0.250", "2.0e-07", "0", "3", "2.5"]
    assert left == ["about", "5", "s", "left"]


def test_columns_are_shown_when_there_is_something_in_them():
    table = StageTable(Clock())
    assert shown(table) == []
    table.listen(Progress("layout", 1, None, None, None, None, 0.5))
    assert shown(table) == [["stage", "iteration", "seconds"], ["layout", "1", "0.0"]]
    table.listen(Progress("layout", 2, None, 0.1, None, None, 0.5))
    assert shown(table)[0] == ["stage", "iteration", "residual", "seconds"]


def test_the_clock_goes_on_until_the_end():
    clock = Clock()
    table = StageTable(clock)
    table.listen(Progress("layout", 1, None, None, None, None, 0.5))
    clock.now += 2
    assert shown(table)[1][-1] == "2.0"
    table.listen(Progress("pull back", 1, None, None, None, None, 2.5, remaining=8.0))
    clock.now += 3
    assert [line[-1] for line in shown(table)[1:3]] == ["0.0", "3.0"]
    assert shown(table)[3] == ["about", "5", "s", "left"]
    table.finish()
    clock.now += 100
    assert [line[-1] for line in shown(table)[1:]] == ["0.0", "3.0"]  # and nothing is left


# The bar


@pytest.fixture
def metric():
    return PolyhedralMetric.from_mesh(*zoo.icosphere(1))


def test_the_bar_shows_the_stages_on_a_terminal(metric):
    console = Console(file=io.StringIO(), force_terminal=True, width=100)
    with isoembed.progress.bar(console) as progress:
        surface = isoembed.embed(metric, progress=progress)
    text = console.file.getvalue()
    assert all(stage.name in text for stage in surface.stages)
    assert "left" not in text.splitlines()[-1]


def test_the_bar_needs_no_import_of_its_own():
    code = "import isoembed; isoembed.progress.bar().__enter__()"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_what_is_no_terminal_gets_the_last_state(metric, capfd):
    with isoembed.progress.bar() as progress:
        isoembed.embed(metric, progress=progress)
    out, err = capfd.readouterr()
    assert out == ""
    lines = err.splitlines()
    assert lines[0].split()[:2] == ["stage", "iteration"]
    assert sum(line.startswith("radii") for line in lines) == 1


def test_without_standard_error_the_bar_shows_nothing(metric, monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    with isoembed.progress.bar() as progress:
        assert isoembed.embed(metric, progress=progress).converged


def test_in_a_notebook_it_is_one_display_that_changes(monkeypatch):
    pages = []

    class Handle:
        def update(self, page):
            assert isinstance(page, Table)  # which a notebook shows as HTML
            pages.append(shown(page))

    def display(page, display_id):
        assert display_id is True
        handle = Handle()
        handle.update(page)
        return handle

    monkeypatch.setitem(sys.modules, "IPython", types.ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", types.SimpleNamespace(display=display))
    monkeypatch.setattr(live, "PAGES_A_SECOND", 1000)
    with isoembed.progress.bar(Console(force_jupyter=True)) as progress:
        progress(Progress("pull back", 1, None, None, None, None, 2.5, remaining=8.0))
        begun = time.monotonic()
        while not pages[-1] and time.monotonic() < begun + 120:
            time.sleep(0.01)
        assert pages[-1][-1] == ["about", "8", "s", "left"]
    assert pages[0] == []
    assert pages[-1][-1][:3] == ["pull", "back", "1"]
    seen = len(pages)
    time.sleep(0.02)
    assert len(pages) == seen  # the thread is over


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (-3, "1 s"),
        (0, "1 s"),
        (1.2, "2 s"),
        (10, "10 s"),
        (10.1, "15 s"),
        (55, "55 s"),
        (55.1, "1 min"),
        (61, "2 min"),
        (3540.0, "59 min"),
        (3540.1, "1 h 0 min"),
        (5000, "1 h 24 min"),
    ],
)
def test_durations(seconds, words):
    assert duration(seconds) == words
