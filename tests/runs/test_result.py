"""Results, in memory and in files."""

import numpy as np
import pytest

from isoembed.io import FileError, write_atomically
from isoembed.runs import Result


def test_a_result_is_read_as_it_was_written(tmp_path):
    report = {
        "area": 1.1,
        "none": float("nan"),
        "axis": (np.float64(0.1), 2),
        "nested": {"n": np.int64(3)},
    }
    arrays = {"vertices": np.linspace(0.0, 1.0, 12).reshape(4, 3) / 3.0, "faces": np.arange(6).reshape(2, 3)}
    result = Result("ah1.t8", "embedded", report, arrays)
    path = tmp_path / "result.npz"
    write_atomically({path: result.writer})
    again = Result.read(path)
    assert (again.label, again.status, again.report) == ("ah1.t8", "embedded", result.report)
    assert again.report == {"area": 1.1, "none": None, "axis": [0.1, 2], "nested": {"n": 3}}
    assert again.arrays.keys() == arrays.keys() and again.answered
    for name, array in arrays.items():
        assert again.arrays[name].dtype == array.dtype
        np.testing.assert_array_equal(again.arrays[name], array)


def test_one_without_an_answer_says_why():
    result = Result.without_answer("ah1.t8", "refused", "there is no file h", name="h")
    assert not result.answered and result.message == "there is no file h"
    assert result.report == {"status": "refused", "message": "there is no file h", "name": "h"}


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"label": "a", "status": "b"}, "has no 'report'"),
        ({"label": "a", "status": "b", "report": "{"}, "its report is not JSON"),
        ({"label": np.array([1]), "status": "b", "report": "{}"}, "has no 'label'"),
    ],
)
def test_other_archives_are_refused(tmp_path, tables, message):
    np.savez(tmp_path / "other.npz", **tables)
    with pytest.raises(FileError, match=message):
        Result.read(tmp_path / "other.npz")
