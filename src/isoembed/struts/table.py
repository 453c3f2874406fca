"""Strut tables: types of struts, hubs and faces of a dome or a frame, with lengths and angles."""

from __future__ import annotations

import math
import numbers
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.mesh.triangulation import frozen
from isoembed.reprs import counted
from isoembed.struts import saving
from isoembed.struts.cut_list import CutList
from isoembed.struts.frame import Frame
from isoembed.struts.hubs import HubType, hub_angles, hub_types, sphere_through
from isoembed.struts.types import first_reading, length_types, letters
from isoembed.surface.surface import Surface


@dataclass(frozen=True)
class StrutType:
    """Struts of equal length.

    Attributes
    ----------
    name : str
        ``"A"`` for the shortest, ``"B"``, ...
    count : int
    length : float
        Length between hub centers: mean of the shortest and longest.
    cut_length : float
        Length minus the radii of the hubs at both ends.
    spread : float
        Difference of the longest and shortest lengths.
    chord_factor, central_angle : float or None
        If the hubs lie on a sphere: length divided by radius, and the angle in degrees subtended by a strut
        at the center.
    """

    name: str
    count: int
    length: float
    cut_length: float
    spread: float
    chord_factor: float | None = None
    central_angle: float | None = None


@dataclass(frozen=True)
class FaceType:
    """Faces with the same strut types around them, in either direction.

    Attributes
    ----------
    struts : tuple of str
    count : int
    """

    struts: tuple[str, ...]
    count: int


