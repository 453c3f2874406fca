"""Horizons followed from slice to slice."""

import numpy as np
import pytest

from isoembed import NoHorizon
from isoembed.relativity import BrillLindquist, find_horizon, find_horizons
from isoembed.relativity.horizons import tracking
from isoembed.relativity.horizons.tracking import track_horizons

END = 0.76619742824


def pair(d, axis=(0.0, 0.0, 1.0), masses=(0.5, 0.5)):
    x = 0.5 * d * np.array(axis)
    return BrillLindquist(masses, (tuple(x), tuple(-x)))


def test_a_common_horizon_appears_where_its_area_is_discontinuous():
    steps = list(track_horizons(pair(d) for d in (0.8, 0.78, END - 1e-3, 0.74)))
    first, second, *others = (step.continued for step in steps)
    assert first == (None, None) and sorted(second) == [0, 1]  # equal areas, whose order rounding decides
    assert others == [(None,), (0,)]
    common = steps[2].horizons[0]
    assert "may be discontinuous" in common.notes[-1]
    assert f"{steps[1].horizons[0].area:.6g}" in common.notes[-1]
    assert not steps[3].horizons[0].notes
    assert steps[3].horizons[0].area == pytest.approx(find_horizon(pair(0.74)).area, rel=1e-10)


def test_a_horizon_that_the_search_misses_is_continued(monkeypatch):
    """The search is made to find the horizons of the single holes alone, as a failed one would."""
    before, after = pair(0.72), pair(0.7)
    single = find_horizons(pair(0.8))
    monkeypatch.setattr(tracking, "find_horizons", lambda g: single if g is after else find_horizons(g))
    first, second = track_horizons((before, after))
    assert len(first.horizons) == len(second.horizons) == 1
    assert second.horizons[0].area == pytest.approx(find_horizon(after).area, rel=1e-10)
    assert second.continued == (0,)
    assert second.horizons[0].outermost.kind == "searched"
    assert "did not find it" in second.horizons[0].notes[-1]


@pytest.mark.slow
def test_horizons_about_a_turning_axis():
    turned = [(0.0, np.sin(a), np.cos(a)) for a in (0.3, 0.32)]
    first, second = track_horizons(pair(0.6, axis, (0.3, 0.7)) for axis in turned)
    assert second.continued == (0,)
    assert second.horizons[0].area == pytest.approx(first.horizons[0].area, rel=1e-11)


def test_nothing_found_is_an_answer_with_its_error(monkeypatch):
    def fails(geometry):
        raise NoHorizon("no horizon was found")

    monkeypatch.setattr(tracking, "find_horizons", fails)
    (step,) = track_horizons([pair(0.6)])
    assert step.horizons == ()
    assert "no horizon was found" in str(step.failure)
