"""The table of a run: rows by series and time, in CSV and HDF5, with nothing lost and nothing invented."""

import csv
import time

import numpy as np
import pytest

from isoembed.io import FileError
from isoembed.relativity.series.table import TEXTS, UNITS, SeriesTable, table_writer, write_table
from isoembed.smooth import Start
from series_results import embedded, missing


@pytest.fixture(scope="module")
def results():
    """Two horizons of which one is lost, in no order."""
    killed = missing("ah2", 20, None, "failed", 'its worker, "w,1", was killed\nby the system')
    return [
        embedded("ah10", 20, 1.0),
        embedded("ah2", 10, 0.1 + 0.2),
        embedded("ah10", 5, 0.25),
        killed,
        missing("ah2", 30, 2.0, "not embedded", "K < 0 at a pole"),
    ]


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_rows_are_sorted_by_series_and_time(results, tmp_path):
    write_table(tmp_path / "t.csv", results)
    found = rows(tmp_path / "t.csv")
    assert [row["label"] for row in found] == ["ah2.t10", "ah2.t20", "ah2.t30", "ah10.t5", "ah10.t20"]
    assert list(found[0]) == ["series", *UNITS, *TEXTS]


def test_numbers_are_read_as_they_were(results, tmp_path):
    write_table(tmp_path / "t.csv", results)
    for row in rows(tmp_path / "t.csv"):
        report = next(result.report for result in results if result.label == row["label"])
        if report["status"] != "embedded":
            continue
        assert float(row["time"]) == report["moment"]["time"]
        assert row["iteration"] == str(report["moment"]["iteration"])
        assert float(row["J"]) == report["spin"]["J"]
        assert float(row["J_error"]) == report["spin"]["error"]
        assert [float(row[f"axis_{x}"]) for x in "xyz"] == report["spin"]["axis"]
        for name in ("area", "christodoulou_mass", "liu_yau"):
            assert float(row[name]) == report[name]
            assert float(row[f"{name}_error"]) == report["errors"][name]
        assert float(row["residual"]) == report["embedding"]["residual"]
        assert float(row["space_curvature"]) == report["space"]["curvature"]
        assert row["wang_yau_admissible"] == {None: "", True: "1"}[report.get("wang_yau_admissible")]
        assert row["degree"] == str(report["embedding"]["degree"])


def test_what_is_not_known_is_empty_and_says_why(results, tmp_path):
    write_table(tmp_path / "t.csv", results)
    _, killed, unembedded, *_ = rows(tmp_path / "t.csv")
    assert killed["reason"] == 'its worker, "w,1", was killed\nby the system'
    assert killed["time"] == "1.0"  # of the other horizon at this iteration
    assert all(killed[name] == "" for name in UNITS if name not in ("time", "iteration"))
    assert unembedded["status"] == "not embedded"
    assert unembedded["area"] == "12.5"
    assert unembedded["liu_yau"] == unembedded["degree"] == ""


def test_hdf5_holds_the_columns_and_the_surfaces(results, tmp_path):
    h5py = pytest.importorskip("h5py")
    write_table(tmp_path / "t.h5", results)
    with h5py.File(tmp_path / "t.h5") as file:
        assert set(file) == {"ah2", "ah10"}
        group = file["ah2"]
        assert group["time"][()].tolist() == [0.1 + 0.2, 1.0, 2.0]
        assert group["iteration"][()].tolist() == [10, 20, 30]
        assert group["degree"][()].tolist() == [2, -1, -1]
        assert np.array_equal(group["area"][()], [12.5, np.nan, 12.5], equal_nan=True)
        assert group["area"].attrs["unit"] == b"length^2"
        assert group[group["area"].attrs["error"]][0] == 1e-9
        assert group["status"].asstr()[()].tolist() == ["embedded", "failed", "not embedded"]
        assert group["reason"].asstr()[2] == "K < 0 at a pole"
        assert list(group["surfaces"]) == ["ah2.t10"]
        surface = group["surfaces/ah2.t10"]
        arrays = {f"surface/{name}": data[()] for name, data in surface["surface"].items()}
    restored = Start.restored(arrays)
    assert (restored.harmonics.degree, restored.harmonics.order) == (2, 2)
    assert np.array_equal(restored.coefficients, results[1].arrays["surface/coefficients"])


@pytest.mark.parametrize("end", ["csv", "h5"])
def test_the_same_results_make_the_same_bytes(end, results, tmp_path):
    pytest.importorskip("h5py")
    write_table(tmp_path / f"one.{end}", results)
    time.sleep(1.01)  # a time stamp would be another
    write_table(tmp_path / f"two.{end}", iter(results[::-1]))
    assert (tmp_path / f"one.{end}").read_bytes() == (tmp_path / f"two.{end}").read_bytes()


def test_a_table_of_nothing_has_its_heads(tmp_path):
    table = SeriesTable.of([])
    table_writer("t.csv", table)(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text().split(",")[0] == "series"
    assert not rows(tmp_path / "t.csv")


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"has the ending '.txt'"):
        write_table(tmp_path / "t.txt", [])
