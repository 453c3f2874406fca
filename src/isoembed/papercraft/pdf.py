"""PDF output of a paper net."""

from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.drawing import Drawing

INCH, POINT = 25.4, 25.4 / 72  # mm
WIDTHS = {"cut": 0.3, "mountain": 0.2, "valley": 0.2}  # mm
DASHES = {"cut": "solid", "mountain": (0, (10, 6)), "valley": (0, (15, 5, 2.5, 5))}  # in line widths


def write_pdf(path: Path, drawing: Drawing) -> None:
    """Write all pages."""
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    kinds = {
        "cut": [np.vstack([cut, cut[:1]]) for cut in drawing.cuts]
        + [_circle(*hole) for hole in drawing.holes],
        "mountain": [],
        "valley": [],
    }
    for fold in drawing.folds:
        kinds[fold.kind] += list(fold.pieces)
    for kind, sample in drawing.legend:
        kinds[kind].append(sample)
    lines = (
        *((some, WIDTHS[kind], DASHES[kind]) for kind, some in kinds.items()),
        (drawing.underlines + drawing.ruler + drawing.pictured, 0.2, "solid"),
        ([np.vstack([seam, seam[:1]]) for seam in drawing.seams], 0.2, "dotted"),
    )
    with PdfPages(path, metadata={"CreationDate": None}) as file:
        for page in range(drawing.pages):
            top, bottom = -page * drawing.height, -(page + 1) * drawing.height
            picture = Figure(figsize=(drawing.width / INCH, drawing.height / INCH))
            axes = picture.add_axes((0, 0, 1, 1))
            axes.set_axis_off()
            axes.set_xlim(0, drawing.width)
            axes.set_ylim(bottom, top)
            for some, width, style in lines:
                axes.add_collection(
                    LineCollection(some, linewidths=width / POINT, linestyles=[style], colors="black"),
                    autolim=False,
                )
            for one in (*drawing.labels, *drawing.notes, *drawing.captions):
                if bottom < one.y < top:
                    axes.text(
                        one.x, one.y, one.text, size=one.size / POINT, rotation=one.angle,
                        rotation_mode="anchor", ha="center", va="center_baseline", family="DejaVu Sans",
                    )  # fmt: skip
            file.savefig(picture)


def _circle(x: float, y: float, radius: float) -> Floats:
    turns = np.linspace(0, 2 * np.pi, 25)
    return np.column_stack([x + radius * np.cos(turns), y + radius * np.sin(turns)])
