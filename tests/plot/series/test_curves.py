"""Numbers of a run against time: what is drawn is what the table says, with what is lost."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.plot.series.curves import series_figure, series_figures, write_series_figure
from isoembed.relativity.series.table import SeriesTable
from series_results import embedded, missing

pytest.importorskip("matplotlib.figure")


@pytest.fixture(scope="module")
def results():
    """Two series; one has a gap in the middle, and one that was killed."""
    there = [
        embedded(name, k, 0.5 * k) for name in ("ah1", "ah2") for k in range(5) if (name, k) != ("ah1", 3)
    ]
    return [
        *there,
        missing("ah1", 3, 1.5, "not embedded", "K < 0"),
        missing("ah2", 9, None, "failed", "killed"),
    ]


def labels(picture):
    return [axes.get_ylabel().split("\n")[0] for axes in picture.axes]


def texts(picture):
    return [text.get_text() for text in picture.legends[0].get_texts()]


def test_a_panel_has_a_line_for_each_series_interrupted_where_there_is_nothing(results):
    picture = series_figure(SeriesTable.of(results), ["liu_yau", "wang_yau", "axis"])
    assert labels(picture) == ["Kijowski-Liu-Yau", "axis of the spin", ""]  # of wang_yau nothing is known
    panel = picture.axes[0]
    first, second = (line for line in panel.lines if len(line.get_xdata()) > 2)
    assert np.allclose(
        first.get_ydata(), [1 / 3 + 0.5 * k if k != 3 else np.nan for k in range(5)], equal_nan=True
    )
    assert np.isfinite(second.get_ydata()).sum() == 5
    assert [line for line in panel.lines if line.get_xdata().tolist() == [2.0]]  # alone behind the gap


def test_the_band_is_as_wide_as_the_errors(results):
    table = SeriesTable.of(results)
    band = series_figure(table, ["liu_yau"]).axes[0].collections[0].get_paths()[0].vertices
    at_zero = band[band[:, 0] == 0.0, 1]
    assert at_zero.max() - at_zero.min() == pytest.approx(2e-9, rel=1e-6)


def test_what_is_lost_is_marked_on_the_axis_of_time(results):
    picture = series_figure(SeriesTable.of(results), ["area"])
    marks = {line.get_marker(): line.get_xdata().tolist() for line in picture.axes[-1].lines}
    assert marks["x"] == [1.5]
    assert [text for text in texts(picture) if "ah" not in text] == ["not embedded", "failed"]
    assert "ah2.t9" in picture.axes[-1].get_xlabel()  # its time is not known


def test_a_run_without_losses_has_no_marks():
    picture = series_figure(SeriesTable.of([embedded("ah1", k, k) for k in range(3)]), ["area"])
    assert len(picture.axes) == 1
    assert texts(picture) == ["ah1"]
    low, high = picture.axes[0].get_ylim()
    assert low < 12.5 < high < 12.501  # a constant is a line, not noise


def test_one_wild_error_does_not_flatten_the_lines(results):
    wild = embedded("ah1", 7, 3.5)
    wild.report["errors"]["liu_yau"] = 1e6
    picture = series_figure(SeriesTable.of([*results, wild]), ["liu_yau"])
    assert np.diff(picture.axes[0].get_ylim()) < 20
    assert "10^{6}" in picture.axes[0].get_title(loc="right")


def test_of_two_equal_series_both_are_seen():
    results = [embedded(name, k, k) for name in ("ah1", "ah2") for k in range(3)]
    first, second = series_figure(SeriesTable.of(results), ["area"]).axes[0].lines[:3:2]
    assert np.array_equal(first.get_ydata(), second.get_ydata())
    assert first.get_linewidth() > 1.5 * second.get_linewidth()


def test_without_times_there_are_iterations(results):
    for result in (none := [embedded("ah1", k, k) for k in (64, 128)]):
        result.report["moment"]["time"] = None
    picture = series_figure(SeriesTable.of(none), ["area"])
    assert picture.axes[0].get_xlabel() == "iteration"
    assert picture.axes[0].lines[0].get_xdata().tolist() == [64, 128]


def test_figures_of_a_run_are_those_with_something_to_see(results):
    assert set(series_figures(results)) == {"masses", "spin", "energies", "embedding"}
    assert not series_figures([missing("ah1", 3, None, "failed", "killed")])


def test_what_there_is_not_is_one_sentence(results):
    table = SeriesTable.of(results)
    with pytest.raises(InvalidParameter, match="there is no quantity 'mass'; there are area, "):
        series_figure(table, ["mass"])
    with pytest.raises(InvalidParameter, match="no horizon has a value of wang_yau"):
        series_figure(table, ["wang_yau"])


@pytest.mark.parametrize("end", ["png", "svg", "pdf"])
def test_the_same_table_makes_the_same_bytes(end, results, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    write_series_figure(tmp_path / f"one.{end}", SeriesTable.of(results), ["area"])
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "2000000000")  # what matplotlib takes as now
    write_series_figure(tmp_path / f"two.{end}", SeriesTable.of(results[::-1]), ["area"])
    assert (tmp_path / f"one.{end}").read_bytes() == (tmp_path / f"two.{end}").read_bytes()
