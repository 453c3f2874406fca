"""A section of the report: what a study leaves, with its figures, tables and comparisons."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHAPTERS = Path(__file__).parent / "chapters"


@dataclass(frozen=True)
class Illustration:
    """A figure or the images of a film, the name of its file without the ending, and a plain caption."""

    name: str
    caption: str
    figure: Figure | Sequence[Figure]


@dataclass(frozen=True)
class Comparison:
    """One statement of the paper beside what is found here.

    Attributes
    ----------
    what : str
        What is stated, with the place in the paper.
    paper : str
        Its number or claim.
    here : str
        What is measured here.
    reason : str
        Why they differ; empty where they agree.
    """

    what: str
    paper: str
    here: str
    reason: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of text under a header."""

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @classmethod
    def of(cls, caption: str, columns: Iterable[Sequence[str]], rows: Iterable[Mapping[str, Any]]) -> Table:
        """The table of some records; each column has a heading and a format such as ``"{residual:.1e}"``."""
        header, formats = zip(*columns, strict=True)
        return cls(caption, header, tuple(tuple(form.format_map(row) for form in formats) for row in rows))


def listed(form: str, rows: Iterable[Mapping[str, Any]]) -> str:
    """One clause for each of some records, by a format such as ``"{name}: {residual:.1e}"``."""
    return "; ".join(form.format_map(row) for row in rows)


@dataclass(frozen=True)
class Section:
    """One study: paragraphs of plain text, figures, comparisons, tables, and numbers for ``numbers.json``."""

    title: str
    text: tuple[str, ...]
    figures: tuple[Illustration, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    tables: tuple[Table, ...] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        chapter: str,
        *,
        figures: Mapping[str, Figure | Sequence[Figure]],
        numbers: Mapping[str, Any],
        tables: Sequence[Table] = (),
        **values: Any,
    ) -> Section:
        """The section with the words of ``chapters/<chapter>.toml``.

        Parameters
        ----------
        chapter : str
        figures : mapping of str to matplotlib.figure.Figure, or to a sequence of them
            By the names under which the chapter has their captions.
        numbers : mapping
        tables : sequence of Table
            In place of those that the chapter defines.
        **values
            What the words name in braces, as `str.format` does.  Where a comparison or a table has ``each``,
            that names some records: `here` is said for each of them, and each is a row.
        """
        words = tomllib.loads((CHAPTERS / f"{chapter}.toml").read_text(encoding="utf-8"))

        def said(form: str) -> str:
            return " ".join(form.split()).format_map(values)

        def compared(what: str, paper: str, here: str, why: str = "", each: str = "") -> Comparison:
            found = listed(" ".join(here.split()), values[each]) if each else said(here)
            return Comparison(said(what), said(paper), found, said(why))

        def tabulated(caption: str, each: str, columns: Sequence[Sequence[str]]) -> Table:
            return Table.of(said(caption), [(said(name), form) for name, form in columns], values[each])

        return cls(
            said(words["title"]),
            tuple(map(said, words["text"].split("\n\n"))),
            tuple(Illustration(name, said(words["figures"][name]), each) for name, each in figures.items()),
            tuple(compared(**comparison) for comparison in words["comparisons"]),
            tuple(tables) or tuple(tabulated(**table) for table in words.get("tables", ())),
            numbers,
        )
