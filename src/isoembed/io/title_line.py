"""Space and coordinate precision in the title line of a surface file.

Vertices in hyperbolic and spherical space are written in conformal coordinates: Poincare's ball, or
stereographic projection.  Vertices that were found from rounded coordinates have as many digits as any
others, so the file says how far the lengths may be off.
"""

import re

from isoembed.io.files import Tables
from isoembed.space.models import Model

WRITTEN: Model = "conformal"
"""The model whose coordinates are written, and that files hold which do not name theirs."""

SPACE = re.compile(r"isoembed: curvature of space ([^\s,]+), (\w+) coordinates")
PRECISION = re.compile(r"isoembed: from coordinates of ([^,]+), length error ([^\s,]+)")


def title_line(tables: Tables) -> str:
    """The line for these arrays; empty for exact vertices in Euclidean space."""
    if "curvature" in tables:
        return f"isoembed: curvature of space {float(tables['curvature'])!r}, {WRITTEN} coordinates"
    if "rounding_error" in tables:
        return (
            f"isoembed: from coordinates of {tables['precision']}, "
            f"length error {float(tables['rounding_error'])!r}"
        )
    return ""


def title_said(text: str) -> Tables:
    """The entries that a `title_line` in a text stands for; nothing without one."""
    if found := SPACE.search(text):
        return {"curvature": found[1], "model": found[2]}
    if found := PRECISION.search(text):
        return {"precision": found[1], "rounding_error": found[2]}
    return {}
