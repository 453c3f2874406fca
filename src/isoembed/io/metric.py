"""Reading and writing of metrics."""

import math
import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io import json
from isoembed.io.files import FileError, Tables, Writer, check_ending, input_ending, write_atomically
from isoembed.io.format import CURVATURES
from isoembed.io.input_file import opened
from isoembed.io.registry import FORMATS, METRIC_ENDINGS, check_output, tables_writer
from isoembed.io.title_line import WRITTEN
from isoembed.metric.given_mesh import triangle_mesh
from isoembed.metric.least_space import least_convex_space
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.precision import Precision
from isoembed.space import Space
from isoembed.space.models import MODELS, from_model

CONVERTERS = {
    **dict.fromkeys((".step", ".stp", ".iges", ".igs", ".brep", ".fcstd", ".3mf"), "FreeCAD"),
    **dict.fromkeys((".blend", ".fbx", ".x3d", ".wrl"), "Blender"),
    ".scad": "OpenSCAD",
    ".amf": "PrusaSlicer",
}
"""Free programs that convert unsupported formats to meshes."""
DRAWINGS = (".svg", ".dxf")


def read_metric(
    source: str | os.PathLike[str],
    *,
    merge: float | None = None,
    space: Space | str | None = None,
    any_surface: bool = False,
    length_errors: ArrayLike | None = None,
) -> PolyhedralMetric:
    """Read a metric.

    Parameters
    ----------
    source : path or "-"
        ``.npz`` or ``.json`` with ``faces`` (F, 3), ``lengths`` (E,) and ``edges`` (E, 2), which may be
        omitted if the lengths are in the order of `Triangulation.edges`; or with ``faces`` and ``vertices``
        (V, 3); or a mesh.  Optional ``length_errors``, shape (E,) in the order of the lengths or one number
        for all, are standard deviations.  Vertices determine the lengths, and their coordinates are
        discarded; the ``rounding_error`` is the root mean square error of a length due to the limited
        ``precision`` of the coordinates.
        Faces with vertices may be polygons.  A ``curvature`` is that of the triangles and of the ambient
        space; the vertices are then in the ``model`` named in the file, by default ``"conformal"``.  ``-``
        reads JSON from standard input.
    merge : float, optional
        Vertices within this distance, in mean edge lengths, are merged: see `PolyhedralMetric.from_mesh`.
        Equal vertices are always merged in formats that repeat them for every face (STL, glTF).
    space : Space or {"hyperbolic", "spherical"}, optional
        Space of the triangles, if the file states no curvature or zero: their sides are the lengths, or the
        distances in R^3 between the vertices.  ``"hyperbolic"`` alone is the `least_convex_space`, if the
        file states none; ``"spherical"`` alone requires the curvature in the file.
    any_surface : bool
        Whether surfaces with boundary or of higher genus are permitted.
    length_errors : float or array_like, shape (E,), optional
        Standard deviations of the lengths, in the order of the file's edges, replacing those in the file.

    Returns
    -------
    PolyhedralMetric

    Raises
    ------
    FileError
        The file cannot be read, its ending is unknown, its space differs from the given one, or a space
        given by name has no curvature in the file.
    InvalidMetric
        The contents are not a metric.

    Warns
    -----
    MeshNote
        Vertices or faces are merged or omitted, or polygons are not planar.
    """
    return read_with_vertices(
        source, merge=merge, space=space, any_surface=any_surface, length_errors=length_errors
    )[0]


def read_with_vertices(
    source: str | os.PathLike[str],
    *,
    merge: float | None,
    space: Space | str | None,
    any_surface: bool,
    length_errors: ArrayLike | None,
) -> tuple[PolyhedralMetric, Floats | None]:
    """Read a metric as `read_metric` does, and the vertices that its lengths were computed from, if any."""
    tables = read_tables(source, merge)
    metric = metric_of(tables if length_errors is None else {**tables, "length_errors": length_errors})
    if not any_surface:
        metric.triangulation.check_sphere()
    return in_space(metric, space, source), tables.get("vertices")


