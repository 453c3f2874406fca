"""Moments: their times and their labels."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity import Moment


@pytest.mark.parametrize("time", [np.float32(0.5), np.int64(1), 2])
def test_times_are_numbers_of_python(time):
    moment = Moment("ah1", time, None, None)
    assert type(moment.time) is float and moment.time == time


@pytest.mark.parametrize("time", [np.nan, np.inf, "abc", [1.0, 2.0]])
def test_other_times_are_refused(time):
    with pytest.raises(InvalidParameter, match=r"^the time of ah1 is .*, not a finite number$"):
        Moment("ah1", time, None, None)


def test_labels():
    assert Moment("ah 1", 0.25, 64, None).label == "ah_1.t64"
    assert Moment("ah1", 0.1 + 0.2, None, None).label == "ah1.T0.3"
    assert Moment("ah1", None, None, None, position=3).label == "ah1.3"
    assert Moment("ah1", None, None, None).label == "ah1"
