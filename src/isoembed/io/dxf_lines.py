"""DXF input: polylines and side numbers in millimeters, through ezdxf."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from itertools import islice, pairwise
from typing import Any

import numpy as np

from isoembed.errors import warn_of_mesh
from isoembed.gluing.drawn_lines import LAYERS, NUMBERS, READ, Line, Lines, Number, last_unit
from isoembed.io.files import FileError, first_line
from isoembed.io.input_file import InputFile
from isoembed.io.svg_path import FLATNESS, LARGEST, MOST_READ

APPLICATION = "ISOEMBED"
"""Application name of an entity's extended data, which hold the fold angle."""
PROPERTIES = ("kerf", "error")
"""Properties of a drawing in mm: the kerf (outlines are offset by half of it) and the error of the points."""
ANY_SURFACE = "any_surface"
"""Property of drawings in which sides without a number are a boundary."""
CURVES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
MOST_NESTED = 10  # blocks
DAMAGED = (ValueError, KeyError, IndexError, AttributeError, TypeError, OverflowError)
"""Exceptions raised by ezdxf for damaged files, besides its own."""


def ezdxf_for(purpose: str) -> Any:
    """The package ezdxf.

    Raises
    ------
    FileError
        The package is not installed.
    """
    try:
        import ezdxf
    except ImportError:
        raise FileError(f"{purpose} needs ezdxf: pip install ezdxf; .svg needs nothing") from None
    return ezdxf


def read_dxf_lines(file: InputFile) -> Lines:
    """Read the lines of a DXF file's model space.

    Layer names give the purpose of lines.  Curves are sampled; a drawing without a unit is in millimeters.

    Raises
    ------
    FileError
        The file is not DXF, or ezdxf is not installed.
    """
    ezdxf = ezdxf_for(f"reading {file}")
    text = file.data.decode("utf-8", errors="surrogateescape")
    try:
        return _drawn(ezdxf, ezdxf.read(io.StringIO(text.replace("\r\n", "\n"))), str(file))
    except FileError:
        raise
    except (ezdxf.DXFError, *DAMAGED) as error:
        raise FileError(f"{file} is not a readable DXF file: {first_line(error)}") from None


def _drawn(ezdxf: Any, document: Any, file: str) -> Lines:
    """Lines of a DXF document."""
    # ezdxf gives 0 for a drawing without a unit, as old programs write them.
    unit = 1.0
    if document.units:
        unit = ezdxf.units.conversion_factor(document.units, ezdxf.units.MM)
    else:
        warn_of_mesh(f"{file} has no unit: millimeters are taken")
    lines, numbers, values = [], [], [np.zeros(1)]
    entities = [*islice(_entities(document.modelspace(), 0, file), MOST_READ + 1)]
    if len(entities) > MOST_READ:
        raise FileError(f"{file} draws more than {MOST_READ} entities: no net needs as many")
    any_numbers = any(entity.dxf.layer.lower() == NUMBERS for entity in entities)
    for entity in entities:
        layer, kind = entity.dxf.layer.lower(), entity.dxftype()
        if kind in ("TEXT", "MTEXT"):
            if not any_numbers or layer == NUMBERS:
                numbers.append(_number(entity, unit))
            continue
        path = ezdxf.path.make_path(entity)
        if len(path) == 0:
            continue
        corners = np.array([vertex.vec2 for vertex in path.control_vertices()])
        if not (np.abs(corners) < LARGEST).all():
            raise FileError(
                f"{file}: a {kind} of the layer {entity.dxf.layer} has numbers that are too large"
            )
        if not path.has_curves:  # control points of curves are computed
            values.append(corners.ravel())
        size = float(np.ptp(corners, axis=0).max())
        points = unit * np.array([vertex.vec2 for vertex in path.flattening(FLATNESS * size, segments=8)])
        if path.is_closed and not (points[0] == points[-1]).all():
            points[-1] = points[0]
        purpose = LAYERS.get(layer, READ if layer == NUMBERS else "")
        color = str(entity.dxf.get("true_color", entity.dxf.color))
        lines.append(Line(points, purpose, color, _angle(entity), kind == "CIRCLE", path.has_curves))
    properties = dict(document.header.custom_vars.properties)
    kerf, error = (_millimeters(properties, name, file) for name in PROPERTIES)
    last = unit * last_unit(np.concatenate(values))
    return Lines(tuple(lines), tuple(numbers), last, kerf, error, ANY_SURFACE in properties)


def _millimeters(properties: dict[str, str], name: str, file: str) -> float:
    """Property of the drawing, in mm."""
    try:
        value = float(properties.get(name, "0"))
    except ValueError:
        value = math.nan
    if not 0 <= value < math.inf:
        raise FileError(f"{file}: the {name} is {properties[name]!r}, not a length in mm")
    return value


def _entities(space: Any, depth: int, name: str) -> Iterator[Any]:
    """Curves and texts of a layout; those of blocks at each insertion."""
    if depth > MOST_NESTED:
        raise FileError(f"{name} has blocks nested more than {MOST_NESTED} deep")
    for entity in space:
        kind = entity.dxftype()
        if kind == "INSERT":
            for one in entity.multi_insert() if entity.mcount > 1 else [entity]:  # rows and columns
                yield from _entities(one.virtual_entities(), depth + 1, name)
        elif kind in CURVES or kind in ("TEXT", "MTEXT"):
            yield entity


def _number(entity: Any, unit: float) -> Number:
    """Text of an entity, positioned by its center."""
    if entity.dxftype() == "MTEXT":
        text, height, point = entity.plain_text().strip(), entity.dxf.char_height, entity.dxf.insert
        column, row = (entity.dxf.attachment_point - 1) % 3, (entity.dxf.attachment_point - 1) // 3
        shift = np.array([0.5 - column / 2, (row - 1) / 2])
        angle = entity.get_rotation()
    else:
        text, height, angle = entity.plain_text().strip(), entity.dxf.height, entity.dxf.rotation
        align, first, second = entity.get_placement()
        name, point = align.name, first if second is None else (first + second) / 2
        across = 0.5 if name.endswith("LEFT") else -0.5 if name.endswith("RIGHT") else 0.0
        shift = np.array([across, 0.0 if "MIDDLE" in name else -0.5 if name.startswith("TOP") else 0.5])
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    size = np.array([0.78 * len(text) * height, height])  # width and height of the text
    x, y = unit * (np.array([point[0], point[1]]) + np.array([[c, -s], [s, c]]) @ (shift * size))
    return Number(text, float(x), float(y), unit * float(height), float(angle))


def _angle(entity: Any) -> float | None:
    """Fold angle of an entity in degrees, if any."""
    if not entity.has_xdata(APPLICATION):
        return None
    angles = [tag.value for tag in entity.get_xdata(APPLICATION)]
    return next((float(b) for a, b in pairwise(angles) if a == "angle"), None)
