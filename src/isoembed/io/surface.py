"""Surfaces into files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.io.files import Tables, Writer, check_output, ending, write_whole
from isoembed.io.registry import FORMATS, SURFACE_ENDINGS
from isoembed.surface.embedding import Embedding


def mesh_writer(
    path: str | os.PathLike[str], vertices: ArrayLike, faces: ArrayLike, **data: NDArray[np.float64]
) -> Writer:
    """Return what writes a mesh with data at its vertices in the format of this ending; see `write_whole`."""
    return _writer(path, {"vertices": np.asarray(vertices), "faces": np.asarray(faces), **data})


def surface_writer(path: str | os.PathLike[str], embedding: Embedding) -> Writer:
    """Return what writes the surface in the format of this ending; see `write_whole`."""
    return _writer(
        path,
        {
            "vertices": embedding.vertices,
            "faces": embedding.faces,
            "mean_curvature": embedding.mean_curvature,
            "residual": vertex_residuals(embedding),
        },
    )


def write_surface(path: str | os.PathLike[str], embedding: Embedding) -> None:
    """Write an embedding as arrays or as a mesh, by the ending of the file.

    With the vertices (V, 3) and faces (F, 3) go ``mean_curvature`` (V,), H = (k1 + k2) / 2, and
    ``residual`` (V,), the largest residual of the edges at each vertex, where the format has a place for
    them (not in OBJ, OFF and STL).

    Raises
    ------
    FileError
        The ending is not known or the file cannot be written.
    """
    check_output(path, SURFACE_ENDINGS)
    write_whole({Path(path): surface_writer(path, embedding)})


def vertex_residuals(embedding: Embedding) -> NDArray[np.float64]:
    """Largest residual of the edges at each vertex, shape (V,)."""
    largest = np.zeros(embedding.triangulation.n_vertices)
    for end in embedding.metric.edges.T:
        np.maximum.at(largest, end, embedding.residuals)
    return largest


def _writer(path: str | os.PathLike[str], tables: Tables) -> Writer:
    return lambda temporary: FORMATS[ending(path)].write(temporary, tables)
