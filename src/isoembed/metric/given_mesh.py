"""Preparation of input meshes, with warnings: coincident or unused vertices, polygons, T-junctions."""

import math
import numbers
import warnings
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote, warn_of_mesh
from isoembed.mesh.checks import polygon_corners, real_array
from isoembed.mesh.merging import representatives, without_repetitions
from isoembed.mesh.polygons import next_corners
from isoembed.mesh.side_splitting import slivers, vertices_on_sides, with_vertices_on_sides
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polygon_faces import PolygonFaces
from isoembed.reprs import rounded_up
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class MergingThresholds:
    """Thresholds for coincident vertices."""

    usual: float = threshold(
        1e-5, "mean edge lengths", "Distance within which vertices coincide: rounding in single precision."
    )
    near: float = threshold(
        1e-2, "mean edge lengths", "Distance of boundary vertices that may be duplicates."
    )


MERGING = MergingThresholds()


class TriangleMesh(NamedTuple):
    """Triangles of a mesh, some of which are parts of planar polygons.

    Attributes
    ----------
    points : ndarray, shape (V, n)
    triangles : ndarray of int64, shape (F, 3)
    diagonals : ndarray of int64, shape (D, 2)
        Ends of the edges inside planar polygons.
    """

    points: Floats
    triangles: Indices
    diagonals: Indices


NO_DIAGONALS = np.empty((0, 2), dtype=np.int64)


def triangle_mesh(
    vertices: ArrayLike,
    faces: ArrayLike,
    merge: float | None = None,
    *,
    space: Space = EUCLIDEAN,
    leave_out: bool = False,
    repeated: bool = False,
    error: float = 0.0,
) -> TriangleMesh:
    """Triangles of a mesh; changes are reported by a `MeshNote`.

    Parameters
    ----------
    vertices : array_like of float, shape (V, n)
    faces : array_like of int, shape (F, 3), or polygons of any sizes in space
        Polygons are cut into triangles; nonplanar ones are reported.
    merge : float, optional
        Vertices within this distance, in mean edge lengths, are merged into the first of them; at 0, equal
        ones.  Faces that degenerate to edges or points are removed.  Above 0, sides of only one face are
        split at vertices within this distance.
    space : Space
        Space of the vertices: polygons are cut along its geodesics.
    leave_out : bool
        Remove vertices in no face, possibly renumbering others; so does `merge`.
    repeated : bool
        Every face has its own vertices, so that merging is not reported.
    error : float
        Bound on the error of a vertex from rounded coordinates, as a tolerance of planarity.

    Returns
    -------
    TriangleMesh
        With the given vertices and faces if there is nothing to do.

    Raises
    ------
    InvalidMetric
        A coordinate or an index is invalid, or a polygon cannot be cut.
    InvalidParameter
        `merge` is not a number from 0 to below 1.
    """
    points = real_array(vertices, "vertex", "coordinate")
    if points.ndim != 2:
        raise InvalidMetric(f"the vertices have shape {points.shape}, not (V, 3)")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        v = int(np.argmin(finite))
        raise InvalidMetric(f"vertex {v} has the coordinates {points[v].tolist()}, which are not finite")
    corners, sizes = all_corners, all_sizes = polygon_corners(faces)
    if corners.max() >= len(points):
        raise InvalidMetric(
            f"a face refers to vertex {corners.max()}, but there are only {len(points)} vertices"
            f"{': their table looks transposed' if len(points) == 3 < points.shape[1] else ''}"
        )
    if merge is None and not leave_out and (sizes == 3).all():
        return TriangleMesh(points, corners.reshape(-1, 3), NO_DIAGONALS)
    if merge is not None:
        if not isinstance(merge, numbers.Real) or not 0 <= merge < 1:
            raise InvalidParameter(f"merge is {merge!r}, not a number of mean edge lengths in [0, 1)")
        corners, sizes = _merged(_scaled(points), corners, sizes, merge, repeated)
    straight = _scaled(to_model(space, points, "projective"))
    if merge:
        corners, sizes = _split(straight, corners, sizes, merge * _mean_side(straight, corners, sizes))
    if len(sizes) == len(all_sizes):
        _check_sides(corners, sizes)
    if (sizes == 3).all():
        triangles, diagonals = corners.reshape(-1, 3), NO_DIAGONALS
    else:
        triangles, diagonals = _cut(straight, corners, sizes, math.ldexp(error, -_exponent(points)))
    mesh = TriangleMesh(points, triangles, diagonals)
    return mesh if merge is None and not leave_out else _renumbered(mesh, all_corners)


