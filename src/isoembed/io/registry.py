"""The file formats by their endings: our own, and those of other packages.

A package adds one by an entry point of the group ``isoembed.formats``: its name is the ending, and what it
refers to is a `Format`.
"""

import os
from importlib.metadata import EntryPoint, entry_points

from isoembed.io import json, npz, obj, off, ply, stl, vtk, vtu
from isoembed.io.files import Tables, Writer, ending
from isoembed.io.format import Format, loaded


def _added(point: EntryPoint) -> Format:
    """The format of another package, which is imported on first use."""
    return Format(
        point.name,
        lambda file: loaded(point, Format).read(file),
        lambda path, tables: loaded(point, Format).write(path, tables),
    )


FORMATS = {module.FORMAT.ending: module.FORMAT for module in (npz, json, ply, obj, stl, off, vtk, vtu)}
FORMATS |= {point.name: _added(point) for point in entry_points(group="isoembed.formats")}

METRIC_ENDINGS = tuple(name for name, known in FORMATS.items() if known.holds_metrics)
MESH_ENDINGS = tuple(name for name in FORMATS if name not in METRIC_ENDINGS)
SURFACE_ENDINGS = tuple(FORMATS)


def tables_writer(path: str | os.PathLike[str], tables: Tables) -> Writer:
    """Writer of arrays in the format of this ending; see `write_atomically`."""
    return lambda temporary: FORMATS[ending(path)].write(temporary, tables)
