"""Sections of the report: one that is made up, and what every one has to be."""

import json

import pytest

pytest.importorskip("matplotlib")

import numpy as np

from reproduction import plots
from reproduction.report import rendered
from reproduction.section import Comparison, Illustration, Section, Table

STARTS = {".svg": b"<?xml", ".png": b"\x89PNG", ".gif": b"GIF89a"}
UNSAFE = "<script>alert('&')</script> \"quoted\""


def check_section(section):
    json.dumps(section.numbers, allow_nan=False)
    assert section.title
    assert section.text
    assert section.comparisons
    for illustration in section.figures:
        image = rendered(illustration.figure)
        assert image.data.startswith(STARTS[image.ending])
    for table in section.tables:
        assert all(len(row) == len(table.header) for row in table.rows)
    names = [illustration.name for illustration in section.figures]
    assert len(set(names)) == len(names)


def squares(n):
    from matplotlib.collections import PolyCollection

    figure = plots.blank(1.0)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    figure.add_subplot().add_collection(PolyCollection([corners + k for k in range(n)]))
    return figure


def a_section(**changes):
    parts = {
        "title": "Sizes & shapes",
        "text": (UNSAFE, "of order N^-1.02, int H dA to 2e-07"),
        "figures": (Illustration("squares", UNSAFE, squares(3)),),
        "comparisons": (Comparison(UNSAFE, "0.62 %", "-0.04 % (here; there); N^2", ""),),
        "tables": (Table("a table", ("N", "error"), (("100", "1e-6"), ("200", UNSAFE))),),
        "numbers": {"n": np.int64(3), "list": np.array([1.0, np.nan]), "none": float("inf")},
    }
    return Section(**(parts | changes))