def _check_sides(corners: Indices, sizes: Indices) -> None:
    """Raise an error if a side is in more than two polygons, by their numbers before they are cut."""
    after = corners[next_corners(sizes)]
    keys = np.minimum(corners, after) * (corners.max() + 1) + np.maximum(corners, after)
    _, of_side, count = np.unique(keys, return_inverse=True, return_counts=True)
    over = count[of_side] > 2
    if not over.any():
        return
    k = int(np.argmax(over))
    inside = np.repeat(np.arange(len(sizes)), sizes)[of_side == of_side[k]].tolist()
    polygons = np.split(corners, np.cumsum(sizes)[:-1])
    first: dict[frozenset[int], int] = {}
    doubles = [
        f"face {f} repeats face {g}"
        for f in inside
        if (g := first.setdefault(frozenset(polygons[f].tolist()), f)) != f
    ]
    raise InvalidMetric(
        f"edge {sorted((int(corners[k]), int(after[k])))} is in {len(inside)} faces {inside}, not in 2"
        f"{': ' if doubles else ''}{' and '.join(doubles)}"
    )


def merging_advice(points: Floats, faces: ArrayLike, space: Space = EUCLIDEAN) -> str:
    """Clause on faces that do not form a closed surface: advice to merge vertices.

    Merging is tried before it is advised.
    """
    corners, sizes = polygon_corners(faces)
    scaled = _scaled(points)
    mean = _mean_side(scaled, corners, sizes)
    if mean == 0:
        return ""
    found = [_coincidences(scaled, corners, sizes, mean), _junctions(scaled, corners, sizes, mean)]
    for fact, remedy, farthest in filter(None, found):
        needed = "" if farthest <= MERGING.usual else rounded_up(farthest, 1)
        tolerance = needed or f"{MERGING.usual:g}"
        if _is_mended(points, faces, float(tolerance), space):
            return f"; {fact}: {remedy} with merge={tolerance}"
    return f"; {found[0][0]}, but merging them does not close the surface" if found[0] else ""


Finding = tuple[str, str, float]
"""Fact, remedy, and the tolerance needed, in mean edge lengths."""


def _coincidences(points: Floats, corners: Indices, sizes: Indices, mean: float) -> Finding | None:
    after = corners[next_corners(sizes)]
    edges, count = np.unique(np.sort([corners, after], axis=0), axis=1, return_counts=True)
    lengths = np.linalg.norm(points[edges[0]] - points[edges[1]], axis=1)
    suspects = np.unique(edges[:, (count == 1) | (lengths == 0)])
    if suspects.size < 2:
        return None
    from scipy.spatial import cKDTree  # slow to import, rarely needed

    distances, near = cKDTree(points[suspects]).query(points[suspects], k=2)
    distances = distances[:, 1] / mean
    close = distances <= MERGING.near
    if not close.any():
        return None
    first = int(np.argmax(close))
    pair = sorted({int(suspects[first]), *suspects[near[first]].tolist()})[:2]
    farthest = float(distances[close].max())
    nearly = "nearly " if farthest > MERGING.usual else ""
    fact = f"{close.sum()} vertices {nearly}coincide with others (vertex {pair[0]} and {pair[1]})"
    return fact, "merge them", farthest


def _junctions(points: Floats, corners: Indices, sizes: Indices, mean: float) -> Finding | None:
    left = ~slivers(points, corners, sizes, MERGING.near * mean)
    corners, sizes = corners[np.repeat(left, sizes)], sizes[left]
    places, vertices, offsets = vertices_on_sides(points, corners, sizes, MERGING.near * mean)
    if not len(places):
        return None
    a, b = corners[places[0]], corners[next_corners(sizes)][places[0]]
    fact = (
        f"vertex {vertices[0]} is on the side from vertex {a} to vertex {b} of another face (a T-junction, "
        f"{len(places)} in all)"
    )
    return fact, "split such sides", float(offsets.max()) / mean


def _is_mended(points: Floats, faces: ArrayLike, merge: float, space: Space) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshNote)
        try:
            Triangulation(triangle_mesh(points, faces, merge, space=space).triangles).check_sphere()
        except InvalidMetric:
            return False
    return True


def _scaled(points: Floats) -> Floats:
    """Points scaled to order 1."""
    return np.ldexp(points, -_exponent(points))


def _exponent(points: Floats) -> int:
    return int(np.frexp(np.abs(points).max(initial=0.0))[1])


def _side_advice(points: Floats, corners: Indices, sizes: Indices) -> str:
    """Clause on a polygon without area, if the reason is sides without length."""
    after = corners[next_corners(sizes)]
    lengths = np.linalg.norm(points[corners] - points[after], axis=1)
    short = lengths <= MERGING.usual * lengths.mean()
    polygons = np.split(corners, np.cumsum(sizes)[:-1])
    if not short.any() or not _is_mended(points, polygons, MERGING.usual, EUCLIDEAN):
        return ""
    k = int(np.argmax(short))
    return (
        f"; {_count(short.sum(), 'side has', 'sides have')} no length (the first from vertex {corners[k]} "
        f"to {after[k]}): merge vertices that coincide with merge={MERGING.usual:g}"
    )


