"""Reading and writing of surfaces; faces that are oriented inward are reversed."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.io.files import FileError, Tables, Writer, ending, write_atomically
from isoembed.io.format import CURVATURES, Polygons
from isoembed.io.metric import facts, metric_of, read_tables
from isoembed.io.registry import (
    FORMATS,
    MESH_ENDINGS,
    METRIC_ENDINGS,
    SURFACE_ENDINGS,
    check_output,
    tables_writer,
)
from isoembed.io.title_line import WRITTEN
from isoembed.method import TOLERANCE
from isoembed.metric.polygon_faces import PolygonFaces
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.surface import SheetEmbedding
from isoembed.space.models import to_model
from isoembed.surface.flat_faces import FlatFaces
from isoembed.surface.measures import volume


def read_surface(path: str | os.PathLike[str], *, merge: float | None = None) -> Embedding:
    """Read a surface.

    Parameters
    ----------
    path : path
        ``.npz`` or ``.json`` with ``faces`` (F, 3) and ``vertices`` (V, 3), or a mesh.  ``lengths`` (E,) with
        ``edges`` (E, 2), if present, are the metric; otherwise the metric is that of the vertices.  Faces
        whose normals point inward are reversed.  For a ``curvature``, see `read_metric`.
    merge : float, optional
        Merging distance; see `read_metric`.

    Returns
    -------
    Embedding
        The method is ``"given"``.  A convex surface with flat edges is a polyhedron with polygonal faces; a
        surface with boundary or of higher genus is a `SheetEmbedding`.

    Raises
    ------
    FileError
        The file cannot be read, its ending is unknown, or it has no vertices.
    InvalidMetric
        The contents are not a triangulated surface.
    """
    return read_with_curvatures(path, merge=merge)[0]


def read_with_curvatures(
    path: str | os.PathLike[str], *, merge: float | None = None
) -> tuple[Embedding, dict[str, Floats]]:
    """Read a surface, like `read_surface`, and the curvatures (V,) in the file, by name."""
    tables = read_tables(path, merge, (*METRIC_ENDINGS, *MESH_ENDINGS))
    if "vertices" not in tables:
        metric_of(tables)  # reports errors of the metric first
        raise FileError(
            f"{path} is a metric without vertices: embed it first, with isoembed.embed({str(path)!r})"
        )
    surface, n = surface_of(tables, str(path)), len(tables["vertices"])
    there = {name: np.asarray(tables[name]) for name in CURVATURES if name in tables}
    return surface, {
        name: values.astype(np.float64)
        for name, values in there.items()
        if values.shape == (n,) and values.dtype.kind in "iuf"
    }


def surface_of(tables: Tables, name: str) -> Embedding:
    """Surface from the arrays, including vertices, of the named file."""
    metric = metric_of(tables)
    vertices = np.ascontiguousarray(tables["vertices"], dtype=np.float64)
    if vertices.shape[1:] != (3,):
        raise FileError(f"{name} holds vertices of shape {vertices.shape}, not (V, 3)")
    has_lengths = "lengths" in tables
    own = metric
    if has_lengths:  # checks the vertices
        own = PolyhedralMetric.from_mesh(vertices, metric.faces, curvature=metric.curvature)
    message = "" if has_lengths else "the lengths are computed from the vertices in the file"
    if not metric.triangulation.is_sphere:
        return SheetEmbedding(
            metric, vertices, method="given", tolerance=TOLERANCE, message=message, condition="given"
        )
    straight = to_model(metric.space, vertices, "projective")
    if volume(metric.faces, np.asarray(straight / own.unit, dtype=np.float64)) < 0:
        metric = metric._turned_over
    surface = Embedding(metric, vertices, method="given", tolerance=TOLERANCE, message=message)
    if surface.surface.concave_edges.any():
        return surface
    polyhedron = Polyhedron(metric, vertices, method="given", tolerance=TOLERANCE, message=message)
    return surface if polyhedron.surface.flat_faces.edges.all() else polyhedron


def mesh_writer(path: str | os.PathLike[str], vertices: ArrayLike, faces: Polygons, **data: Floats) -> Writer:
    """Writer of a mesh with vertex data in the format of the path's ending; see `write_atomically`.

    If the data include a ``curvature``, the vertices are in conformal coordinates.
    """
    model = {"model": WRITTEN} if "curvature" in data else {}
    return tables_writer(path, {"vertices": np.asarray(vertices), "faces": faces, **data, **model})


def surface_writer(path: str | os.PathLike[str], embedding: Embedding) -> Writer:
    """Writer of a surface in the format of the path's ending; see `write_atomically`."""
    has_polygons = FORMATS[ending(path)].holds_polygons
    faces = polygon_faces(embedding) if has_polygons else embedding.faces
    return mesh_writer(path, faces=faces, **surface_data(embedding))