def in_space(
    metric: PolyhedralMetric, space: Space | str | None, source: str | os.PathLike[str]
) -> PolyhedralMetric:
    """Metric of a file in the requested space, as in `read_metric`; by default in its own."""
    if space is None or space in (metric.space, metric.space.name):
        return metric
    if not metric.space.is_euclidean:
        wanted = f"{space} space" if isinstance(space, str) else f"that of curvature {space.curvature!r}"
        raise FileError(
            f"{source} is in {metric.space.name} space of curvature {metric.curvature!r}, not in {wanted}"
        )
    if space == "hyperbolic":
        space = least_convex_space(metric)
    if isinstance(space, str):
        raise FileError(f"{source} does not contain the curvature of its space: give it, as in {space}=1")
    return metric.in_space(space)


def read_tables(
    source: str | os.PathLike[str], merge: float | None = None, wanted: Collection[str] = tuple(FORMATS)
) -> Tables:
    """Read ``faces``, ``edges`` and ``lengths``, or ``vertices`` and triangles, in any format.

    The error for an unknown ending lists the wanted ones.

    A ``curvature`` is returned as a number; the vertices are then points of the space of that curvature.
    """
    if source == "-":
        return _tables(json.read_standard_input(), source, merge)
    if input_ending(source) in DRAWINGS:
        raise FileError(f"{source} is a net: glue it first, with isoembed.glue({str(source)!r})")
    if (program := CONVERTERS.get(input_ending(source))) and input_ending(source) not in FORMATS:
        raise FileError(
            f"{source} has an unsupported format: open it with {program}, and export it as .stl or .obj"
        )
    if input_ending(source) not in FORMATS:
        check_ending(source, wanted)
    with opened(source) as file, np.errstate(invalid="ignore"):  # some bit patterns are NaN
        format_ = FORMATS[file.ending]
        tables = format_.read(file)
    return _tables(tables, source, merge, repeated=format_.repeats_vertices)


def metric_writer(path: str | os.PathLike[str], metric: PolyhedralMetric, **data: Floats) -> Writer:
    """Writer of a metric in the format of the path's ending; see `write_atomically`."""
    tables: dict[str, Any] = {"faces": metric.faces, "edges": metric.edges, "lengths": metric.given_lengths}
    tables |= data | metric._stated_errors
    if len(metric.diagonals):
        tables["diagonals"] = metric.edges[metric.diagonals]
    return tables_writer(path, tables | facts(metric))


def facts(metric: PolyhedralMetric) -> dict[str, Any]:
    """Scalars and strings of a metric stored in files: curvature, precision of coordinates."""
    found: dict[str, Any] = {} if metric.space.is_euclidean else {"curvature": np.array(metric.curvature)}
    if metric.precision is not None:
        error = metric.precision.length_error * metric.mean_length
        found |= {"precision": metric.precision.name, "rounding_error": np.array(error)}
    return found


def write_metric(path: str | os.PathLike[str], metric: PolyhedralMetric) -> None:
    """Write ``faces``, ``edges`` and ``lengths``, and optional data, as ``.npz`` or ``.json``.

    The lengths are the `given_lengths`, so that the same metric is read again.  Optional data are the
    ``curvature``, ``length_errors`` (E,), or 0 for lengths stated to be exact, the ends (D, 2) of
    ``diagonals`` of planar polygons, and the ``precision`` of the coordinates from which the lengths were
    computed, with the root mean square ``rounding_error`` of a length.

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    """
    check_output(path, METRIC_ENDINGS)
    write_atomically({Path(path): metric_writer(path, metric)})


def metric_of(tables: Tables) -> PolyhedralMetric:
    """Metric of the arrays of a file."""
    options = {key: tables[key] for key in ("curvature",) if key in tables}
    errors = tables.get("length_errors")
    if "lengths" in tables:
        if "check_lengths" in tables:  # by the names in the file
            tables["check_lengths"](errors)
        arguments = tables["faces"], tables["lengths"], tables.get("edges")
        metric = PolyhedralMetric(*arguments, length_errors=errors, **options)
    else:
        metric = PolyhedralMetric.from_mesh(tables["vertices"], tables["faces"], **options)
        if errors is not None:
            metric = metric.with_length_errors(errors)
    if "diagonals" in tables:
        metric = metric.with_diagonals(tables["diagonals"])
    if "rounding_error" in tables:
        error = tables["rounding_error"] / metric.mean_length
        return metric._knowing(precision=Precision(tables["precision"], error))
    return metric