def _merged(
    points: Floats, corners: Indices, sizes: Indices, merge: float, quiet: bool
) -> tuple[Indices, Indices]:
    is_used = np.bincount(corners) > 0
    used, corner = np.flatnonzero(is_used), (np.cumsum(is_used) - 1)[corners]
    ends = np.cumsum(sizes)
    mean = _mean_side(points, corners, sizes)
    first = representatives(points[used], merge * mean)
    moved = first != np.arange(len(used))
    if moved.any() and not quiet:
        v = int(np.argmax(moved))
        warn_of_mesh(
            f"{_count(moved.sum(), 'vertex is', 'vertices are')} merged with others; the first is "
            f"vertex {used[v]} with vertex {used[first[v]]}"
        )
    new_corners, new_sizes, left = without_repetitions(used[first[corner]], sizes)
    if not left.all():
        f = int(np.argmin(left))
        warn_of_mesh(
            f"{_count((~left).sum(), 'face is', 'faces are')} reduced to an edge or a point by "
            f"merging, and left out; the first is face {f} "
            f"{corners[ends[f] - sizes[f] : ends[f]].tolist()}"
        )
    if not left.any():
        raise InvalidMetric("there are no faces: all have merged into edges and points")
    return new_corners, new_sizes


def _mean_side(points: Floats, corners: Indices, sizes: Indices) -> float:
    sides = np.linalg.norm(points[corners] - points[corners[next_corners(sizes)]], axis=1)
    return float(sides[sides > 0].mean()) if (sides > 0).any() else 0.0


def _split(points: Floats, corners: Indices, sizes: Indices, distance: float) -> tuple[Indices, Indices]:
    """Faces with sides split at vertices on them, without triangles of zero area."""
    thin = slivers(points, corners, sizes, distance)
    if thin.all():
        return corners, sizes
    if thin.any():
        warn_of_mesh(
            f"{_count(thin.sum(), 'triangle without area is', 'triangles without area are')} left out"
        )
        corners, sizes = corners[~np.repeat(thin, sizes)], sizes[~thin]
    places, vertices, _ = vertices_on_sides(points, corners, sizes, distance)
    if len(places):
        a, b = corners[places[0]], corners[next_corners(sizes)][places[0]]
        warn_of_mesh(
            f"{_count(len(places), 'vertex', 'vertices')} on sides of other faces (T-junctions) split them; "
            f"the first is vertex {vertices[0]} on the side from vertex {a} to {b}"
        )
    return with_vertices_on_sides(corners, sizes, places, vertices)


def _cut(points: Floats, corners: Indices, sizes: Indices, error: float) -> tuple[Indices, Indices]:
    """Triangles of polygons, and the diagonals of those that are planar."""
    if points.shape[1] != 3:
        raise InvalidMetric(
            f"face {np.argmax(sizes != 3)} has {sizes[np.argmax(sizes != 3)]} corners, and the "
            f"vertices have {points.shape[1]} coordinates: only polygons with coordinates in R^3 are "
            "triangulated"
        )
    polygons = PolygonFaces(points, corners, sizes)
    try:
        triangles = polygons.triangles()
    except InvalidMetric as refusal:
        raise InvalidMetric(f"{refusal}{_side_advice(points, corners, sizes)}") from None
    warps, warped = polygons.warps, polygons.warped(error)
    if warped.any():
        f = int(np.argmax(warped))
        warn_of_mesh(
            f"{_count(warped.sum(), 'face is', 'faces are')} not planar, and replaced by triangles; "
            f"the first is face {f}, with corners {warps[f]:.1g} of its size off a plane"
        )
    owners = np.where(warped | (sizes == 3), -1, np.arange(len(sizes)))
    return triangles, _diagonals(triangles, np.repeat(owners, sizes - 2))


def _diagonals(triangles: Indices, polygon: Indices) -> Indices:
    """Edges between triangles of one polygon, (D, 2); triangles with the number -1 are in none."""
    inside = polygon >= 0
    triangles, polygon = triangles[inside], np.repeat(polygon[inside], 3)
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    order = np.lexsort([polygon, *ends.T])
    ends, polygon = ends[order], polygon[order]
    same = (ends[1:] == ends[:-1]).all(axis=1) & (polygon[1:] == polygon[:-1])
    return ends[1:][same]


def _renumbered(mesh: TriangleMesh, all_corners: Indices) -> TriangleMesh:
    """Vertices in triangles, renumbered; reports those that were not in the given faces either."""
    points, triangles, diagonals = mesh
    used = np.bincount(triangles.ravel(), minlength=len(points)) > 0
    if used.all():
        return mesh
    unused = np.bincount(all_corners, minlength=len(points)) == 0
    if unused.any():
        warn_of_mesh(
            f"{_count(unused.sum(), 'vertex is', 'vertices are')} in no face, and left out; the first is "
            f"vertex {np.argmax(unused)}"
        )
    numbers = np.cumsum(used) - 1
    return TriangleMesh(points[used], numbers[triangles], numbers[diagonals])


def _count(number: int, one: str, more: str) -> str:
    return f"{number} {one if number == 1 else more}"