def surface_data(embedding: Embedding) -> dict[str, Floats]:
    """Data of a surface written to files, except its faces: see `write_surface`."""
    space = embedding.space
    return {
        "vertices": to_model(space, embedding.vertices, WRITTEN),
        "mean_curvature": embedding.mean_curvature,
        "residual": vertex_residuals(embedding),
        **facts(embedding.metric),
    }


def write_surface(path: str | os.PathLike[str], embedding: Embedding) -> None:
    """Write an embedding as arrays or as a mesh, depending on the file ending.

    Besides the vertices (V, 3) and faces (F, 3), formats with vertex data (all but OBJ, OFF and STL) store
    ``mean_curvature`` (V,), H = (k1 + k2) / 2, and ``residual`` (V,), the largest residual of the edges at
    each vertex.  The faces of a `ConvexPolyhedron` are polygons in formats that support them (not NPZ, JSON
    and STL).  Faces with flat vertices inside stay triangles, so that every given vertex is in a face; so do
    faces whose corners are off a plane by more than the known error of the vertices, if readers would cut
    them along other diagonals.

    In hyperbolic and spherical space the vertices are conformal coordinates: Poincare ball or stereographic
    projection.  The model and the ``curvature`` of space are stored as data (NPZ, JSON, FOLD and VTK
    formats) or in a comment or title.  The same holds for the ``precision`` of rounded coordinates from which
    the lengths were computed, and the ``rounding_error`` of a length.

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    """
    check_output(path, SURFACE_ENDINGS)
    write_atomically({Path(path): surface_writer(path, embedding)})


def polygon_faces(embedding: Embedding) -> Polygons:
    """Faces as polygons, or as triangles if the polygons have other vertices or would be cut differently.

    The surface is the same when read again: readers cut polygons, which are planar up to rounding, along
    diagonals of their choice.
    """
    faces, found = embedding.faces, embedding.surface.flat_faces
    if not isinstance(found, FlatFaces):
        return faces
    polygons, owners = found.polygons, found.of_triangles
    triangles = np.split(faces[np.argsort(owners, kind="stable")], np.cumsum(np.bincount(owners))[:-1])
    normalized = embedding.vertices / embedding.metric.unit
    points = to_model(embedding.metric.normalized.space, normalized, "projective")
    error = embedding.surface.vertex_error / embedding.metric.unit
    turned = [np.roll(polygon, 1) for polygon in polygons]
    flat, same = _cut_as(polygons, triangles, points, error)
    same_turned = _cut_as(turned, triangles, points, error)[1]
    out: list[Indices] = []
    for k, parts in enumerate(triangles):
        if same_turned[k] and not same[k]:
            out.append(turned[k])
        else:
            out += [polygons[k]] if same[k] or flat[k] else list(parts)
    return out


def _cut_as(
    polygons: Sequence[Indices], triangles: list[Indices], points: Floats, error: float
) -> tuple[list[bool], list[bool]]:
    """Whether polygons are planar up to the error of the points, and whether readers cut them as given.

    Both are false for polygons with fewer vertices than the triangles.
    """
    sizes = np.array([len(polygon) for polygon in polygons])
    cut = PolygonFaces(points, np.concatenate(polygons), sizes)
    own = np.split(cut.triangles(), np.cumsum(sizes - 2)[:-1])
    whole = [len(some) == len(parts) for some, parts in zip(own, triangles, strict=True)]
    flat = ~cut.warped(error, 1e-12) & whole  # rounding, relative to the size of a polygon
    near = ~cut.warped(error) & whole
    return flat.tolist(), [
        bool(is_near) and _corners(some) == _corners(parts)
        for is_near, some, parts in zip(near, own, triangles, strict=True)
    ]


def _corners(triangles: Indices) -> set[tuple[int, ...]]:
    return {tuple(row) for row in np.sort(triangles, axis=1).tolist()}


def vertex_residuals(embedding: Embedding) -> Floats:
    """Largest residual of the edges at each vertex, shape (V,)."""
    largest = np.zeros(embedding.triangulation.n_vertices)
    for end in embedding.metric.edges.T:
        np.maximum.at(largest, end, embedding.residuals)
    return largest
