"""Registry of file formats by name ending, including those of installed packages.

A package adds a format by an entry point of the group ``isoembed.formats``: its name is the ending, and its
object is a `Format`.  Built-in endings cannot be replaced, and names without a dot are ignored.
"""

import os
from collections.abc import Callable, Collection
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from isoembed.io import fold, gltf, json, npz, obj, off, ply, stl, strut_table, vtk, vtp, vtu
from isoembed.io.files import FileError, Tables, Writer, check_ending, check_target, ending
from isoembed.io.format import Format, loaded


def _added(point: EntryPoint) -> Format:
    """Format of another package, imported on first use."""
    return Format(
        point.name,
        lambda file: loaded(point, Format).read(file),
        lambda path, tables: _writer(loaded(point, Format), tables)(path),
    )


def _writer(format_: Format, tables: Tables) -> Callable[[Path], None]:
    if format_.write is None:
        raise FileError(f"files with the ending {format_.ending} are read only")
    write = format_.write
    return lambda path: write(path, tables)


OWN = (
    *(module.FORMAT for module in (npz, json, ply, obj, stl, off, fold, vtk, vtu, vtp)),
    *(gltf.GLB, gltf.GLTF, strut_table.FORMAT),
)
FORMATS = {known.ending: known for known in OWN}
ADDED = {
    point.name: point
    for point in entry_points(group="isoembed.formats")
    if point.name.startswith(".") and point.name not in FORMATS
}
FORMATS |= {name: _added(point) for name, point in ADDED.items()}

METRIC_ENDINGS = tuple(name for name, known in FORMATS.items() if known.holds_metrics)
TABLE_ENDINGS = (strut_table.FORMAT.ending,)
MESH_ENDINGS = tuple(name for name in FORMATS if name not in (*METRIC_ENDINGS, *TABLE_ENDINGS))
SURFACE_ENDINGS = tuple(name for name, known in FORMATS.items() if known.write is not None)


def check_output(path: str | os.PathLike[str], known: Collection[str]) -> None:
    """Check before a computation that its result can be written to a path.

    Parameters
    ----------
    path : path
    known : collection of str
        Permitted endings.

    Raises
    ------
    FileError
        The ending is unknown, the folder does not exist or is not writable, the path is not a regular file,
        or the format of another package cannot be loaded.
    """
    check_ending(path, known, of=ending)
    check_target(path)
    if known == SURFACE_ENDINGS and ending(path) in ADDED:
        _writer(loaded(ADDED[ending(path)], Format), {})


def tables_writer(path: str | os.PathLike[str], tables: Tables) -> Writer:
    """Writer of arrays in the format of the path's ending; see `write_atomically`."""
    return _writer(FORMATS[ending(path)], tables)
