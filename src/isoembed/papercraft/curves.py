"""SVG output of D-forms: two outlines as elliptical arcs and lines, with alignment marks."""

import math
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gluing.outlines import Curve, Ellipse, check_fraction
from isoembed.gluing.polygon import is_number, side_lengths
from isoembed.io.files import write_atomically
from isoembed.io.registry import check_output
from isoembed.papercraft.drawing import DECIMALS
from isoembed.papercraft.labels import HEIGHT
from isoembed.papercraft.paper import MARGIN
from isoembed.papercraft.svg import COLORS, FONT, INKSCAPE, WIDTHS, layer

MARKS = 12  # around each outline
TICK = 3.0  # mm, length of a mark, and font size
DENSE = 20_000  # chords for arc lengths accurate to 1e-8


def write_dform(
    path: str | os.PathLike[str], first: Curve, second: Curve, *, offset: float = 0.0, scale: float = 1.0
) -> None:
    """Write the outlines of a D-form (see `isoembed.gluing.dform`) for cutting along the exact curves.

    The outlines consist of elliptical arcs and lines instead of polygons.  Numbered marks inside each divide
    it into equal lengths; marks with the same number meet.  `isoembed.glue` reads the file.

    Parameters
    ----------
    path : path
        Ends with ``.svg``.
    first, second : Ellipse or Stadium
        Outlines; the second is scaled to the perimeter of the first.
    offset : float
        Point of the second outline glued to the start of the first, as a fraction of the perimeter.
    scale : float
        Millimeters per unit of the first outline.

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    InvalidParameter
        The offset or the scale is out of range.
    """
    check_output(path, (".svg",))
    check_fraction("offset", offset)
    if not is_number(scale) or not 0 < scale < math.inf:
        raise InvalidParameter(f"scale is {scale!r}, not a positive finite number of mm")
    u = np.arange(DENSE) / DENSE
    around = [float(side_lengths(curve.points(u)).sum()) for curve in (first, second)]
    text = _svg([(first, 0.0, scale, 1), (second, offset, scale * around[0] / around[1], -1)])
    write_atomically({Path(path): lambda temporary: temporary.write_text(text, encoding="utf-8")})


def _svg(shapes: list[tuple[Curve, float, float, int]]) -> str:
    """SVG text of curves with their start, scale and direction of marks.

    Face up on the table, the second outline is traversed in the opposite direction.
    """
    right, height = MARGIN, 0.0
    cuts, ticks, numbers = [], [], []
    for curve, part, scale, sign in shapes:
        size = scale * np.ptp(curve.points(np.arange(360) / 360), axis=0)  # symmetric about both axes
        middle = np.array([right, MARGIN]) + size / 2
        cuts.append(_path(curve, curve.parameter(part), scale, middle))
        for k in range(MARKS):
            at = curve.parameter((part + sign * k / MARKS) % 1.0)
            point, beyond = curve.points(np.array([at, at + 1e-6]))
            x, y = beyond - point
            inward = np.array([-y, x]) / math.hypot(x, y)
            outer, inner, text = (_placed(scale * point + d * inward, middle) for d in (0.0, TICK, 2 * TICK))
            ticks.append(f'<path d="M{outer}L{inner}"/>')
            across, down = text.split()
            numbers.append(f'<text x="{across}" y="{down}" dy="{HEIGHT / 2 * TICK:.3f}">{k + 1}</text>')
        right, height = right + float(size[0]) + MARGIN, max(height, float(size[1]) + 2 * MARGIN)
    written = f'stroke="none" fill="{COLORS["engrave"]}" font-size="{TICK}" text-anchor="middle" {FONT}'
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="{INKSCAPE}" width="{right:.4f}mm" '
            f'height="{height:.4f}mm" viewBox="0 0 {right:.4f} {height:.4f}" style="background: white">',
            layer("engrave", [*ticks, f'<g id="numbers" {written}>', *numbers, "</g>"], _stroke("engrave")),
            layer("cut", cuts, _stroke("cut")),
            "</svg>\n",
        ]
    )


def _stroke(kind: str) -> str:
    return f'fill="none" stroke="{COLORS[kind]}" stroke-width="{WIDTHS[kind]}"'


def _path(curve: Curve, begin: float, scale: float, middle: Floats) -> str:
    """Outline from a parameter, counterclockwise, as lines and arcs of less than half a turn."""
    begin %= 1.0
    stops = [
        begin,
        *sorted(at for u in _joints(curve) if (at := begin + (u - begin) % 1.0) > begin),
        begin + 1,
    ]
    points = scale * curve.points(np.array(stops) % 1.0)
    d = f"M{_placed(points[0], middle)}"
    for k, end in enumerate(points[1:]):
        radii = _radii(curve, (stops[k] + stops[k + 1]) / 2)
        a, b = (f"{scale * radius:.{DECIMALS}f}" for radius in radii)
        d += f"A{a} {b} 0 0 0 {_placed(end, middle)}" if radii[0] else f"L{_placed(end, middle)}"
    return f'<path d="{d}Z"/>'


def _joints(curve: Curve) -> Iterator[float]:
    """Parameters between 0 and 1 at the ends of arcs and lines."""
    if isinstance(curve, Ellipse):
        yield from (0.0, 0.25, 0.5, 0.75)
    else:
        yield from ((side + way * _bow(curve)) % 1.0 for side in (0.0, 0.5) for way in (-1, 0, 1))


def _bow(stadium: Curve) -> float:
    """Fraction of the perimeter of a quarter circle."""
    assert not isinstance(stadium, Ellipse)
    quarter = math.pi * stadium.radius / 2
    return quarter / (4 * quarter + 2 * stadium.length)


def _radii(curve: Curve, u: float) -> tuple[float, float]:
    """Semi-axes of the arc at a parameter; zero on a line."""
    if isinstance(curve, Ellipse):
        return curve.a, curve.b
    is_arc = min(u % 0.5, -u % 0.5) < _bow(curve)
    return (curve.radius, curve.radius) if is_arc else (0.0, 0.0)


def _placed(point: Floats, middle: Floats) -> str:
    return f"{middle[0] + point[0]:.{DECIMALS}f} {middle[1] - point[1]:.{DECIMALS}f}"
