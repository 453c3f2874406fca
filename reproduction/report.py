"""The report: sections as one page of HTML that loads nothing from anywhere."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from html import escape
from io import BytesIO
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import __version__
from reproduction.section import Comparison, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 200
HEAVY = 3000  # polygons and markers: a figure of so many is smaller as pixels
TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}
IMAGE, REST = 0.2, 2.0  # seconds that an image of a film is seen, and the last one
FILM_DPI = 80
PART = re.compile(r"; (?![^()]*\))")  # a semicolon that is not in parentheses
SPOKEN = 2  # powers of ten up to which a number is not written in them
WORD, LONG = re.compile(r"[A-Za-z]{2}"), 22  # how a cell of a column of words begins; when it is broken
POWER = re.compile(r"(?<=[A-Za-z0-9)])\^(-?\d+(?:\.\d+)?)")
EXPONENT = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?)0*(\d+)(?![\w.]*\w)")
INTEGRAL = re.compile(r"\bint (H[^ ]*) dA")
SUBSCRIPT = re.compile(r"\b([A-Za-z]|rho)_(\w+)")
NEGATIVE = re.compile(r"(?<![\w.)])-(?=\.?\d)")


@dataclass(frozen=True)
class Image:
    """A figure as a file.

    Attributes
    ----------
    ending : str
        ``".svg"``, or ``".png"`` for a figure of many triangles; ``".gif"`` for a film.
    data : bytes
    """

    ending: str
    data: bytes

    @property
    def uri(self) -> str:
        """The image itself as an address."""
        return f"data:{TYPES[self.ending]};base64,{b64encode(self.data).decode('ascii')}"


@dataclass(frozen=True)
class Made:
    """A section as it goes into the report.

    Attributes
    ----------
    name : str
        For links.
    sizes : mapping
        What it was made at.
    section : Section
    images : mapping of str to Image
        Its figures, by their names.
    seconds : float
        How long it took.
    """

    name: str
    sizes: Mapping[str, Any]
    section: Section
    images: Mapping[str, Image]
    seconds: float


def rendered(figure: Figure | Sequence[Figure]) -> Image:
    """Draw a figure, the same bytes every time: as vectors, or as pixels if it has many parts; or a film."""
    from matplotlib import rc_context

    if isinstance(figure, Sequence):
        return Image(".gif", _film(figure))
    ending = ".svg" if _marks(figure) < HEAVY else ".png"
    metadata = {"Date": None, "Creator": None} if ending == ".svg" else {}
    buffer = BytesIO()
    with rc_context({"svg.hashsalt": "isoembed"}):
        figure.savefig(
            buffer, format=ending[1:], dpi=DPI, bbox_inches="tight", pad_inches=0.05, metadata=metadata
        )
    return Image(ending, buffer.getvalue())


def _film(figures: Sequence[Figure]) -> bytes:
    """The images one after the other, again and again."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image as Pillow

    images = []
    for figure in figures:
        figure.set_dpi(FILM_DPI)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3]
        images.append(Pillow.fromarray(pixels).quantize(128, method=Pillow.Quantize.FASTOCTREE))
    times = [round(1000 * IMAGE)] * (len(images) - 1) + [round(1000 * REST)]
    buffer = BytesIO()
    images[0].save(buffer, format="GIF", save_all=True, append_images=images[1:], duration=times, loop=0)
    return buffer.getvalue()


def _marks(figure: Figure) -> int:
    """How many polygons and markers a figure has."""
    polygons = sum(len(each.get_paths()) for axes in figure.axes for each in axes.collections)
    lines = [line for axes in figure.axes for line in axes.lines if line.get_marker() not in ("None", "")]
    return polygons + sum(np.size(line.get_xdata()) for line in lines)


def page(made: Sequence[Made], plan: str) -> str:
    """Write the page.

    Parameters
    ----------
    made : sequence of Made
        In the order of the page.
    plan : str
        Which sizes were chosen, in a word.

    Returns
    -------
    str
        HTML: a table of contents, all comparisons in one table, and the sections.
    """
    here = Path(__file__).parent
    total = sum(one.seconds for one in made)
    return Template(here.joinpath("report.html").read_text(encoding="utf-8")).substitute(
        style=here.joinpath("report.css").read_text(encoding="utf-8"),
        facts=f"isoembed {escape(__version__)}, {escape(plan)} plan, {total:.0f} s. H = (k<sub>1</sub> + "
        "k<sub>2</sub>)/2 everywhere. Seconds are of the machine that made this page; everything else should "
        "come out the same on any.",
        contents="\n".join(
            [
                '<li><a href="#summary">Number by number</a></li>',
                *(f'<li><a href="#{escape(one.name)}">{text(one.section.title)}</a></li>' for one in made),
            ]
        ),
        summary=_summary(made),
        sections="\n".join(map(_section, made)),
    )


