"""HTML tables of an embedding's report."""

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

MARKS = {"converged": "yes", "best fit": "near"}  # CSS class of a status; "no" for all others
NONE, TIMES = "\N{EN DASH}", "\N{NO-BREAK SPACE}\N{MULTIPLICATION SIGN}\N{NO-BREAK SPACE}"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

INPUT = {
    "vertices": "vertices",
    "edges": "edges",
    "triangles": "faces",
    "vertices with a negative deficit": "negative_deficits",
}
MEASURES = {
    "area": "area",
    "volume": "volume",
    "∫ <i>H</i> d<i>A</i>, <i>H</i> = (<i>k</i>₁ + <i>k</i>₂)/2": "integrated_mean_curvature",
}

Rows = Iterable[tuple[str, str | float | None]]


def report_html(report: Mapping[str, Any]) -> str:
    """HTML tables of a report.

    Parameters
    ----------
    report : mapping
        Output of `isoembed.report`.
    """
    inputs, residual, convexity = report["input"], report["residual"], report["convexity"]
    paths = [("along the given edges", residual["paths"])] if "paths" in residual else []
    space = report["space"]
    curved = (
        [("space", space["name"]), ("curvature of space", space["curvature"])] if space["curvature"] else []
    )
    found = [
        ("method", f'<span class="words">{escape(report["method"])}</span>'),
        ("tolerance", report["tolerance"]),
        *curved,
        *((name, inputs[key]) for name, key in INPUT.items()),
    ]
    errors = [("mean", residual["mean"]), ("standard deviation", residual["std"])]
    measures = [(name, report[key]) for name, key in MEASURES.items()]
    columns = ("distance", "roughness")
    others = [tuple(number(other[key]) for key in columns) for other in report["other_realizations"]]
    parts = [
        f'<p class="status {MARKS.get(report["status"], "no")}">{escape(report["status"])}</p>',
        f'<p class="message">{escape(report["message"])}</p>',
        _table("How it was found", found),
        _table("Length errors, in mean edge lengths", [("largest", residual["max"]), *paths, *errors]),
        _table("Convexity", [(_words(key), value) for key, value in convexity.items()]),
        _table("Measures, in the unit of the lengths", measures),
        _table("Smoothness", [(_words(key), value) for key, value in report["smoothness"].items()]),
        grid("Stages", ("stage", "seconds", "steps", "factor&shy;izations"), _stages(report["stages"])),
        grid("Other realizations of these lengths", columns, others),
    ]
    keys = ("deviation", "best_fit", "sheet", "polyhedron", "certificate", "repair")
    parts.append(tables_html({key: report[key] for key in keys if report.get(key)}))
    return "\n".join(part for part in parts if part)


def tables_html(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """HTML tables of nested entries, captioned by their keys."""
    return "\n".join(_table(_words(key).capitalize(), _flattened(table)) for key, table in tables.items())


def number(value: float | None) -> str:
    """Number with at most six digits, in scientific notation if it is far from 1."""
    if value is None:
        return NONE
    if isinstance(value, int):
        return f"{value:,}"
    text = f"{value:.6g}" if value == 0 or 1e-3 <= abs(value) < 1e6 else f"{value:.3g}"
    digits, _, power = text.partition("e")
    digits = digits.replace("-", "\N{MINUS SIGN}")
    return f"{digits}{TIMES}10{str(int(power)).translate(RAISED)}" if power else digits


def _stages(stages: Iterable[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    return [
        (
            escape(stage["name"]),
            f"{stage['seconds']:.2f}",
            number(stage["iterations"]),
            number(stage["factorizations"]),
        )
        for stage in stages
    ]


def _flattened(entries: Mapping[str, Any], above: str = "") -> list[tuple[str, str | float | None]]:
    """Rows of nested entries; lists are represented by their lengths."""
    rows: list[tuple[str, str | float | None]] = []
    for key, value in entries.items():
        name = f"{above}{_words(key)}"
        if isinstance(value, Mapping):
            rows += _flattened(value, f"{name}, ")
        elif isinstance(value, bool):
            rows.append((name, "yes" if value else "no"))
        elif isinstance(value, str):
            rows.append((name, f'<span class="words">{escape(value)}</span>'))
        else:
            rows.append((name, len(value) if isinstance(value, list) else value))
    return rows


def _words(key: str) -> str:
    return escape(key.replace("_", " "))


def _table(caption: str, rows: Rows) -> str:
    """HTML table with one row per entry: text unchanged, or a formatted number."""
    texts = [(name, value if isinstance(value, str) else number(value)) for name, value in rows]
    body = "".join(f'<tr><th scope="row">{name}</th><td>{text}</td></tr>' for name, text in texts)
    return f"<table><caption>{caption}</caption>{body}</table>"


def grid(caption: str, heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """HTML table with one line per entry; empty if there are none."""
    if not rows:
        return ""
    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    body = "".join(f"<tr>{''.join(f'<td>{value}</td>' for value in row)}</tr>" for row in rows)
    return (
        f'<table class="grid"><caption>{caption}</caption><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )
