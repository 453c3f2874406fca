"""Write the tables of thresholds into ``thresholds.md``, from the code that uses them.

    python docs/thresholds.py [--check]

They stand between ``<!-- thresholds -->`` and ``<!-- end -->``.  With --check nothing is written, and the
exit status is 1 if the page is out of date.
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

PAGE = Path(__file__).with_suffix(".md")
BLOCK = re.compile(r"(?<=<!-- thresholds -->\n).*?(?=<!-- end -->)", re.DOTALL)
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
    """The tables of the whole package, one subpackage after the other."""
    parts, package = [], ""
    for module, name, value in everywhere():
        if module.split(".")[1] != package:
            package = module.split(".")[1]
            parts.append(f"## {package}\n")
        what = (type(value).__doc__ or name).strip().splitlines()[0]
        parts.append(f"**{what}** `{module}.{name}`\n\n{table(value)}")
    return "\n" + "\n".join(parts)


def current(page: str) -> str:
    """The text of the page with tables of today."""
    tables = whole()
    return BLOCK.sub(lambda _: tables, page)


def main() -> int:
    """Write the page, or say that it is not of today."""
    text = PAGE.read_text(encoding="utf-8")
    new = current(text)
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(new, encoding="utf-8")
    elif new != text:
        print(f"{PAGE.name} has other thresholds than the code: run python docs/thresholds.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
