"""Checks of triangle lists (manifold, oriented, connected); errors name the first offender."""

import numbers
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric, warn_of_mesh
from isoembed.mesh.components import components

LARGEST = 2**62  # fits into 64 bits; gaps among the indices are rejected anyway


def index_array(values: ArrayLike, columns: int, item: str, part: str) -> Indices:
    """Read an (n, columns) table of vertex indices.

    Parameters
    ----------
    values : array_like
        Table as given.
    columns : int
        Number of indices per row.
    item, part : str
        Names of a row ("face") and of its entries ("corners"), for messages.

    Returns
    -------
    ndarray of int64, shape (n, columns)

    Raises
    ------
    InvalidMetric
        The table is empty, a row has the wrong length, or an entry is not a nonnegative integer.
    """
    rows = values if isinstance(values, np.ndarray) and values.ndim else _rows(values, item)
    if len(rows) == 0:
        raise InvalidMetric(f"there are no {item}s")
    if not isinstance(rows, np.ndarray):
        for k, row in enumerate(rows):
            if np.ndim(row) != 1 or len(row) != columns:
                raise InvalidMetric(f"{item} {k} has {np.size(row)} {part} {row!r}, not {columns}")
            _check_entries(row, item, k)
    table = np.asarray(rows)
    if table.ndim != 2 or table.shape[1] != columns:
        if table.ndim == 2:
            shown = table[0].tolist() if table.shape[1] < 10 else ""
            hint = ": it looks transposed" if len(table) == columns else ""
            raise InvalidMetric(
                f"{item} 0 has {table.shape[1]} {part} {shown}".rstrip() + f", not {columns}{hint}"
            )
        raise InvalidMetric(f"the {item}s have shape {table.shape}, not (n, {columns})")
    if table.dtype.kind not in "iuf":
        raise InvalidMetric(
            f"{item} 0 refers to vertex {table[0, 0].item()!r}: vertex indices must be whole numbers"
        )
    return _natural(table.ravel(), item, lambda k: k // columns).reshape(-1, columns)


def polygon_corners(faces: ArrayLike) -> tuple[Indices, Indices]:
    """Read polygons of any sizes.

    Parameters
    ----------
    faces : array_like of int, shape (F, n), or sequence of sequences of int
        Vertices around each polygon.

    Returns
    -------
    corners : ndarray of int64
        Concatenated corners of all polygons.
    sizes : ndarray of int64, shape (F,)
        Number of corners of each.

    Raises
    ------
    InvalidMetric
        There are no polygons, one has fewer than three corners, or an entry is not a nonnegative integer.
    """
    if isinstance(faces, np.ndarray):
        columns = faces.shape[1] if faces.ndim == 2 else 3
        if columns < 3 and len(faces):
            raise InvalidMetric(f"face 0 has {columns} corners {faces[0].tolist()}, not 3 or more")
        table = index_array(faces, columns, "face", "corners")
        return table.ravel(), np.full(len(table), columns)
    rows = _rows(faces, "face")
    if not rows:
        raise InvalidMetric("there are no faces")
    for k, row in enumerate(rows):
        if np.ndim(row) != 1 or len(row) < 3:
            raise InvalidMetric(f"face {k} has {np.size(row)} corners {row!r}, not 3 or more")
        _check_entries(row, "face", k)
    sizes = np.array([len(row) for row in rows])
    ends = np.cumsum(sizes)
    corners = np.concatenate([np.asarray(row) for row in rows])
    return _natural(corners, "face", lambda k: int(np.searchsorted(ends, k, side="right"))), sizes


def _check_entries(row: Any, item: str, k: int) -> None:
    """Raise an error if entries of a row are not numbers, or too large."""
    for index in row:
        if isinstance(index, bool) or not isinstance(index, numbers.Real):
            raise InvalidMetric(
                f"{item} {k} refers to vertex {index!r}: vertex indices must be whole numbers"
            )
        if isinstance(index, int) and abs(index) > LARGEST:
            raise InvalidMetric(f"{item} {k} refers to vertex {index}: the index is too large")


def _rows(values: ArrayLike, item: str) -> list[Any]:
    try:
        return list(values)  # type: ignore[arg-type]
    except TypeError:
        raise InvalidMetric(f"the {item}s are {values!r}, not a list") from None


def _natural(indices: NDArray, item: str, row: Callable[[int], int]) -> Indices:
    """Convert indices to integers, or raise an error at the first invalid one; `row` maps it to its row."""
    checks = [
        (indices < 0, "vertex indices must not be negative"),
        (indices > LARGEST, "the index is too large"),
    ]
    if indices.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            broken = (indices != np.floor(indices)) | ~np.isfinite(indices)
        checks.insert(0, (broken, "vertex indices must be whole numbers"))
    for bad, why in checks:
        if bad.any():
            k = int(np.argmax(bad))
            raise InvalidMetric(f"{item} {row(k)} refers to vertex {indices[k]}: {why}")
    return np.ascontiguousarray(indices, dtype=np.int64)


def real_array(data: ArrayLike, item: str, quantity: str) -> Floats:
    """Float copy of an array of real numbers; raises an error at the first invalid entry."""
    try:
        values = np.asarray(data)
    except ValueError:  # rows of different sizes
        sizes = [np.size(row) for row in data]  # type: ignore[union-attr]
        k = next(k for k, size in enumerate(sizes) if size != sizes[0])
        raise InvalidMetric(f"{item} {k} has {sizes[k]} {quantity}s, {item} 0 has {sizes[0]}") from None
    if np.ma.is_masked(data):  # the number below the mask may be anything
        k = int(np.argwhere(np.ma.getmaskarray(np.ma.asarray(data)))[0][0])
        raise InvalidMetric(f"{item} {k} has a masked {quantity}, not a finite number")
    if values.dtype.kind not in "iuf":
        for k, row in enumerate(data if np.ndim(data) else [data]):  # type: ignore[arg-type]
            for value in np.ravel(np.array(row, dtype=object)):
                number = isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)
                if not number or abs(value) > sys.float_info.max:
                    raise InvalidMetric(f"{item} {k} has {quantity} {value!r}, not a finite number")
    return values.astype(np.float64)


