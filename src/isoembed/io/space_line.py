"""The space that a surface in a file is in: the coordinates that files hold, and a line of text that says so.

Vertices in hyperbolic and spherical space are written in conformal coordinates: Poincare's ball, or
stereographic projection.  Formats without a place for numbers say so in a comment or a title.
"""

import re

from isoembed.io.files import Tables
from isoembed.space.models import Model

WRITTEN: Model = "conformal"
"""The model whose coordinates are written, and that files hold which do not name theirs."""

LINE = re.compile(r"isoembed: curvature of space ([^\s,]+), (\w+) coordinates")


def space_line(tables: Tables) -> str:
    """The line that says which coordinates of which space the vertices have; empty of Euclidean space."""
    if "curvature" not in tables:
        return ""
    return f"isoembed: curvature of space {float(tables['curvature'])!r}, {WRITTEN} coordinates"


def space_said(text: str) -> Tables:
    """The ``curvature`` and the ``model`` that a `space_line` in a text says; nothing without one."""
    found = LINE.search(text)
    return {"curvature": found[1], "model": found[2]} if found else {}
