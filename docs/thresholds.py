"""Write the tables of thresholds into the pages of this folder, from the code that uses them.

    python docs/thresholds.py [--check]

A table stands between ``<!-- thresholds: MODULE:NAME -->`` and ``<!-- end -->``; between
``<!-- thresholds -->`` and ``<!-- end -->`` stand those of the whole package.  With --check nothing is
written, and the exit status is 1 if a page is out of date.
"""

import re
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import isoembed
from isoembed.thresholds import rows

PAGES = sorted(Path(__file__).parent.glob("*.md"))
BLOCK = re.compile(r"(<!-- thresholds(?:: (\S+):(\S+))? -->\n).*?(<!-- end -->)", re.DOTALL)
BAR = r"\|"  # inside of a cell


def everywhere() -> Iterator[tuple[str, str, Any]]:
    """The module, name and value of all thresholds of the package, each at its home."""
    root = Path(isoembed.__file__).parent
    for file in sorted(root.rglob("*.py")):
        if "= threshold(" not in file.read_text(encoding="utf-8"):
            continue
        home = ".".join(("isoembed", *file.relative_to(root).with_suffix("").parts))
        for name, value in vars(import_module(home)).items():
            mine = type(value).__module__ == home and is_dataclass(value) and not isinstance(value, type)
            if mine and all("meaning" in each.metadata for each in fields(value)):
                yield home, name, value


def shown(value: Any) -> str:
    """A value as it is written in a table."""
    if isinstance(value, tuple):
        return ", ".join(f"({shown(each)})" if isinstance(each, tuple) else shown(each) for each in value)
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"


def table(thresholds: Any) -> str:
    """The table of one algorithm."""
    lines = ["| | value | unit | |", "|---|---|---|---|"]
    for name, value, unit, meaning in rows(thresholds):
        cells = (f"`{name}`", shown(value), unit, meaning)
        lines.append(f"| {' | '.join(cell.replace('|', BAR) for cell in cells)} |")
    return "\n".join([*lines, ""])


def whole() -> str:
    """The tables of the whole package, room by room."""
    parts, room = [], ""
    for module, name, value in everywhere():
        if module.split(".")[1] != room:
            room = module.split(".")[1]
            parts.append(f"## {room}\n")
        what = (type(value).__doc__ or name).strip().splitlines()[0]
        parts.append(f"**{what}** `{module}.{name}`\n\n{table(value)}")
    return "\n" + "\n".join(parts)


def current(page: str) -> str:
    """The text of a page with tables of today."""

    def block(match: re.Match[str]) -> str:
        module, name = match[2], match[3]
        return match[1] + (table(getattr(import_module(module), name)) if module else whole()) + match[4]

    return BLOCK.sub(block, page)


def main() -> int:
    """Write the pages, or say which are not of today."""
    stale = 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        if (new := current(text)) != text:
            stale = 1
            if "--check" in sys.argv[1:]:
                print(f"{page.name} has other thresholds than the code: run python docs/thresholds.py")
            else:
                page.write_text(new, encoding="utf-8")
    return stale if "--check" in sys.argv[1:] else 0


if __name__ == "__main__":
    sys.exit(main())