def checked_tables(faces: Indices) -> tuple[Indices, Indices, Indices]:
    """Build the tables of a `Triangulation`, with a check at every step.

    Faces oriented opposite to face 0 are reversed in place, with a `MeshNote`.

    Raises
    ------
    InvalidMetric
        The faces are not a connected oriented surface; the message names the first offender.
    """
    _check_faces(faces)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    n = int(faces.max()) + 1
    keys, of_halfedge = np.unique(np.minimum(start, end) * n + np.maximum(start, end), return_inverse=True)
    edges = np.column_stack(np.divmod(keys, n))
    face_edges = of_halfedge.reshape(-1, 3)
    over = _turned_over(edges, face_edges, faces)
    if over.any():
        f = int(np.argmax(over))
        warn_of_mesh(
            f"{over.sum()} of {len(faces)} faces are reversed to match the orientation of face 0: the "
            f"first is face {f} {faces[f].tolist()}"
        )
        faces[over] = faces[over, ::-1]
        return checked_tables(faces)
    along = start < end
    edge_sides = np.full((len(edges), 2), -1)
    edge_sides[face_edges.ravel()[along], 0] = np.flatnonzero(along)
    edge_sides[face_edges.ravel()[~along], 1] = np.flatnonzero(~along)
    _check_manifold(faces, edges, edge_sides)
    return edges, face_edges, edge_sides


def check_numbering(faces: Indices) -> None:
    """Raise `InvalidMetric` if the vertices of the faces (F, 3) are not numbered without gaps."""
    largest = int(faces.max())
    used = np.zeros(min(largest, faces.size) + 1, dtype=np.bool_)
    used[faces[faces < used.size]] = True
    if not used.all():
        f = int(np.argmax((faces == largest).any(axis=1)))
        raise InvalidMetric(
            f"vertex {int(np.argmin(used))} is in no face, while face {f} refers to vertex {largest}: "
            "vertices must be numbered from 0 without gaps"
        )


