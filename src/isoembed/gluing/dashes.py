"""Dashed lines: folds reconstructed from their dashes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.gluing.drawn_lines import CUT, Line

FEWEST = 3  # dashes of a fold: two collinear segments of equal length may be folds of two faces


def undashed(lines: Sequence[Line], near: float) -> list[Line]:
    """Join collinear, equally spaced dashes of equal length into single lines.

    The joined line extends by a gap beyond the first and the last dash, since the paper is uncut there, too.

    Parameters
    ----------
    lines : sequence of Line
    near : float
        Tolerance for collinearity and equality.
    """
    found: list[Line] = []
    chain: list[Line] = []
    for line in [*lines, None]:
        if line is not None and chain and _goes_on(chain, line, near):
            chain.append(line)
            continue
        found += _one(chain) if len(chain) >= FEWEST else chain
        chain = []
        if line is not None:
            if len(line.points) == 2 and line.purpose != CUT:
                chain = [line]
            else:
                found.append(line)
    return found


def _goes_on(chain: Sequence[Line], line: Line, near: float) -> bool:
    """Whether a line continues a chain of dashes."""
    last = chain[-1]
    if len(line.points) != 2 or line.purpose != last.purpose:
        return False
    step = last.points[1] - last.points[0]
    length = float(np.hypot(*step))
    gap = line.points[0] - last.points[1]
    if length == 0 or abs(float(np.hypot(*(line.points[1] - line.points[0]))) - length) > 2 * near:
        return False
    on = [float(point @ step) / length for point in (gap, line.points[1] - last.points[1])]
    off = [abs(float(u * step[1] - v * step[0])) / length for u, v in (gap, line.points[1] - last.points[1])]
    first = on[0] if len(chain) == 1 else float(np.hypot(*(last.points[0] - chain[-2].points[1])))
    return near < on[0] < on[1] and max(off) <= 2 * near and abs(on[0] - first) <= 2 * near


def _one(chain: Sequence[Line]) -> list[Line]:
    begin, end = chain[0].points[0], chain[-1].points[1]
    gap: Floats = chain[1].points[0] - chain[0].points[1]
    return [replace(chain[0], points=np.array([begin - gap, end + gap]))]