@dataclass(frozen=True, eq=False)
class StrutTable:
    """Struts, hubs and faces of a surface by type; created by `strut_table`.

    Lengths are in the unit of the surface, angles in degrees.

    Attributes
    ----------
    struts : tuple of StrutType
    hubs : tuple of HubType
    faces : tuple of FaceType
    edges : ndarray of int64, shape (n, 2)
        Hubs joined by each strut, as vertex indices.
    lengths : ndarray, shape (n,)
    types : ndarray of int64, shape (n,)
        Index of each strut's type in `struts`.
    dihedral_angles : ndarray, shape (n,)
        Angles between adjacent faces, 180 if flat and less if convex; NaN on a boundary.
    bends : ndarray, shape (n, 2)
        Angles of each strut to the tangent planes at its two hubs, as in `HubType`.
    hub_types : ndarray of int64, shape (V,)
        Index of each vertex's type in `hubs`; -1 if it has no struts.
    tolerance : float
        Largest difference of lengths of one type.
    radius : float or None
        Radius of the sphere that contains the hubs.
    hub_radius : float
        Length by which struts are shortened at each end.
    cuts : CutList or None
        Cutting of the struts from bars.
    """

    struts: tuple[StrutType, ...]
    hubs: tuple[HubType, ...]
    faces: tuple[FaceType, ...]
    edges: Indices
    lengths: Floats
    types: Indices
    dihedral_angles: Floats
    bends: Floats
    hub_types: Indices
    tolerance: float
    radius: float | None = None
    hub_radius: float = 0.0
    cuts: CutList | None = None

    def __repr__(self) -> str:
        return f"StrutTable({self.summary})"

    @property
    def summary(self) -> str:
        """Numbers of struts, hubs and faces, in one line."""
        on = "" if self.radius is None else f"; on a sphere of radius {self.radius:.6g}"
        parts = (
            f"{counted(sum(each.count for each in types), name)} of {counted(len(types), 'type')}"
            for name, types in (("strut", self.struts), ("hub", self.hubs), ("face", self.faces))
        )
        return ", ".join(parts) + on

    def __str__(self) -> str:
        return saving.text(self)

    @property
    def report(self) -> dict[str, Any]:
        """Contents of the table for JSON files."""
        return saving.report(self)

    def to_csv(self) -> str:
        """Table as comma-separated values.

        Tables with headers are separated by blank lines: types of struts, hubs and faces, bars, all struts
        with their hubs, and all hubs with their types.  `isoembed.embed` and ``isoembed embed`` read such a
        file.
        """
        return saving.csv_text(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table as ``.csv`` or ``.json``, depending on the file ending.

        Raises
        ------
        FileError
            The ending is unknown, or the file cannot be written.
        """
        saving.save(self, path)


def strut_table(
    surface: Embedding | Surface,
    *,
    tolerance: float | None = None,
    hub_radius: float = 0.0,
    stock: float | None = None,
) -> StrutTable:
    """Tabulate the struts of a dome or a frame: the edges of a surface, with its vertices as hubs.

    Edges between coplanar triangles are diagonals of a face, not struts.  The tangent plane of a hub is that
    of the sphere if all hubs lie on one; otherwise it is perpendicular to the angle-weighted mean of the
    adjacent normals.

    Parameters
    ----------
    surface : Embedding or Surface
        Surface in R^3, closed or with boundary, as from `isoembed.embed` or `isoembed.io.read_surface`.
    tolerance : float, optional
        Largest difference of lengths of one type, in the unit of the surface, and largest distance of hubs
        from a sphere.  By default a millionth of the mean length, or more if the coordinates are rounded.
    hub_radius : float
        Length by which struts are shortened at each end.
    stock : float, optional
        Length of the bars from which the struts are cut; the table then contains a cut list.

    Returns
    -------
    StrutTable

    Raises
    ------
    InvalidMetric
        The surface is in hyperbolic or spherical space.
    InvalidParameter
        The tolerance or radius is not a nonnegative length, or a strut is not longer than two hub radii, or
        longer than the stock.

    Examples
    --------
    >>> from isoembed import PolyhedralMetric, embed
    >>> pyramid = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    >>> strut_table(embed(PolyhedralMetric(pyramid, [1.0] * 8), boundary="plane"))
    StrutTable(8 struts of 1 type, 5 hubs of 2 types, 4 faces of 1 type; on a sphere of radius 0.707107)
    """
    surface = surface.surface if isinstance(surface, Embedding) else surface
    if not surface.space.is_euclidean:
        raise InvalidMetric(f"the surface is in {surface.space.name} space: strut tables require R^3")
    for name, value in (("tolerance", tolerance), ("hub_radius", hub_radius), ("stock", stock)):
        if value is not None and not (isinstance(value, numbers.Real) and 0 <= value < math.inf):
            raise InvalidParameter(f"{name} is {value!r}, not a non-negative length")
    frame, unit = Frame.of(surface), surface.unit
    which = np.flatnonzero(frame.is_strut)
    edges, lengths = surface.edges[which], surface._lengths[which]
    mean = float(lengths.mean())
    allowed = (
        # Equal lengths differ by less than a millionth in files with seven digits.
        max(1e-6 * mean, 4 * surface._vertex_error) if tolerance is None else float(tolerance) / unit
    )
    types = length_types(lengths, allowed)
    sphere = sphere_through(frame.vertices[np.unique(edges)], allowed)
    radius = None if sphere is None else sphere[1]
    struts = _strut_types(lengths * unit, types, float(hub_radius), None if radius is None else radius * unit)
    number = np.full(len(surface.edges), -1)
    number[which] = np.arange(len(which))
    around = [number[some] for some in frame.hubs()]
    bends, angles = hub_angles(frame, edges, around, None if sphere is None else sphere[0])
    of_vertices, hubs = hub_types(around, edges, types, bends, angles, frame.triangulation.boundary_vertices)
    dihedral = np.where(surface.triangulation.boundary_edges, np.nan, np.pi - surface.dihedral_angles)
    cuts = None
    if stock is not None:
        cuts = CutList.of([(one.name, one.cut_length, one.count) for one in struts], float(stock))
    return StrutTable(
        struts,
        hubs,
        _face_types(frame, number, types),
        frozen(edges.copy()),
        frozen(lengths * unit),
        frozen(types),
        frozen(np.degrees(dihedral[which])),
        frozen(bends),
        frozen(of_vertices),
        allowed * unit,
        None if radius is None else radius * unit,
        float(hub_radius),
        cuts,
    )


def _strut_types(
    lengths: Floats, types: Indices, hub_radius: float, radius: float | None
) -> tuple[StrutType, ...]:
    found = []
    for k in range(int(types.max()) + 1):
        mine = lengths[types == k]
        length = float(mine.min() + mine.max()) / 2
        cut = length - 2 * hub_radius
        if cut <= 0:
            raise InvalidParameter(
                f"hubs of radius {hub_radius:.6g} overlap: struts of type {letters(k)} are {length:.6g} long"
            )
        sphere: dict[str, float] = {}
        if radius is not None:
            factor = length / radius
            sphere["chord_factor"] = factor
            sphere["central_angle"] = math.degrees(2 * math.asin(min(factor / 2, 1.0)))
        found.append(StrutType(letters(k), len(mine), length, cut, float(np.ptp(mine)), **sphere))
    return tuple(found)


def _face_types(frame: Frame, number: Indices, types: Indices) -> tuple[FaceType, ...]:
    counts: dict[tuple[int, ...], int] = {}
    for outline in frame.outlines():
        key = first_reading(types[number[outline]])
        counts[key] = counts.get(key, 0) + 1
    order = sorted(counts, key=lambda key: (len(key), key))
    return tuple(FaceType(tuple(map(letters, key)), counts[key]) for key in order)