def check_euler(n_vertices: int, n_faces: int) -> None:
    """Raise `InvalidMetric` if a closed connected surface is not a sphere."""
    euler = n_vertices - n_faces // 2
    if euler != 2:
        raise InvalidMetric(
            f"the surface has Euler characteristic {euler} (genus {1 - euler // 2}), not 2: not a sphere"
        )


def _check_faces(faces: Indices) -> None:
    """Raise an error if faces repeat a vertex or another face, or leave gaps among the indices."""
    repeated = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    if repeated.any():
        f = int(np.argmax(repeated))
        raise InvalidMetric(f"face {f} {faces[f].tolist()} repeats a vertex")
    check_numbering(faces)
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    same = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    if same.any() and len(faces) > 2:  # two faces on three vertices are a doubly covered triangle
        f = int(order[1:][same].min())
        original = int(np.argmax((corners == corners[f]).all(axis=1)))
        raise InvalidMetric(f"face {f} {faces[f].tolist()} repeats face {original}")


def _turned_over(edges: Indices, face_edges: Indices, faces: Indices) -> Mask:
    """Mask of faces to reverse for an orientation consistent with the first of their component, shape (F,).

    Raises an error if an edge is in more than two faces, or the surface is not orientable.
    """
    count = np.bincount(face_edges.ravel(), minlength=len(edges))
    if (count > 2).any():
        e = int(np.argmax(count > 2))
        inside = np.flatnonzero((face_edges == e).any(axis=1)).tolist()
        raise InvalidMetric(f"edge {edges[e].tolist()} is in {count[e]} faces {inside}, not in 2")
    order = np.argsort(face_edges.ravel(), kind="stable")
    order = order[(count == 2)[face_edges.ravel()[order]]]
    left, right = (order // 3).reshape(-1, 2).T
    start = faces.ravel()[order].reshape(-1, 2)
    alike = start[:, 0] != start[:, 1]
    if alike.all():
        return np.zeros(len(faces), dtype=np.bool_)
    # Two copies of every face, one for each orientation: a component that contains both is not orientable.
    F = len(faces)
    u = np.concatenate([left, left + F])
    v = np.concatenate([np.where(alike, right, right + F), np.where(alike, right + F, right)])
    label = components(u, v, 2 * F)
    if (label[:F] == label[F:]).any():
        raise InvalidMetric("the surface cannot be oriented (it is one-sided)")
    # Labels are in the order of first nodes: the copy containing a component's first face has the lower one.
    return label[:F] > label[F:]


def _check_manifold(faces: Indices, edges: Indices, edge_sides: Indices) -> None:
    """Raise an error if an oriented surface is disconnected or has pinched vertices."""
    n = int(faces.max()) + 1
    label = components(edges[:, 0], edges[:, 1], n)
    parts = int(label.max()) + 1
    if parts > 1:
        v = int(np.argmax(label != label[0]))
        raise InvalidMetric(
            f"the surface has {parts} components, which must be embedded separately: vertex {v} is not "
            "connected to vertex 0"
        )
    # Around a vertex: corner c of face f is followed by the corner across the half-edge that enters it.
    twin = np.full(faces.size, -1)
    inner = edge_sides[(edge_sides >= 0).all(axis=1)]
    twin[inner[:, 0]], twin[inner[:, 1]] = inner[:, 1], inner[:, 0]
    corner = np.arange(faces.size)
    across = twin[corner + np.where(corner % 3 == 0, 2, -1)]
    fan = components(corner[across >= 0], across[across >= 0], faces.size)
    first = np.full(n, -1)
    first[faces.ravel()[::-1]] = fan[::-1]
    pinched = first[faces.ravel()] != fan
    if pinched.any():
        v = int(faces.ravel()[np.argmax(pinched)])
        raise InvalidMetric(
            f"the faces around vertex {v} form more than one fan: the surface is not a manifold"
        )
