"""SVG input: polylines and side numbers in millimeters."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import warn_of_mesh
from isoembed.gluing.drawn_lines import LAYERS, NUMBERS, READ, Line, Lines, Number, last_unit
from isoembed.io.files import FileError
from isoembed.io.input_file import InputFile
from isoembed.io.svg_path import LARGEST, MOST_READ, number, path_points

MOST_BYTES = 50_000_000
MOST_NESTED = 50  # levels of elements and references
PIXEL = 25.4 / 96  # mm
UNITS = {
    "": PIXEL,
    "px": PIXEL,
    "mm": 1.0,
    "cm": 10.0,
    "in": 25.4,
    "pt": 25.4 / 72,
    "pc": 25.4 / 6,
    "q": 0.25,
}
UNDRAWN = {"defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata", "title", "desc", "style"}
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
HREF = "{http://www.w3.org/1999/xlink}href"
NUMBER = r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?"  # possessive: matches in linear time
CURVED = re.compile("[CcSsQqTtAa]")
ANCHORS = {"start": 0.5, "middle": 0.0, "end": -0.5}
HEIGHT = 0.72  # of a digit, relative to the font size


@dataclass(frozen=True)
class _Style:
    """Inherited properties of an element."""

    matrix: Floats  # (2, 3), to millimeters, y upward
    purpose: str = ""
    numbers: bool = False
    color: str = ""
    anchor: str = "start"
    size: float = 16.0
    shown: bool = True


def read_svg_lines(file: InputFile) -> Lines:
    """Read the lines of an SVG file.

    Curves are sampled; transformations, units and the view box are applied.  Labels or ids of groups and
    layers give the purpose of lines; ``data-angle`` gives the fold angle of a line in degrees.

    Raises
    ------
    FileError
        The file is not SVG, is too large or defines entities, or a path or a transformation is invalid.
    """
    if len(file.data) > MOST_BYTES:
        raise FileError(f"{file} has {len(file.data)} bytes, more than {MOST_BYTES}: no net needs as many")
    if "<!ENTITY" in file.text:  # a few lines can expand to gigabytes
        raise FileError(f"{file} defines entities: save it as plain SVG")
    try:
        root = ElementTree.fromstring(file.data)
    except ElementTree.ParseError as error:
        raise FileError(f"{file} is not a readable SVG file: {error}") from None
    if _name(root) != "svg":
        raise FileError(f"{file} is not an SVG file: it holds {_name(root)!r}")
    reader = _Reader(str(file), {e.get("id", ""): e for e in root.iter()})
    try:
        reader.walk(root, _Style(_view(root)), 0)
        declared = [reader.millimeters(root, key) for key in ("data-kerf", "data-error")]
    except (ValueError, OverflowError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{file} is not a readable SVG file: {error}") from None
    if not any(re.search("[a-zA-Z]", root.get(key, "")) for key in ("width", "height")):
        warn_of_mesh(f"{file} has no unit: a pixel is taken as 1/96 inch, {PIXEL:.4f} mm")
    unit = last_unit(np.concatenate([np.zeros(1), *reader.values]))
    scale = float(np.sqrt(abs(np.linalg.det(_view(root)[:, :2]))))
    return Lines(
        tuple(reader.lines),
        tuple(reader.numbers),
        unit * scale * math.sqrt(reader.steps),
        kerf=declared[0],
        error=declared[1],
        any_surface=root.get("data-any-surface") is not None,
    )


class _Reader:
    def __init__(self, name: str, by_id: dict[str, Element]) -> None:
        self.name, self.by_id = name, by_id
        self.lines: list[Line] = []
        self.numbers: list[Number] = []
        self.values: list[Floats] = []
        self.steps = 1  # consecutive relative coordinates, whose rounding errors accumulate
        self.read = 0  # number of elements
        self.any_numbers = any(_label(e) == NUMBERS for e in by_id.values())

    def walk(self, element: Element, style: _Style, depth: int) -> None:
        """Read an element and its descendants."""
        name = _name(element)
        if name in UNDRAWN:
            return
        if depth > MOST_NESTED:
            raise FileError(f"{self.name} has elements nested more than {MOST_NESTED} deep")
        self.read += 1
        if self.read > MOST_READ:
            raise FileError(f"{self.name} draws more than {MOST_READ} elements: no net needs as many")
        style = self._styled(element, style)
        if not style.shown:
            return
        if name == "text":
            self._text(element, style)
            return
        if name == "use":
            href = element.get("href") or element.get(HREF) or ""
            other = self.by_id.get(href.removeprefix("#"))
            if other is not None:
                shift = np.array([_length(element, "x"), _length(element, "y")])
                within = replace(style, matrix=_times(style.matrix, np.column_stack([np.eye(2), shift])))
                if _name(other) == "symbol":
                    for child in other:
                        self.walk(child, within, depth + 1)
                else:
                    self.walk(other, within, depth + 1)
            return
        for points, closed in self._shapes(element, name):
            placed = points @ style.matrix[:, :2].T + style.matrix[:, 2]
            if closed and not (placed[0] == placed[-1]).all():
                placed = np.concatenate([placed, placed[:1]])
            angle = element.get("data-angle")
            degrees = None if angle is None else _plain(angle, "data-angle")
            is_round = name in ("circle", "ellipse")
            is_curve = is_round or (name == "path" and CURVED.search(element.get("d", "")) is not None)
            self.lines.append(Line(placed, style.purpose, style.color, degrees, is_round, is_curve))
        for child in element:
            if isinstance(child.tag, str):
                self.walk(child, style, depth + 1)

    def millimeters(self, root: Element, key: str) -> float:
        """Property of the drawing, in mm."""
        value = _plain(root.get(key, "0"), key)
        if not 0 <= value < math.inf:
            raise FileError(f"{self.name}: {key} is {value:g}, not a length in mm")
        return value

    def _styled(self, element: Element, style: _Style) -> _Style:
        pairs = (part.partition(":") for part in element.get("style", "").split(";"))
        properties = {key.strip(): value.strip() for key, _, value in pairs if value.strip()}

        def of(key: str) -> str | None:
            return properties.get(key, element.get(key))

        matrix = _times(style.matrix, _transform(element.get("transform", ""), self.name))
        if not (np.abs(matrix) < LARGEST).all():
            raise FileError(f"{self.name}: the transformations of {_described(element)} are too large")
        label = _label(element)
        size = re.match(NUMBER, of("font-size") or "")
        return _Style(
            matrix,
            LAYERS.get(label, READ if label == NUMBERS else style.purpose),
            style.numbers or label == NUMBERS,
            {"none": ""}.get(of("stroke") or style.color, of("stroke") or style.color),
            of("text-anchor") or style.anchor,
            number(size[0]) if size else style.size,
            style.shown and of("display") != "none" and of("visibility") not in ("hidden", "collapse"),
        )

    def _shapes(self, element: Element, name: str) -> Iterator[tuple[Floats, bool]]:
        """Polylines in the coordinates of the element, and whether they are closed."""

        def length(key: str) -> float:
            value = _length(element, key)
            self.values.append(np.array([value]))
            return value

        if name == "path":
            sampled, exact, steps = path_points(element.get("d", ""))
            self.values.append(exact)
            self.steps = max(self.steps, steps)
            yield from ((points, closed) for points, closed in sampled if len(points) > 1)
        elif name in ("polygon", "polyline"):
            values = [number(x) for x in re.findall(NUMBER, element.get("points", ""))]
            points = np.reshape(values[: len(values) // 2 * 2], (-1, 2))
            self.values.append(points.ravel())
            if len(points) > 1:
                yield points, name == "polygon"
        elif name == "line":
            yield np.array([[length("x1"), length("y1")], [length("x2"), length("y2")]]), False
        elif name == "rect":
            x, y, width, height = (length(key) for key in ("x", "y", "width", "height"))
            if width > 0 and height > 0:
                yield np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]]), True
        elif name in ("circle", "ellipse"):
            a, b = ("r", "r") if name == "circle" else ("rx", "ry")
            x, y, u, v = (length(key) for key in ("cx", "cy", a, b))
            if u > 0 and v > 0:
                turns = np.linspace(0, 2 * np.pi, 128, endpoint=False)
                yield np.column_stack([x + u * np.cos(turns), y + v * np.sin(turns)]), True

    def _text(self, element: Element, style: _Style) -> None:
        """Read a number, positioned by the center of its first line."""
        text = "".join(element.itertext()).strip()
        if not text or (self.any_numbers and not style.numbers):
            return
        inner = next((e for e in element.iter() if e.get("x") is not None), element)
        if inner is not element:
            style = self._styled(inner, style)
        size = style.size
        across = ANCHORS.get(style.anchor, 0.5) * 0.56 * size * len(text)  # of the width of digits
        down = _first(element.get("dy")) - HEIGHT / 2 * size
        at = np.array([_first(inner.get("x")) + across, _first(inner.get("y")) + down])
        x, y = style.matrix[:, :2] @ at + style.matrix[:, 2]
        scale = float(np.sqrt(abs(np.linalg.det(style.matrix[:, :2]))))
        u, v = style.matrix[:, 0]
        angle = math.degrees(math.atan2(v, u))
        self.numbers.append(Number(text, float(x), float(y), HEIGHT * scale * size, angle))


def _name(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


def _label(element: Element) -> str:
    """Known layer name among the label, id and class of an element, in lower case."""
    names = [element.get(key, "").strip().lower() for key in (LABEL, "id", "class")]
    return next((name for name in names if name in LAYERS or name == NUMBERS), "")


def _described(element: Element) -> str:
    return f"{_name(element)} {element.get('id', '')}".strip()


def _plain(text: str, name: str) -> float:
    if not re.fullmatch(NUMBER, text.strip()):
        raise ValueError(f"{name} is {text[:40]!r}, not a number")
    return number(text)


def _first(text: str | None) -> float:
    found = re.match(NUMBER, (text or "").strip())
    return number(found[0]) if found else 0.0


def _length(element: Element, key: str) -> float:
    """A length in user units."""
    text = element.get(key, "0").strip()
    found = re.fullmatch(rf"({NUMBER})\s*([a-zA-Z]*)", text)
    if not found or found[2].lower() not in UNITS:
        raise ValueError(f"{key} of {_described(element)} is {text[:40]!r}, not a length")
    return number(found[1]) * (UNITS[found[2].lower()] / PIXEL if found[2] else 1.0)


def _view(root: Element) -> Floats:
    """Transformation from drawing coordinates to millimeters, y upward."""
    box = [number(x) for x in re.findall(NUMBER, root.get("viewBox", ""))]
    sizes = [
        re.fullmatch(rf"\s*({NUMBER})\s*([a-zA-Z]*)\s*", root.get(key, "")) for key in ("width", "height")
    ]
    extents = [number(s[1]) * UNITS[s[2].lower()] if s and s[2].lower() in UNITS else None for s in sizes]
    if len(box) != 4 or not (box[2] > 0 and box[3] > 0):
        return np.array([[PIXEL, 0.0, 0.0], [0.0, -PIXEL, 0.0]])
    width, height = extents
    across = PIXEL if width is None else width / box[2]
    up = across if height is None else height / box[3]
    across = up if width is None and height is not None else across
    if root.get("preserveAspectRatio", "").strip() != "none":
        across = up = min(across, up)
    return np.array([[across, 0.0, -across * box[0]], [0.0, -up, up * box[1]]])


def _transform(text: str, name: str) -> Floats:
    """Matrix (2, 3) of a list of transformations."""
    matrix = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    if not text.strip():
        return matrix
    calls = re.findall(r"\b(\w++)\s*+\(([^()]*+)\)", text)
    for kind, inside in calls:
        arguments = [number(x) for x in re.findall(NUMBER, inside)]
        one = _matrix(kind, arguments)
        if one is None:
            raise FileError(f"{name} has the invalid transformation {text[:60]!r}")
        matrix = _times(matrix, one)
    if not calls:
        raise FileError(f"{name} has the invalid transformation {text[:60]!r}")
    return matrix


def _matrix(kind: str, arguments: list[float]) -> Floats | None:
    count = len(arguments)
    if kind == "matrix" and count == 6:
        return np.reshape(arguments, (3, 2)).T
    if kind == "translate" and count in (1, 2):
        return np.array([[1.0, 0.0, arguments[0]], [0.0, 1.0, arguments[1] if count == 2 else 0.0]])
    if kind == "scale" and count in (1, 2):
        return np.array([[arguments[0], 0.0, 0.0], [0.0, arguments[-1], 0.0]])
    if kind == "rotate" and count in (1, 3):
        c, s = math.cos(math.radians(arguments[0])), math.sin(math.radians(arguments[0]))
        x, y = arguments[1:] if count == 3 else (0.0, 0.0)
        return np.array([[c, -s, x - c * x + s * y], [s, c, y - s * x - c * y]])
    if kind in ("skewX", "skewY") and count == 1:
        t = math.tan(math.radians(arguments[0]))
        return np.array(
            [[1.0, t if kind == "skewX" else 0.0, 0.0], [t if kind == "skewY" else 0.0, 1.0, 0.0]]
        )
    return None


def _times(first: Floats, second: Floats) -> Floats:
    """Matrix of the composition: the second transformation is applied before the first."""
    return np.column_stack([first[:, :2] @ second[:, :2], first[:, :2] @ second[:, 2] + first[:, 2]])
