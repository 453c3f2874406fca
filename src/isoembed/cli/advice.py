"""Translation of Python arguments in messages to command-line options."""

import re
import shlex
from ast import literal_eval
from collections.abc import Callable
from pathlib import Path

NUMBER = r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
ESCAPED = r"(?:[^\\\n]|\\[\\'\"tnr]|\\x[0-9a-f]{2}|\\u[0-9a-f]{4}|\\U00(?:0[0-9a-f]|10)[0-9a-f]{4})+?"
PATH = rf"((?:'{ESCAPED}'|\"{ESCAPED}\")(?=\)))"  # as repr writes it


def command(*words: str | Path) -> str:
    """``isoembed`` with these words, in quotes, as a shell takes it, also with blanks in file names."""
    line = shlex.join(["isoembed", *map(str, words)])
    return f"`{line}`" if "'" in line else f"'{line}'"


OPTIONS: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (rf"(?:method=)?Alexandrov\(repair={NUMBER}\)", r"--method alexandrov --repair \1"),
    (rf"(?:method=)?Aim\(effort={NUMBER}\)", r"--effort \1"),
    (r"(?:method=)?Aim\(best_fit=True\)", "--best-fit"),
    (r'method="(\w+)"', r"--method \1"),
    (r"boundary='(\w+)'", r"--boundary \1"),
    (rf"(merge|tolerance|curvature|scale|size)={NUMBER}", r"--\1 \2"),
    (rf"size=\('([xyz])', {NUMBER}\)", r"--size \1=\2"),
    (r"(paper|joints)='(\w+)'", r"--\1 \2"),
    (r"(cut|keep)\[\d+\] \((\d+), (\d+)\)", r"--\1 \2-\3"),
    (r"marginal=True", "--marginal"),
    (r"marginal=False", "--not-marginal"),
    (r"geometry=", "--geometry"),
    (r"start=", "--start"),
    (r"isoembed\.realizations\(embedding\)", "isoembed realizations SURFACE"),
    (
        rf"isoembed\.(embed|glue)\({PATH}\)",
        lambda found: command(found[1], literal_eval(found[2]), "-o", "surface.ply"),
    ),
    (r"isoembed\.glue", "'isoembed glue'"),
    (r"isoembed\.io\.write_net", "'isoembed unfold'"),
    (
        rf"isoembed\.relativity\.read_grid_data\({PATH}\) reads it",
        lambda found: (
            f"embed it with {command('energy', path := literal_eval(found[1]))}, or make triangles of it "
            f"first, with {command('triangulate', path)}"
        ),
    ),
    (r"isoembed\.relativity\.read_slice reads one", "'isoembed series' reads several"),
    (rf"length_errors=(E|{NUMBER})", r"--length-error \1"),
)
"""Patterns of arguments, and equivalent options."""


def in_options(message: str) -> str:
    """Message of the library with advised arguments replaced by options.

    Only whole words are replaced, not parts of file names such as ``merge=1e-6.obj``.
    """
    for argument, option in OPTIONS:
        message = re.sub(rf"(?<![^\s(]){argument}(?=[.,;:)]*(?:\s|$))", option, message)
    return message
