"""What a study leaves: a section of the report, with its figures, tables and comparisons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Illustration:
    """A figure with its name and caption.

    Attributes
    ----------
    name : str
        Of its files, without the ending.
    caption : str
        One or more sentences; plain text.
    figure : matplotlib.figure.Figure
    """

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


@dataclass(frozen=True)
class Section:
    """One study.

    Attributes
    ----------
    title : str
    text : tuple of str
        Paragraphs, plain text.
    figures : tuple of Illustration
    comparisons : tuple of Comparison
    tables : tuple of Table
    numbers : mapping of str to JSON values
        All that was measured, for ``numbers.json``.
    """

    title: str
    text: tuple[str, ...]
    figures: tuple[Illustration, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    tables: tuple[Table, ...] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)
