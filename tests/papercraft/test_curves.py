"""D-forms to be cut on the curve: arcs that lie on it, marks that meet, and the solid from the file."""

import math
import re

import numpy as np
import pytest
from scipy.special import ellipe

import isoembed
from isoembed import InvalidMetric, InvalidParameter
from isoembed.gluing import Ellipse, Stadium, circle, dform
from isoembed.io.input_file import InputFile
from isoembed.io.svg_lines import read_svg_lines
from isoembed.papercraft import write_dform


def lines_of(path):
    with InputFile(path) as file:
        return [line.points for line in read_svg_lines(file).lines if line.purpose == "cut"]


def length(points):
    return np.hypot(*np.diff(points, axis=0).T).sum()


@pytest.mark.parametrize("offset", [0.0, 0.13, 0.25])
def test_the_cuts_lie_on_the_curves(tmp_path, offset):
    write_dform(tmp_path / "d.svg", Ellipse(40, 20), Stadium(2, 1), offset=offset)
    ellipse, stadium = lines_of(tmp_path / "d.svg")
    perimeter = 4 * 40 * ellipe(1 - 0.25)
    assert [length(ellipse), length(stadium)] == pytest.approx([perimeter] * 2, rel=2e-4)
    x, y = (ellipse - (ellipse.min(axis=0) + ellipse.max(axis=0)) / 2).T
    assert (x / 40) ** 2 + (y / 20) ** 2 == pytest.approx(np.ones(len(x)), abs=1e-3)
    r = perimeter / (2 * math.pi + 4)
    x, y = (stadium - (stadium.min(axis=0) + stadium.max(axis=0)) / 2).T
    assert np.hypot(np.maximum(np.abs(x) - r, 0), y).max() == pytest.approx(r, rel=1e-3)
    text = (tmp_path / "d.svg").read_text()
    assert len(re.findall("A", re.findall(r'd="(M[^"]*Z)"', text)[0])) in (4, 5)


def test_marks_are_at_equal_lengths(tmp_path):
    write_dform(tmp_path / "d.svg", circle(30), circle(1), offset=0.5)
    with InputFile(tmp_path / "d.svg") as file:
        numbers = read_svg_lines(file).numbers
    assert [int(one.text) for one in numbers] == [*range(1, 13)] * 2
    for half, sign, begin in ((numbers[:12], 1, 0.0), (numbers[12:], -1, math.pi)):
        places = np.array([[one.x, one.y] for one in half])
        x, y = (places - places.mean(axis=0)).T
        turned = np.exp(1j * (begin + sign * 2 * np.pi * np.arange(12) / 12))
        assert (x + 1j * y) / abs(x + 1j * y) == pytest.approx(turned, abs=1e-3)


def test_the_solid_comes_back(tmp_path):
    write_dform(tmp_path / "d.svg", Ellipse(2, 1), circle(), scale=20, offset=0.25)
    solid = isoembed.embed(isoembed.glue(tmp_path / "d.svg"))
    same = isoembed.embed(dform(Ellipse(40, 20), circle(), offset=0.25, n=100))
    assert solid.volume == pytest.approx(same.volume, rel=5e-3)
    assert solid.area == pytest.approx(same.area, rel=5e-3)


def test_refusals(tmp_path):
    with pytest.raises(InvalidParameter, match="offset is 1, not a fraction of the perimeter"):
        write_dform(tmp_path / "d.svg", circle(), circle(), offset=1)
    with pytest.raises(InvalidParameter, match="scale is 0, not a positive finite number of mm"):
        write_dform(tmp_path / "d.svg", circle(), circle(), scale=0)
    (tmp_path / "d.svg").write_text(
        '<svg width="99mm" height="20mm" viewBox="0 0 99 20"><circle r="9" /><circle cx="50" r="9.1"/></svg>'
    )
    with pytest.raises(
        InvalidMetric, match=r"two curves that are glued all around are 56\.\d+ and 57\.\d+ mm long"
    ):
        isoembed.glue(tmp_path / "d.svg")