def _tables(
    tables: Tables, source: str | os.PathLike[str], merge: float | None, repeated: bool = False
) -> Tables:
    """Checked arrays of a file; meshes are converted to points and triangles."""
    name = "standard input" if source == "-" else str(source)
    if "faces" not in tables or not ("lengths" in tables or "vertices" in tables):
        if "polygons" in tables:
            raise FileError(f"{name} is a net: glue it first, with isoembed.glue({str(source)!r})")
        if "q_tt" in tables:
            raise FileError(
                f"{name} is a metric on a grid in theta and phi: "
                f"isoembed.relativity.read_grid_data({str(source)!r}) reads it"
            )
        there = ", ".join(tables) if tables else "nothing"
        raise FileError(
            f"{name} holds {there}: a metric needs faces and lengths (with edges), or faces and vertices; "
            "on a grid, theta, phi, q_tt, q_tp and q_pp"
        )
    for key in ("faces", "edges", "lengths", "length_errors", "diagonals", "vertices"):
        if isinstance(tables.get(key), np.ndarray):
            _check_array(tables[key], key)
    if "curvature" in tables:
        tables = _in_space(tables, name)
    if "rounding_error" in tables:
        tables = {**tables, **_precision(tables, name)}
    if "lengths" in tables:
        if merge is not None:
            raise FileError(f"{name} holds lengths: merging applies to files with vertices only")
        return tables
    merge = 0.0 if merge is None and repeated else merge
    options = {key: tables[key] for key in ("curvature", "precision", "rounding_error") if key in tables}
    vertices, triangles, diagonals = triangle_mesh(
        tables["vertices"],
        tables["faces"],
        merge,
        space=Space(options.get("curvature", 0.0)),
        leave_out=True,
        repeated=repeated,
        error=Precision("", options["rounding_error"]).vertex_error if "rounding_error" in options else 0.0,
    )
    if len(vertices) == len(tables["vertices"]):  # none was merged or omitted
        options |= {key: tables[key] for key in CURVATURES if key in tables}
    if len(diagonals):
        options["diagonals"] = diagonals
    return {"vertices": vertices, "faces": triangles, **options}


def _in_space(tables: Tables, name: str) -> Tables:
    """Tables with the file's curvature as a number, and the vertices as points of that space."""
    try:
        space = Space(float(tables["curvature"]))
    except (TypeError, ValueError, InvalidParameter):
        raise FileError(
            f"{name}: the curvature of space is {str(tables['curvature'])[:40]!r}, not a finite number"
        ) from None
    model = str(tables.get("model", WRITTEN))
    if model not in MODELS:
        raise FileError(f"{name}: the model is {model[:40]!r}, none of {', '.join(MODELS)}")
    found = {key: tables[key] for key in tables if key != "model"} | {"curvature": space.curvature}
    if "vertices" in tables:
        points = np.asarray(tables["vertices"], dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise FileError(f"{name} holds vertices of shape {points.shape}, not (V, 3)")
        try:
            found["vertices"] = from_model(space, points, model)
        except InvalidParameter as error:
            raise FileError(f"{name}: {error}") from None
    return found


def _precision(tables: Tables, name: str) -> Tables:
    """Precision of the coordinates stated in a file, with the error of a length in their unit."""
    try:
        error = float(tables["rounding_error"])
    except (TypeError, ValueError):
        error = math.nan
    if not 0 < error < math.inf:
        raise FileError(
            f"{name}: the rounding error is {str(tables['rounding_error'])[:40]!r}, not a positive finite "
            "number"
        )
    return {"precision": str(tables.get("precision", "few digits")), "rounding_error": error}


def _check_array(array: np.ndarray[Any, Any], key: str) -> None:
    if array.ndim == 0 and key != "length_errors":  # a scalar is valid for all lengths
        raise InvalidMetric(f"{key} is the single value {array.item()!r}, not an array")
    if array.dtype.kind not in "iuf":
        raise InvalidMetric(f"{key} has the type {array.dtype}, not numbers")