def text(plain: str) -> str:
    """Escape plain text, and set powers, integrals, subscripts and signs: ``N^-1``, ``int H dA``, ``t_f``."""
    html = (
        escape(plain)
        .replace("&lt;=", "\N{LESS-THAN OR EQUAL TO}")
        .replace("&gt;=", "\N{GREATER-THAN OR EQUAL TO}")
    )
    html = POWER.sub(lambda found: f"<sup>{_signed(found[1])}</sup>", html)
    html = EXPONENT.sub(_ten, html)
    html = SUBSCRIPT.sub(r"\1<sub>\2</sub>", html).replace("kbar", "k\N{COMBINING MACRON}")
    html = INTEGRAL.sub("\N{INTEGRAL}\N{NO-BREAK SPACE}\\1\N{NO-BREAK SPACE}dA", html)
    return NEGATIVE.sub("\N{MINUS SIGN}", html)


def _ten(found: re.Match[str]) -> str:
    """A number in powers of ten, or as it is spoken if that is short."""
    digits, sign, power = found.groups()
    if float(digits) == 0:
        return "0"
    if int(power) <= SPOKEN:
        return format(Decimal(found[0]), "f")
    front = "" if digits == "1" else f"{digits}\N{NO-BREAK SPACE}\N{MULTIPLICATION SIGN}\N{NO-BREAK SPACE}"
    return f"{front}10<sup>{_signed(sign.strip('+') + power)}</sup>"


def _signed(number: str) -> str:
    return number.replace("-", "\N{MINUS SIGN}")


def _summary(made: Sequence[Made]) -> str:
    rows = []
    for one in made:
        if one.section.comparisons:
            link = f'<a href="#{escape(one.name)}">{text(one.section.title)}</a>'
            rows.append(f'<tr><th colspan="4" scope="rowgroup">{link}</th></tr>')
            rows.extend(map(_compared, one.section.comparisons))
    return (
        '<table class="compared"><colgroup><col class="what"><col class="paper"><col><col></colgroup>\n'
        '<thead><tr><th scope="col">what</th><th scope="col">paper</th><th scope="col">here</th>'
        '<th scope="col">why they differ</th></tr></thead>\n'
        f"<tbody>\n{chr(10).join(rows)}\n</tbody></table>"
    )


def _compared(one: Comparison) -> str:
    why = text(one.reason) or '<span class="agree">they agree</span>'
    here = "<br>".join(map(text, PART.split(one.here)))
    return (
        f'<tr><th scope="row">{text(one.what)}</th><td data-label="paper">{text(one.paper)}</td>'
        f'<td data-label="here">{here}</td><td data-label="why">{why}</td></tr>'
    )


def _section(one: Made) -> str:
    parts = [f"<h2>{text(one.section.title)}</h2>", *(f"<p>{text(part)}</p>" for part in one.section.text)]
    for figure in one.section.figures:
        image = one.images[figure.name]
        shown = f'<img src="{image.uri}" alt="{escape(figure.caption)}">'
        if image.ending == ".gif":  # what moves must not begin by itself
            shown = f"<details><summary>Film</summary>{shown}</details>"
        parts.append(f"<figure>{shown}<figcaption>{text(figure.caption)}</figcaption></figure>")
    parts.extend(map(_table, one.section.tables))
    parts.append(f'<p class="took">{one.seconds:.1f} s</p>')
    return f'<section id="{escape(one.name)}">\n{chr(10).join(parts)}\n</section>'


def _table(table: Table) -> str:
    columns = zip(table.header, *table.rows, strict=True)
    worded = [any(WORD.match(cell) for cell in cells) for _, *cells in columns]
    head = "".join(_cell("th", cell, words) for cell, words in zip(table.header, worded, strict=True))
    rows = "\n".join(
        f"<tr>{''.join(_cell('td', cell, words) for cell, words in zip(row, worded, strict=True))}</tr>"
        for row in table.rows
    )
    content = f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>"
    return (
        f"<figure><figcaption>{text(table.caption)}</figcaption>\n"
        f'<div class="scroll"><table class="numbers">\n{content}</table></div></figure>'
    )


def _cell(tag: str, content: str, words: bool) -> str:
    """A cell: words to the left, where they may be broken; numbers to the right, where not."""
    kinds = " ".join(["words"] * words + ["long"] * (words and len(content) > LONG))
    return f"<{tag}{f' class={chr(34)}{kinds}{chr(34)}' if kinds else ''}>{text(content)}</{tag}>"
