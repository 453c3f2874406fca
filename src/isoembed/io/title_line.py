"""Space and coordinate precision in the title line of a surface file.

Vertices in hyperbolic and spherical space are written in conformal coordinates: Poincare ball or
stereographic projection.  Vertices computed from rounded coordinates or lengths have full precision in the
file, so the title states the error of the lengths.
"""

import re

from isoembed.io.files import Tables
from isoembed.space.models import Model

WRITTEN: Model = "conformal"
"""Model of written coordinates, and default model of coordinates read."""

SPACE = re.compile(r"isoembed: curvature of space ([^\s,]+), (\w+) coordinates")
PRECISION = re.compile(r"isoembed: from coordinates of ([^,]+), length error ([^\s,]+)")


def title_line(tables: Tables) -> str:
    """Title line for these arrays; empty for exact vertices in Euclidean space."""
    if "curvature" in tables:
        return f"isoembed: curvature of space {float(tables['curvature'])!r}, {WRITTEN} coordinates"
    if "rounding_error" in tables:
        return (
            f"isoembed: from coordinates of {tables['precision']}, "
            f"length error {float(tables['rounding_error'])!r}"
        )
    return ""


def title_data(text: str) -> Tables:
    """Entries encoded by a `title_line` in a text; empty if there is none."""
    if found := SPACE.search(text):
        return {"curvature": found[1], "model": found[2]}
    if found := PRECISION.search(text):
        return {"precision": found[1], "rounding_error": found[2]}
    return {}
