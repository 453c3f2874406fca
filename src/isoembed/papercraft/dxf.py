"""DXF output of paper nets: millimeters, a layer for each kind of line, six decimals."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.dxf_lines import ANY_SURFACE, APPLICATION, PROPERTIES, ezdxf_for
from isoembed.papercraft.drawing import DECIMALS, Drawing
from isoembed.papercraft.labels import HEIGHT, Label

COLORS = {
    **{"cut": 1, "mountain": 5, "valley": 3, "seam": 6, "glue": 8, "engrave": 7, "numbers": 7},
    "solid": 9,
}
"""AutoCAD color indices of the layers: red, blue, green, magenta, gray, black or white, light gray."""


def write_dxf(path: Path, drawing: Drawing) -> None:
    """Write the drawing with its lower left corner at the origin, and pages arranged downward."""
    ezdxf = ezdxf_for(f"writing {path}")
    up = np.array([0.0, drawing.pages * drawing.height])
    with _no_dates(ezdxf):
        document = ezdxf.new("R2010", units=4)  # $INSUNITS: millimeters
        document.header["$MEASUREMENT"] = 1  # metric
        document.appids.add(APPLICATION)
        for name in (*PROPERTIES, ANY_SURFACE):
            if value := getattr(drawing, name):
                document.header.custom_vars.append(name, f"{value:.6g}")
        for name, color in COLORS.items():
            document.layers.add(name, color=color)
        space = document.modelspace()

        def polyline(points: Floats, layer: str) -> None:
            space.add_lwpolyline(_rounded(points + up), close=True, dxfattribs={"layer": layer})

        def line(ends: Floats, layer: str) -> Any:
            return space.add_line(*_rounded(ends + up), dxfattribs={"layer": layer})

        def text(label: Label, layer: str) -> None:
            (at,) = _rounded(np.array([[label.x, label.y]]) + up)
            how = {"layer": layer, "rotation": round(label.angle, 2), "height": round(HEIGHT * label.size, 3)}
            space.add_text(label.text, dxfattribs=how).set_placement(
                at, align=ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER
            )

        for area in drawing.glue:
            polyline(area, "glue")
        for ends in (*(sample for _, sample in drawing.legend), *drawing.ruler, *drawing.underlines):
            line(ends, "engrave")
        for label in drawing.notes:
            text(label, "engrave")
        for label in drawing.labels:
            text(label, "numbers")
        for ends in drawing.pictured:
            line(ends, "solid")
        for label in drawing.captions:
            text(label, "solid")
        for fold in drawing.folds:
            for piece in fold.pieces:
                entity = line(piece, fold.kind)
                if fold.angle is not None:
                    degrees = round(float(np.degrees(fold.angle)), 6)
                    entity.set_xdata(APPLICATION, [(1000, "angle"), (1040, degrees)])
        for seam in drawing.seams:
            polyline(seam, "seam")
        for x, y, radius in drawing.holes:
            (at,) = _rounded(np.array([[x, y]]) + up)
            space.add_circle(at, round(radius, DECIMALS), dxfattribs={"layer": "cut"})
        for cut in drawing.cuts:
            polyline(cut, "cut")
        document.saveas(path)


def _rounded(points: Floats) -> list[tuple[float, float]]:
    return [(x, y) for x, y in (np.round(points, DECIMALS) + 0.0).tolist()]


@contextmanager
def _no_dates(ezdxf: Any) -> Iterator[None]:
    """Omit time stamps and random names, for reproducible files."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
