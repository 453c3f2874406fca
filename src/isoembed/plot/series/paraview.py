"""ParaView files of a simulation: VTP surfaces and a PVD collection."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from isoembed.io.files import FileError, write_atomically
from isoembed.io.registry import check_output
from isoembed.io.vtp import write as write_vtp
from isoembed.plot.series.abscissa import Abscissa
from isoembed.plot.series.placing import PlacedHorizons
from isoembed.runs.result import Result

PARAVIEW_ENDINGS = (".pvd",)


def write_paraview(path: str | os.PathLike[str], results: Iterable[Result]) -> None:
    """Write the embedded horizons of a run as a ParaView collection with time steps.

    Each horizon is a ``.vtp`` file with all vertex data, in a folder named like the collection; the series
    are parts.  Each horizon has the position of its center and its orientation in the slice; see
    `PlacedHorizons.of`.  If some horizons have a time, those without one are omitted.

    Parameters
    ----------
    path : path
        Ending in ``.pvd``.
    results : iterable of Result
        Results in any order; equal results yield identical files.

    Raises
    ------
    FileError
        The ending is unknown, or a file cannot be written.
    """
    check_output(path, PARAVIEW_ENDINGS)
    collection, placed = Path(path), PlacedHorizons.of(results)
    folder = collection.with_suffix("")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot make the folder {folder}: {error.strerror}") from None
    along = Abscissa.of(placed.table)
    entries = list[tuple[float, int, str]]()
    for k, (name, part) in enumerate(placed.table.series.items()):
        for row, at in zip(part.rows, along.of_series(part).tolist(), strict=True):
            horizon = placed.horizons.get(row.label)
            if horizon is None or not np.isfinite(at):
                continue
            file = folder / f"{row.label}.vtp"
            tables = {"vertices": horizon.vertices, "faces": horizon.faces, **horizon.fields}
            write_atomically({file: partial(write_vtp, tables=tables)})
            where = quoteattr(f"{folder.name}/{file.name}")
            data = f'timestep="{at!r}" part="{k}" name={quoteattr(name)} file={where}'
            entries.append((at, k, data))
    text = "".join(f"<DataSet {data}/>\n" for *_, data in sorted(entries))
    document = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<VTKFile type="Collection" version="0.1" '
        f'byte_order="LittleEndian">\n<Collection>\n{text}</Collection>\n</VTKFile>\n'
    )
    write_atomically({collection: lambda temporary: temporary.write_text(document, encoding="utf-8")})
