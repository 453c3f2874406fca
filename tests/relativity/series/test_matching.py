"""Horizons and slices of one moment find each other."""

from dataclasses import dataclass

import pytest

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.relativity.series.matching import matched
from isoembed.relativity.series.moment import ListedSlice, Moment


@dataclass(frozen=True)
class Named:
    name: str


def shape(series, iteration=None, time=None):
    return Moment(series, time, iteration, Named(f"{series}-{iteration}-{time}"))


def slice_(iteration=None, time=None):
    return ListedSlice(iteration, time, Named(f"slice-{iteration}-{time}"))


def found(shapes, slices):
    return [(moment.label, moment.slice.name) for moment in matched(shapes, slices)]


def test_iterations_go_before_times():
    shapes = [shape("ah10", 8, 0.5), shape("ah2", 8, 0.5), shape("ah2", 0, 0.0), shape("ah2", 4)]
    slices = [slice_(4, 0.25), slice_(8, 0.5001), slice_(0)]
    assert found(shapes, slices) == [
        ("ah2.t0", "slice-0-None"),
        ("ah2.t4", "slice-4-0.25"),
        ("ah2.t8", "slice-8-0.5001"),
        ("ah10.t8", "slice-8-0.5001"),
    ]


def test_numbers_that_are_no_iterations_are_told_by_their_times():
    moments = matched([shape("ah1", k, 0.5 * k) for k in range(3)], [slice_(0, 0.0), slice_(1, 32.0)])
    assert [moment.slice.name for moment in moments] == ["slice-0-0.0", "no slice", "no slice"]
    with pytest.raises(
        FileError, match=r"^ah1 at iteration 1 \(.*\) is at t = 0\.5, but the slice of this .* t = 32$"
    ):
        moments[1].slice.read(None, None)


def test_times_as_they_are_printed():
    """The Einstein Toolkit prints three digits: 0.031 is 1/32."""
    shapes = [shape("ah1", k, round(k / 32, 3)) for k in range(8)]
    slices = [slice_(time=k / 32) for k in (5, 1, 0)]
    names = dict(found(shapes, slices))
    assert {label for label, name in names.items() if name != "no slice"} == {"ah1.t0", "ah1.t1", "ah1.t5"}
    assert names["ah1.t5"] == "slice-None-0.15625"


def test_one_slice_and_one_horizon_match_only_at_the_same_time():
    assert found([shape("a", time=0.3)], [slice_(time=0.1 + 0.2)]) == [("a.T0.3", f"slice-None-{0.1 + 0.2}")]
    assert found([shape("a", time=0.3)], [slice_(time=0.3001)])[0][1] == "no slice"


@pytest.mark.parametrize(
    ("one", "slices", "sentence"),
    [
        (shape("ah1", 7), [], r"no slice for ah1 at iteration 7 \(ah1-7-None\): there are no slices"),
        (shape("ah1", 7), [slice_(4), slice_(6)], "slices are at iterations 4, 6$"),
        (shape("ah1", 7), [slice_(k) for k in range(0, 20, 2)], r"0, 2, ..., 18 \(10 of them\)$"),
        (shape("ah1", 7, 0.75), [slice_(time=1.0)], r"ah1 at t = 0\.75 \(.*\): slices are at t = 1$"),
        (shape("ah1", 7), [slice_(time=1.0)], "ah1 at iteration 7 .*: slices are at t = 1$"),
        (shape("ah1"), [slice_(3, 1.5)], r"no slice for ah1 \(.*\): slices are at iterations 3 and t = 1.5$"),
        (shape("ah1", time=2.0), [slice_(3)], r"ah1 at t = 2 \(.*\): slices are at iterations 3$"),
        (shape("ah1", 1), [slice_()], "the slices have neither iteration nor time$"),
    ],
)
def test_a_horizon_without_a_slice(one, slices, sentence):
    (moment,) = matched([one], slices)
    with pytest.raises(FileError, match=sentence):
        moment.slice.read(None, None)


@pytest.mark.parametrize(
    ("shapes", "slices", "sentence"),
    [
        ([shape("ah1", 7, 0.5), shape("ah1", 7)], [], "ah1-7-0.5 and ah1-7-None are both ah1 at iteration 7"),
        ([shape("a", time=0.5), shape("a", time=0.5)], [], "are both a at t = 0.5: keep one"),
        ([], [slice_(3, 1.0), slice_(3)], "slice-3-1.0 and slice-3-None are both slices of iteration 3"),
        ([], [slice_(time=1.0), slice_(time=1.0 + 1e-13)], "are both slices of t = 1: keep one"),
    ],
)
def test_what_is_there_twice(shapes, slices, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        matched(shapes, slices)
