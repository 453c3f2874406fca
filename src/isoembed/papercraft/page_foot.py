"""Foot and corners of each page: ruler, legend, page number, corner marks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.labels import WIDTH, Label
from isoembed.papercraft.paper import MARGIN

if TYPE_CHECKING:
    from isoembed.papercraft.placing import Layout

NOTE = 3.0  # mm, font size at the foot
RULER = 50  # mm
MARK, OFF = 6.0, 5.0  # mm, length of a corner mark and its distance from the page edges
LEGEND = {
    "cut": (92.0, "cut"),
    "mountain": (114.0, "fold away from you"),
    "valley": (158.0, "fold toward you"),
}
"""Position in mm from the left of a sample of each kind of line, and its text."""
SAMPLE = 10.0  # mm


def foot(layout: Layout, kinds: Sequence[str]) -> tuple[list[Floats], list[tuple[str, Floats]], list[Label]]:
    """Contents of the foot and corners of each page.

    Parameters
    ----------
    layout : Layout
    kinds : sequence of str
        Kinds of lines explained in the legend.

    Returns
    -------
    list of ndarray, shape (2, 2)
        Lines of the ruler and of the corner marks.
    list of (str, ndarray of shape (2, 2))
        Line samples by kind.
    list of Label
    """
    lines, legend, notes = [], [], []
    # On narrow pages the legend, which ends at 196 mm, is compressed, until it is illegible.
    narrow = min(1.0, (layout.width - 2 * MARGIN - RULER) / (196.0 - MARGIN - RULER))
    for k in range(layout.pages):
        low = -(k + 1) * layout.height
        lines += _marks(layout.width, layout.height, low)
        of = f", page {k + 1} of {layout.pages}" if layout.pages > 1 else ""
        text = (
            f"outside of the solid{of}; {layout.scale:.4g} mm a unit; print at 100 %: the ruler is "
            f"{RULER} mm long"
        )
        notes.append(_line_of_words(text, layout.width, low))
        y, end = low + 3.2 * NOTE, MARGIN + RULER
        ticks = np.arange(MARGIN, end + 1, 10)
        lines += [_line(MARGIN, y, end, y), *(_line(x, y, x, y + 0.6 * NOTE) for x in ticks)]
        notes.append(_after(f"{RULER} mm", end, y, NOTE))
        if narrow * NOTE < 1.4:  # mm, illegible
            continue
        for kind in kinds:
            x, text = LEGEND[kind]
            x = end + narrow * (x - end)
            legend.append((kind, _line(x, y, x + narrow * SAMPLE, y)))
            notes.append(_after(text, x + narrow * SAMPLE, y, narrow * NOTE))
    return lines, legend, notes


def foot_of_drawing(layout: Layout) -> Label:
    """Text at the foot of the last page, with the drawing of the solid."""
    return _line_of_words(
        "the solid, with the numbers of its faces; not to scale, not to be cut",
        layout.width,
        -layout.pages * layout.height,
    )


def _line_of_words(text: str, width: float, low: float) -> Label:
    """Centered text at the foot of a page with the given lower edge, as large as fits."""
    size = min(NOTE, (width - 2 * MARGIN) / (WIDTH * len(text)))
    return Label(text, width / 2, low + 1.6 * NOTE, 0.0, size)


def _marks(width: float, height: float, low: float) -> list[Floats]:
    """Right angles in the page corners, for the alignment of pages and cutting machines."""
    found = []
    for x, right in ((OFF, 1), (width - OFF, -1)):
        for y, up in ((low + OFF, 1), (low + height - OFF, -1)):
            found += [_line(x, y, x + right * MARK, y), _line(x, y, x, y + up * MARK)]
    return found


def _line(x: float, y: float, to_x: float, to_y: float) -> Floats:
    return np.array([[x, y], [to_x, to_y]])


def _after(text: str, x: float, y: float, size: float) -> Label:
    """Text that starts slightly to the right of a point."""
    return Label(text, x + (len(text) / 2 + 1) * WIDTH * size, y, 0.0, size)
