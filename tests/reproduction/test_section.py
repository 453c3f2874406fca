"""Sections made from the words of a chapter."""

import pytest

from reproduction import section
from reproduction.reproduce import STUDIES
from reproduction.section import CHAPTERS, Comparison, Section, Table

WORDS = '''
title = "Size {n}"
text = """
One
line.

Another."""

[figures]

[[comparisons]]
what = "sizes"
paper = "1"
each = "bodies"
here = "{name}: {size:.1f}"

[[tables]]
caption = "{n} bodies"
each = "bodies"
columns = [["N = {n}", "{name}"], ["size", "{size:g}"]]
'''
BODIES = [{"name": "a", "size": 1}, {"name": "b", "size": 2}]


def test_a_chapter_is_filled_in(monkeypatch, tmp_path):
    (tmp_path / "tiny.toml").write_text(WORDS)
    monkeypatch.setattr(section, "CHAPTERS", tmp_path)
    made = Section.of("tiny", figures={}, numbers={}, n=3, bodies=BODIES)
    assert made.title == "Size 3"
    assert made.text == ("One line.", "Another.")
    assert made.comparisons == (Comparison("sizes", "1", "a: 1.0; b: 2.0"),)
    assert made.tables == (Table("3 bodies", ("N = 3", "size"), (("a", "1"), ("b", "2"))),)
    with pytest.raises(KeyError, match="bodies"):
        Section.of("tiny", figures={}, numbers={}, n=3)


def test_every_study_has_its_chapter():
    chapters = {path.name for path in CHAPTERS.iterdir()}
    assert chapters == {f"{study.name}.toml" for study in STUDIES}
