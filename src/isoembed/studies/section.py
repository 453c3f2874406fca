"""A section of the report: what a study leaves, with its figures, tables and comparisons."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Illustration:
    """A figure, the name of its files without the ending, and a caption of plain text."""

    name: str
    caption: str
    figure: Figure


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
    def of(cls, caption: str, columns: Mapping[str, str], rows: Iterable[Mapping[str, Any]]) -> Table:
        """The table of some records, with a format such as ``"{residual:.1e}"`` for each column."""
        formats = columns.values()
        return cls(caption, tuple(columns), tuple(tuple(f.format_map(row) for f in formats) for row in rows))


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
