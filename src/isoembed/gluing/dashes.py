"""Dashed lines: folds reconstructed from their dashes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.gluing.drawn_lines import CUT, Line

FEWEST = 3  # dashes of a fold: two of a length in line are as likely folds of two faces


def undashed(lines: Sequence[Line], near: float) -> list[Line]:
    """The lines, where those that follow one another as equal dashes in line are one.

    The paper is whole between two dashes and as far before the first and after the last, so that a line of
    dashes ends beyond them.

    Parameters
    ----------
    lines : sequence of Line
    near : float
        How far from in line or from equal they may be.
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
    """Whether a line is the next dash of a chain."""
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
