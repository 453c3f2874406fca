"""Labels of glued sides: numbers inside the sheet, along the side."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from isoembed.arrays import Floats
from isoembed.gluing.polygon import Side, segments
from isoembed.papercraft.convex import Pieces, overlaps

LEGIBLE, LEAST = 2.0, 0.5  # mm
SHRINK = 0.85  # ratio of successive sizes that are tried
WIDTH, HEIGHT = 0.56, 0.72  # of a digit, in font sizes
PADDING = 0.22  # around a number, in font sizes
OFF = 0.15  # distance of the padded number from the side, in font sizes


@dataclass(frozen=True)
class Label:
    """A number on the paper.

    Attributes
    ----------
    text : str
    x, y : float
        Center of the text, mm.
    angle : float
        Direction of the text, degrees counterclockwise.
    size : float
        Font size, mm.
    """

    text: str
    x: float
    y: float
    angle: float
    size: float

    @property
    def underline(self) -> Floats | None:
        """Endpoints of an underline for numbers that are others upside down, such as 6 and 9; else None."""
        if not set(self.text) <= set("0689") or not set(self.text) & set("69"):
            return None
        half = WIDTH / 2 * len(self.text)
        return self._put(np.array([[-half, -0.55], [half, -0.55]]))

    @property
    def box(self) -> Floats:
        """Corners of the padded bounding box, (4, 2)."""
        half, up = WIDTH / 2 * len(self.text) + PADDING, HEIGHT / 2 + PADDING
        return self._put(np.array([[-half, -up], [half, -up], [half, up], [-half, up]]))

    def _put(self, points: Floats) -> Floats:
        """Points given relative to the center, along the text and upward, in font sizes."""
        cosine, sine = np.cos(np.radians(self.angle)), np.sin(np.radians(self.angle))
        return np.array([self.x, self.y]) + self.size * points @ np.array([[cosine, sine], [-sine, cosine]])


def labels(
    outlines: Sequence[Floats], folds: Sequence[Floats], sides: Sequence[tuple[Side, Side]]
) -> list[Label]:
    """Labels of all pairs of sides, with the same number on both.

    Each label is as large as possible without meeting a line or another label; it may cross folds if it would
    be illegible otherwise.

    Parameters
    ----------
    outlines : sequence of ndarray, shape (n, 2)
        Outlines of the sheets, counterclockwise, in mm.
    folds : sequence of ndarray, shape (m, 2, 2)
        Folds of each sheet.
    sides : sequence of pairs
        Pairs of glued sides ``((p, k), (q, m))``.
    """
    rims = list(map(segments, outlines))
    numbered = [(str(number), rims[p][k]) for number, pair in enumerate(sides, 1) for p, k in pair]
    numbered.sort(key=lambda entry: float(np.hypot(*(entry[1][1] - entry[1][0]))))  # shortest sides first
    lines, creases = Pieces(2, chain.from_iterable(rims)), Pieces(2, chain.from_iterable(folds))
    occupied = Pieces(4)
    found = []
    for text, ends in numbered:
        one = (
            _fitting(text, ends, 4.2, LEGIBLE, (lines, creases, occupied))
            or _fitting(text, ends, LEGIBLE, LEAST, (lines, occupied))
            or _beside(text, ends, 0.5, LEAST)
        )
        occupied.add(one.box)
        found.append(one)
    return found


def _fitting(
    text: str, ends: Floats, size: float, smallest: float, obstacles: Sequence[Pieces]
) -> Label | None:
    """Largest label of a side that overlaps nothing."""
    length = float(np.hypot(*(ends[1] - ends[0])))
    while size >= smallest and WIDTH * len(text) * size >= length:
        size *= SHRINK
    around = np.concatenate([_beside(text, ends, part, size).box for part in (0.0, 1.0)])
    close = [some.near(around) for some in obstacles]
    while size >= smallest:
        for part in (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8):
            one = _beside(text, ends, part, size)
            if not any(overlaps(one.box, some) for some in close):
                return one
        size *= SHRINK
    return None


def _beside(text: str, ends: Floats, part: float, size: float) -> Label:
    """Label inside a sheet, at a fraction of a side that has the sheet to its left."""
    x, y = ends[1] - ends[0]
    angle = float(np.degrees(np.arctan2(y, x)))
    inward = np.array([-y, x]) / np.hypot(x, y)
    middle = ends[0] + part * (ends[1] - ends[0]) + (HEIGHT / 2 + PADDING + OFF) * size * inward
    return Label(text, float(middle[0]), float(middle[1]), (angle + 90) % 180 - 90, size)
