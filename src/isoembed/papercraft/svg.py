"""SVG output of paper nets: millimeters, Inkscape layers, six decimals."""

from collections.abc import Iterable
from html import escape

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.drawing import DECIMALS, Drawing
from isoembed.papercraft.labels import HEIGHT, Label

COLORS = {
    "cut": "#ff0000",
    "mountain": "#0000ff",
    "valley": "#008000",
    "seam": "#ff00ff",
    "engrave": "#000000",
}
"""Line colors, by which cutting machines distinguish operations."""
FONT = 'font-family="Helvetica, Arial, sans-serif"'
INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"
WIDTHS = {"cut": 0.3, "mountain": 0.2, "valley": 0.2, "seam": 0.2, "engrave": 0.2}  # mm
DASHES = {"mountain": "2 1.2", "valley": "3 1 0.5 1", "seam": "1 1"}  # mm


def svg(drawing: Drawing) -> str:
    """SVG text of a drawing, with layers for cutting, folding, gluing and information; inner cuts first."""
    width, height = drawing.width, drawing.pages * drawing.height
    read = {
        "engrave": [
            *_group("legend", (_path(line, extra=_dashes(kind)) for kind, line in drawing.legend)),
            *map(_path, drawing.underlines + drawing.ruler),
            *_group("numbers", map(_text, drawing.labels)),
            *_group("notes", map(_text, drawing.notes)),
        ],
        "solid": [*map(_path, drawing.pictured), *map(_text, drawing.captions)],
    }
    style = f'{_stroke("engrave")} {FONT} text-anchor="middle"'
    layers = [
        layer("glue", (_path(area, closed=True) for area in drawing.glue), 'fill="#e4e4e4"'),
        *(layer(name, lines, style) for name, lines in read.items() if lines),
        *(
            layer(
                kind,
                (
                    _path(*fold.pieces, extra=_angle(fold.angle))
                    for fold in drawing.folds
                    if fold.kind == kind
                ),
                _stroke(kind),
            )
            for kind in ("valley", "mountain")
        ),
        *(
            [layer("seam", (_path(seam, closed=True) for seam in drawing.seams), _stroke("seam"))]
            * bool(drawing.seams)
        ),
        layer(
            "cut",
            [*(_circle(*hole) for hole in drawing.holes), *(_path(cut, closed=True) for cut in drawing.cuts)],
            _stroke("cut"),
        ),
    ]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="{INKSCAPE}" '
            f'width="{width:g}mm" height="{height:g}mm" viewBox="0 0 {width:g} {height:g}" '
            f"{_attribute('kerf', drawing.kerf)}{_attribute('error', drawing.error)}"
            f'{_attribute("any-surface", drawing.any_surface)}style="background: white">',
            *layers,
            "</svg>\n",
        ]
    )


def layer(name: str, lines: Iterable[str], style: str) -> str:
    """Text of a layer, which Inkscape shows as such."""
    layer = f'inkscape:groupmode="layer" inkscape:label="{name}"'
    return "\n".join([f'<g id="{name}" {layer} {style}>', *lines, "</g>"])


def _group(name: str, lines: Iterable[str]) -> list[str]:
    return [f'<g id="{name}">', *lines, "</g>"]


def _stroke(kind: str) -> str:
    style = f'fill="none" stroke="{COLORS[kind]}" stroke-width="{WIDTHS[kind]}" stroke-linejoin="round"'
    return f"{style} {_dashes(kind)}".strip()


def _dashes(kind: str) -> str:
    """Dash pattern for the screen; machines draw the whole line."""
    return f'stroke-dasharray="{DASHES[kind]}"' if kind in DASHES else ""


def _attribute(name: str, millimeters: float) -> str:
    return f'data-{name}="{millimeters:.6g}" ' if millimeters else ""


def _angle(angle: float | None) -> str:
    """Attribute with the fold angle in degrees, which `isoembed.glue` reads."""
    return "" if angle is None else f'data-angle="{np.degrees(angle):.6f}"'


def _path(*parts: Floats, closed: bool = False, extra: str = "") -> str:
    d = "".join("M" + "L".join(f"{_number(x)} {_number(-y)}" for x, y in part.tolist()) for part in parts)
    return f'<path d="{d}{"Z" if closed else ""}"{" " if extra else ""}{extra}/>'


def _circle(x: float, y: float, radius: float) -> str:
    return f'<circle cx="{_number(x)}" cy="{_number(-y)}" r="{_number(radius)}"/>'


def _text(label: Label) -> str:
    x, y = _number(label.x), _number(-label.y)
    turn = f' transform="rotate({-label.angle:.2f} {x} {y})"' if label.angle else ""
    return (
        f'<text x="{x}" y="{y}" dy="{HEIGHT / 2 * label.size:.3f}" font-size="{label.size:.3f}" '
        f'fill="{COLORS["engrave"]}" stroke="none"{turn}>{escape(label.text)}</text>'
    )


def _number(value: float) -> str:
    return f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}"
