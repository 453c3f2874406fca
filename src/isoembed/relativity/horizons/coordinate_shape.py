"""Coordinate shape of a horizon: points in slice coordinates and the surface through them.

Coordinate lengths are not lengths on the horizon, which require the 3-metric.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError
from isoembed.mesh.edge_tables import edge_tables
from isoembed.mesh.merging import representatives
from isoembed.reprs import short_repr


@short_repr
@dataclass(frozen=True, eq=False)
class CoordinateShape:
    """Closed surface of genus 0 in the coordinates of a slice of spacetime.

    Attributes
    ----------
    points : ndarray, shape (V, 3)
        Distinct points on the surface, in the coordinates of the file.
    faces : ndarray of int, shape (F, 3)
        Triangles, counterclockwise as seen from outside.
    center : ndarray, shape (3,)
        Point inside.  The surface is star-shaped about it unless the file has triangles.
    time : float or None
        Time of the slice, if in the file.
    name : str
        Name of the horizon.
    source : str
        Name of the file.
    fields : mapping of str to ndarray, shape (V,)
        Other quantities of the file at the points.
    iteration : int or None
        Iteration of the simulation, if known from the file.
    is_hull : bool
        Whether the triangles are the convex hull of the directions from the center.
    notes : tuple of str
        Assumptions made in reading the file, as sentences.
    """

    points: Floats
    faces: Indices
    center: Floats
    time: float | None = None
    name: str = ""
    source: str = ""
    fields: Mapping[str, Floats] = field(default_factory=dict)
    iteration: int | None = None
    is_hull: bool = False
    notes: tuple[str, ...] = ()

    @classmethod
    def star_shaped(
        cls,
        points: Floats,
        source: str,
        center: Floats | None = None,
        polygons: Iterable[Sequence[int]] = (),
        fields: Mapping[str, Floats] | None = None,
        time: float | None = None,
    ) -> CoordinateShape:
        """Star-shaped surface through points; see `triangulate_star_shaped`.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
        source : str
            Name of the file, for messages.
        center : ndarray, shape (3,), optional
            By default the center of the best-fit sphere.
        polygons : iterable of sequences of int
            Polygons of the file, with or without repetition of the first vertex.
        fields : mapping of str to ndarray, shape (n,) or (n, k)
            Values at the points.
        time : float, optional

        Raises
        ------
        FileError
            The points do not form a surface around the center; the message names the file.
        """
        check_solid(points, source)
        center = middle(points) if center is None else center
        indices, faces = triangulate_star_shaped(points, center, source, polygons)
        there = {name: values[indices] for name, values in (fields or {}).items()}
        return cls(points[indices], faces, center, time, source=source, fields=there, is_hull=True)

    def __post_init__(self) -> None:
        for array in (self.points, self.faces, self.center, *self.fields.values()):
            array.flags.writeable = False

    @property
    def contents(self) -> str:
        """Sentence on the quantities that the file contains and lacks."""
        here = f"the coordinates of {len(self.points)} points of a horizon"
        if self.fields:
            names = ", ".join(list(self.fields)[:4]) + (", ..." if len(self.fields) > 4 else "")
            here += f" and {names} there"
        return (
            f"{self.source or 'this'} holds {here}, but no metric: "
            "lengths on the horizon need the 3-metric of the slice along it"
        )


def triangulate_star_shaped(
    points: Floats,
    center: Floats,
    source: str,
    polygons: Iterable[Sequence[int]] = (),
    same: float = 1e-6,
) -> tuple[Indices, Indices]:
    """Triangulate a closed surface through scattered points that is star-shaped about a center.

    Raises `FileError`: there are fewer than four points, they are coplanar, one is not finite or coincides
    with the center, two different points have the same direction, a polygon is inverted, or a range of
    directions has no points; the message names the first such point or the direction.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Points in any order; points on seams may be repeated.
    center : ndarray, shape (3,)
    source : str
        Name of the file, for messages.
    polygons : iterable of sequences of int
        Polygons of the file, with or without repetition of the first vertex, to detect folds.
    same : float
        Largest angle between copies of a point, in radians.

    Returns
    -------
    indices : ndarray of int, shape (V,)
        Indices of the distinct points.
    faces : ndarray of int, shape (F, 3)
        Outward triangles, as indices into ``indices``: the convex hull of the directions.
    """
    check_solid(points, source)
    arrow = points - center
    scale = np.max(np.abs(arrow), initial=0.0)
    r = scale * np.linalg.norm(arrow / (scale or 1.0), axis=1)
    inside = ~(r > 1e-9 * scale)  # a point at the center has no direction
    if inside.any():
        raise FileError(
            f"{source}: point {int(np.argmax(inside))} is at the center: "
            f"that is not a surface around {_triple(center)}"
        )
    u = arrow / r[:, None]
    first = representatives(u, same)
    # Copies of a point have the same radius, up to the rounding of printed digits.
    differs = np.abs(r - r[first]) > 1e-4 * r
    if differs.any():
        i = int(np.argmax(differs))
        raise FileError(
            f"{source}: the points {first[i]} and {i}, {_triple(points[first[i]])} and {_triple(points[i])}, "
            f"are in one direction from the center {_triple(center)}: the surface is not star-shaped about it"
        )
    _check_turns(u, polygons, points, center, source)
    indices = np.unique(first)
    v = u[indices]
    if _dimension(v) < 3:  # points on a cone, too
        raise FileError(
            f"{source}: the directions of the points from the center {_triple(center)} lie in a plane: "
            "the surface is not complete"
        )
    hull = ConvexHull(v)
    hole = int(np.argmax(hull.equations[:, 3]))
    # A cap of angular radius 60 degrees without points is a hole.
    if hull.equations[hole, 3] > -np.cos(np.pi / 3):
        raise FileError(
            f"{source}: there are no points around the direction {_triple(hull.equations[hole, :3])} "
            f"from the center {_triple(center)}: the surface is not complete, or not star-shaped about it, "
            "which takes triangles (faces) between the points"
        )
    faces = hull.simplices.astype(np.int64)
    inward = np.einsum("fi,fi->f", v[faces[:, 0]], np.cross(v[faces[:, 1]], v[faces[:, 2]])) < 0
    faces[inward] = faces[inward][:, ::-1]
    left = np.setdiff1d(np.arange(len(v)), faces)
    if len(left) or edge_tables(faces) is None:
        where = f" at {_triple(points[indices[left[0]]])}" if len(left) else ""
        raise FileError(f"{source}: the points are too close to one another{where} to be triangulated")
    return indices, faces


def check_solid(points: Floats, source: str) -> None:
    """Check that points (n, 3) can lie on a closed surface.

    Raises `FileError`: there are fewer than four, one is not finite, or they are coplanar; the message names
    the file.
    """
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise FileError(f"{source}: point {int(np.argmax(bad))} is not finite")
    if len(points) < 4:
        raise FileError(f"{source}: {len(points)} points: that is not a surface, which has at least 4")
    dimension = _dimension(points)
    if dimension < 3:
        where = ("are one point", "lie on a line", "lie in a plane")[dimension]
        raise FileError(f"{source}: the {len(points)} points {where}: that is not a closed surface")


def middle(points: Floats) -> Floats:
    """Center (3,) of the best-fit sphere of points (n, 3), nearly independent of their density."""
    mean = points.mean(axis=0)
    arrow = points - mean
    scale = np.max(np.abs(arrow)) or 1.0
    arrow = arrow / scale
    # |x|^2 = 2 c . x + d
    matrix = np.column_stack([2.0 * arrow, np.ones(len(arrow))])
    solution = np.linalg.lstsq(matrix, np.einsum("ni,ni->n", arrow, arrow), rcond=None)[0]
    return mean + scale * solution[:3]


def _dimension(points: Floats) -> int:
    """Dimension of the affine hull of finite points (n, 3)."""
    x = points / (np.max(np.abs(points)) or 1.0)
    arrow = x - x[0]
    # Thinner sets count as flat.
    thin = 1e-9 * np.max(np.abs(arrow)) + 8.0 * np.finfo(np.float64).eps
    return int(np.linalg.matrix_rank(arrow, tol=thin * np.sqrt(len(points))))


def _check_turns(
    u: Floats, polygons: Iterable[Sequence[int]], points: Floats, center: Floats, source: str
) -> None:
    """Check that all triangles of the polygons have the same orientation as seen from the center."""
    fans = [(p[0], p[k], p[k + 1]) for p in polygons for k in range(1, len(p) - 1)]
    if not fans:
        return
    corners = np.array(fans)
    a, b, c = u[corners.T]
    turn = np.einsum("fi,fi->f", a, np.cross(b, c))
    # A thin polygon may be inverted by rounding alone.
    size = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    wrong = -turn * np.sign(np.sum(turn)) > 1e-3 * size
    if wrong.any():
        i = int(corners[int(np.argmax(wrong)), 0])
        raise FileError(
            f"{source}: the surface folds over at point {i}, {_triple(points[i])}: "
            f"it is not star-shaped about {_triple(center)}"
        )


def _triple(x: Floats) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in x) + ")"
