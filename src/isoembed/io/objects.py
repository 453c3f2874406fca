"""Conversion of surfaces to trimesh and PyVista objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.embedding.embedding import Embedding
from isoembed.io.format import at_vertices, by_size, of_the_whole
from isoembed.io.surface import polygon_faces, surface_data

if TYPE_CHECKING:
    import pyvista
    import trimesh


def to_trimesh(embedding: Embedding) -> trimesh.Trimesh:
    """Convert a surface to a trimesh object with the same vertices and triangles.

    Returns
    -------
    trimesh.Trimesh
        ``vertex_attributes`` contain ``mean_curvature`` and ``residual`` (V,).  In hyperbolic and spherical
        space the vertices are conformal coordinates, and ``metadata`` contains the ``curvature``.

    Raises
    ------
    ImportError
        trimesh is not installed: ``pip install trimesh``.
    """
    try:
        import trimesh
    except ImportError:
        raise ImportError("to_trimesh needs trimesh: pip install trimesh") from None
    tables: dict[str, Any] = surface_data(embedding)
    return trimesh.Trimesh(
        tables["vertices"],
        embedding.faces,
        vertex_attributes=at_vertices(tables),
        metadata={name: float(value) for name, value in of_the_whole(tables).items()},
        process=False,  # keep the vertices and their order
    )


def to_pyvista(embedding: Embedding) -> pyvista.PolyData:
    """Convert a surface to a PyVista object: ``to_pyvista(surface).plot(scalars="mean_curvature")``.

    Returns
    -------
    pyvista.PolyData
        ``point_data`` contain ``mean_curvature`` and ``residual`` (V,).  The faces of a `ConvexPolyhedron`
        are polygons, except those with flat vertices inside.  In hyperbolic and spherical space the points
        are conformal coordinates, and ``field_data`` contain the ``curvature``.

    Raises
    ------
    ImportError
        PyVista is not installed: ``pip install pyvista``.
    """
    try:
        import pyvista
    except ImportError:
        raise ImportError("to_pyvista needs PyVista: pip install pyvista") from None
    tables: dict[str, Any] = surface_data(embedding)
    cells = [np.insert(rows, 0, rows.shape[1], axis=1).ravel() for rows in by_size(polygon_faces(embedding))]
    mesh = pyvista.PolyData(np.array(tables["vertices"]), np.concatenate(cells))
    mesh.point_data.update({name: np.array(values) for name, values in at_vertices(tables).items()})
    for name, value in of_the_whole(tables).items():
        mesh.field_data[name] = [float(value)]
    return mesh
