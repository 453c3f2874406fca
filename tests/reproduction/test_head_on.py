"""Energies through a head-on merger."""

import pytest

from reproduction import head_on
from sections import check_section


def test_the_shooting_has_the_known_height_of_the_pole():
    top, curvature = head_on._shot(0.6)
    assert top == pytest.approx(0.603358540, abs=1e-9)
    assert curvature == pytest.approx(0.0301, abs=1e-4)  # the least K there


@pytest.mark.slow
def test_two_computations_of_the_flat_waist_agree():
    shot = head_on.flat_waist_by_shooting()
    assert head_on.flat_waist() == pytest.approx(shot, abs=1e-9)
    assert shot == pytest.approx(0.6278314169, abs=1e-9)


@pytest.mark.slow
def test_the_section(monkeypatch):
    few = {key: head_on.SHOT[key] for key in (((0.5, 0.5), 1.0, "individual"),)}
    monkeypatch.setattr(head_on, "SHOT", few)
    monkeypatch.setattr(head_on, "flat_waist", lambda: 0.6278314169)  # tested above
    section = head_on.study(separate=(2.0,), common=(0.5,), inner=False, expansions=(1e-2, 1e-3))
    check_section(section)
    numbers = section.numbers["published"]
    assert [one["agrees"] for one in numbers] == [True] * 3 + [False]  # the known place of the waist is off
    for one in section.numbers["constant_expansion"]:
        assert one["wang_yau"] == pytest.approx(one["liu_yau"], abs=1e-10)
        assert one["wang_yau"] < one["limit"]
