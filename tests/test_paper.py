"""The paper for the Journal of Open Source Software: its parts, its citations and its numbers."""

import re

import pytest

from pages import DOCS
from places import ROOT

PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
BIBLIOGRAPHY = (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")
ENTRIES = dict(re.findall(r"^@\w+\{(\w+),\n(.*?)^\}$", BIBLIOGRAPHY, re.MULTILINE | re.DOTALL))


def test_every_citation_is_in_the_bibliography_and_every_entry_is_cited():
    body = PAPER.split("\n---\n", 1)[1]
    cited = set(re.findall(r"(?<![\w.])@(\w+)", body))
    assert cited == set(ENTRIES) and len(cited) >= 15
    assert len(ENTRIES) == BIBLIOGRAPHY.count("\n@") + BIBLIOGRAPHY.startswith("@")


@pytest.mark.parametrize("key", ENTRIES)
def test_an_entry_can_be_looked_up(key):
    fields = dict(re.findall(r"^  (\w+) *= \{(.*)\},?$", ENTRIES[key], re.MULTILINE))
    assert fields["author"] and fields["title"]
    assert {"journal", "publisher", "booktitle", "school", "eprint", "url"} & fields.keys()
    if "doi" in fields:
        assert re.fullmatch(r"10\.\d{4,5}/\S+", fields["doi"])
    if "journal" in fields:
        assert fields["year"].isdigit() and fields["volume"]


def test_length_and_sections_are_those_that_the_journal_asks_for():
    body = PAPER.split("\n---\n", 1)[1]
    assert 750 <= len(body.split()) <= 1750
    sections = re.findall(r"^# (.*)$", body, re.MULTILINE)
    assert sections[:4] == ["Summary", "Statement of need", "State of the field", "Software design"]
    assert sections[-1] == "References"
    for picture in re.findall(r"\]\((\S+\.png)\)", body):
        assert (ROOT / "paper" / picture).is_file()


@pytest.mark.parametrize(
    ("number", "page"),
    [
        ("24 s, 2.0 GB", "large.md"),
        ("ten of ten for seven bodies, six to nine for the other five", "benchmarks.md"),
        ("500 of 500 | 500 of 500", "space-forms.md"),
        ("2e-14 and less", "benchmarks.md"),
        ("2e-13; within 1e-8", "benchmarks.md"),
        ("32 families", "benchmarks.md"),
        ("1,000 hulls of 8 to 100 vertices", "benchmarks.md"),
    ],
)
def test_its_numbers_are_those_of_the_documentation(number, page):
    assert number in (DOCS / page).read_text(encoding="utf-8")
