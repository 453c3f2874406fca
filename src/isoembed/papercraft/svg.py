"""SVG output of a paper net, in millimeters."""

from collections.abc import Iterable
from html import escape

from isoembed.arrays import Floats
from isoembed.papercraft.drawing import Drawing
from isoembed.papercraft.labels import HEIGHT, Label

STYLES = {
    "cut": 'stroke-width="0.3"',
    "mountain": 'stroke-width="0.2" stroke-dasharray="2 1.2"',
    "valley": 'stroke-width="0.2" stroke-dasharray="3 1 0.5 1"',
    "underline": 'stroke-width="0.2"',
    "ruler": 'stroke-width="0.2"',
}


def svg(drawing: Drawing) -> str:
    """The text of the file: what to cut, what to fold and what to read are groups, for machines that cut."""
    width, height = drawing.width, drawing.pages * drawing.height
    labels = drawing.labels
    groups = [
        _lines("cut", (_path(cut) + "Z" for cut in drawing.cuts)),
        _lines("mountain", map(_path, drawing.mountains)),
        _lines("valley", map(_path, drawing.valleys)),
        _lines("underline", (_path(one.underline) for one in labels if one.underline is not None)),
        '<g id="legend">',
        *(_lines(kind, [_path(sample)], "class") for kind, sample in drawing.legend),
        _lines("ruler", map(_path, drawing.ruler), "class"),
        "</g>",
        '<g id="labels" font-family="Helvetica, Arial, sans-serif" text-anchor="middle">',
        *map(_text, labels),
        *map(_text, drawing.notes),
        "</g>",
    ]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
            f'viewBox="0 0 {width:g} {height:g}" style="background: white">',
            *groups,
            "</svg>\n",
        ]
    )


def _lines(name: str, paths: Iterable[str], attribute: str = "id") -> str:
    body = "".join(f'\n<path d="{path}"/>' for path in paths)
    style = f'fill="none" stroke="black" stroke-linejoin="round" {STYLES[name]}'
    return f'<g {attribute}="{name}" {style}>{body}\n</g>'


def _path(points: Floats) -> str:
    return "M" + "L".join(f"{x:.3f} {-y:.3f}" for x, y in points.tolist())


def _text(label: Label) -> str:
    x, y = f"{label.x:.3f}", f"{-label.y:.3f}"
    turn = f' transform="rotate({-label.angle:.2f} {x} {y})"' if label.angle else ""
    return (
        f'<text x="{x}" y="{y}" dy="{HEIGHT / 2 * label.size:.3f}" font-size="{label.size:.3f}"{turn}>'
        f"{escape(label.text)}</text>"
    )
