"""Edge unfolding of surfaces into sheets without overlap."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing.edge_choice import Edges, chosen_sides
from isoembed.gluing.faces import Faces, true_faces
from isoembed.gluing.net import Net, glue_rounded
from isoembed.gluing.sheet_faces import glued_faces
from isoembed.gluing.sheet_search import Objective, found_sheets
from isoembed.mesh.triangulation import frozen
from isoembed.metric.precision import Precision
from isoembed.reprs import counted

if TYPE_CHECKING:
    from isoembed.papercraft.material import Material


@dataclass(frozen=True, eq=False)
class Unfolding:
    """The surface of a solid cut into sheets of paper; created by `unfold`.

    Attributes
    ----------
    sheets : tuple of ndarray, shape (n, 2)
        Outline of each sheet, counterclockwise seen from outside, in the unit of the solid.
    corners : tuple of ndarray of int64, shape (n,)
        Surface vertex of each corner.
    sides : tuple of pairs
        Pairs of sides ``((p, k), (q, m))`` that were cut apart, in the form of `isoembed.glue`.
    folds : tuple of ndarray, shape (m, 2, 2)
        Endpoints of the folds of each sheet.
    angles : tuple of ndarray, shape (m,)
        Fold angles in radians, positive where the solid is convex.
    precision : Precision or None
        Precision of the coordinates of the solid, with the error of a length in their unit.
    faces : tuple of tuples of ndarray of int64
        Faces of each sheet, as corners of the sheet around each face, counterclockwise.
    numbers : tuple of ndarray of int64, shape (f,)
        Indices of these faces on the solid; flat faces are numbered by their first triangles.
    vertices : ndarray, shape (V, 3), or None
        Vertices of the solid.
    kept : frozenset of (int, int)
        Edges that must not be cut, as pairs of vertices in either order.
    any_surface : bool
        Whether the surface has a boundary, with unglued sides, or handles.
    """

    sheets: tuple[Floats, ...]
    corners: tuple[Indices, ...]
    sides: tuple[tuple[tuple[int, int], tuple[int, int]], ...]
    folds: tuple[Floats, ...]
    angles: tuple[Floats, ...]
    precision: Precision | None = None
    faces: tuple[tuple[Indices, ...], ...] = ()
    numbers: tuple[Indices, ...] = ()
    vertices: Floats | None = None
    kept: frozenset[tuple[int, int]] = frozenset()
    any_surface: bool = False

    def __repr__(self) -> str:
        return f"Unfolding({self})"

    def __str__(self) -> str:
        sheets, folds = counted(len(self.sheets), "sheet"), counted(sum(map(len, self.folds)), "fold")
        return f"{sheets}, {len(self.sides)} pairs of sides, {folds}"

    @cached_property
    def fold_corners(self) -> tuple[Indices, ...]:
        """Sheet corners at the endpoints of its `folds`, shape (m, 2)."""
        return tuple(map(_nearest, self.sheets, self.folds))

    @cached_property
    def net(self) -> Net:
        """The glued sheets: the metric of the solid.

        For a surface with boundary or handles, which its metric does not determine, the polygons are the
        faces, and the folded vertices are stored.
        """
        if not self.any_surface:
            return glue_rounded(self.sheets, self.sides, self.precision)
        sides = glued_faces(self.faces, self.sides, list(map(len, self.sheets)))
        points = [sheet[face] for sheet, faces in zip(self.sheets, self.faces, strict=True) for face in faces]
        net = glue_rounded(points, sides, self.precision, any_surface=True)
        if self.vertices is None:
            return net
        own = [
            corners[face] for corners, faces in zip(self.corners, self.faces, strict=True) for face in faces
        ]
        folded = np.empty((net.n_vertices, 3))
        folded[np.concatenate(net.corners)] = self.vertices[np.concatenate(own)]
        return net.knowing(folded=folded)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        paper: str = "A4",
        scale: float | None = None,
        size: float | tuple[str, float] | None = None,
        numbers: bool = False,
        material: Material | None = None,
    ) -> None:
        """Write the net on pages for printing and cutting, or for gluing again, depending on the file ending.

        Parameters
        ----------
        path : path
            ``.svg``, ``.pdf`` or ``.dxf`` for pages, as from `isoembed.papercraft.write_sheets`; ``.html``
            for a page with an animation of the folding beside the net; ``.json`` or ``.fold`` for the net
            alone, in the unit of the solid.  `isoembed.glue` reads all but ``.pdf`` and ``.html``.
        paper, scale, size, numbers
            Options of `isoembed.papercraft.write_sheets`: ``"A4"``, another format, ``"WIDTHxHEIGHT"`` or
            ``"roll:WIDTH"``; millimeters per unit of the solid, or its longest extent in millimeters, by
            default as large as fits; whether faces are numbered.
        material : isoembed.papercraft.Material, optional
            Material and tools for pages; by default paper with tabs.

        Raises
        ------
        FileError
            The ending is unknown, the file cannot be written, or matplotlib (for PDF) or ezdxf (for DXF) is
            not installed.
        InvalidMetric
            Faces or sides are so thin or small that the sheets cannot be glued in floating point.
        InvalidParameter
            The paper is unknown, a face does not fit on it, or an allowance or the kerf closes a notch.
        """
        # An upward import, listed in the contract like those of `isoembed.embedding.embedding`.
        from isoembed.papercraft.saving import save_unfolding

        save_unfolding(self, path, paper=paper, scale=scale, size=size, numbers=numbers, material=material)


def unfold(
    surface: Embedding,
    *,
    cut: Edges = (),
    keep: Edges = (),
    objective: Objective = "sheets",
    within: tuple[float, float] | None = None,
) -> Unfolding:
    """Cut a surface along edges and unfold it into the plane, in one sheet if such a net is found.

    For the fewest sheets, each vertex is cut along its steepest ascending edge, for random directions in
    turn, until the sheet does not overlap; for convex bodies one of the first few attempts succeeds.
    Otherwise, faces are joined as long as nothing overlaps, and sides that were rejected are tried first in
    the next attempt, as long as the number of sheets decreases.  The shortest cuts start from a minimum
    spanning tree of the vertices, changed in the same way until nothing overlaps.  Results are reproducible.

    Parameters
    ----------
    surface : Embedding
        Surface; only its vertices are used, not its metric.  Coplanar triangles form one face.
    cut, keep : sequence of (int, int), optional
        Edges, as pairs of vertices, that must and must not be cut.
    objective : {"sheets", "length", "strips", "faces"}, optional
        Fewest sheets; shortest total length of cuts; few sheets in which each face is joined to at most two
        others; or separate faces, except those joined by `keep`.
    within : (float, float), optional
        Width and height of a rectangle that contains each sheet of several faces, in some orientation, in the
        unit of the surface.

    Returns
    -------
    Unfolding

    Raises
    ------
    InvalidMetric
        A face is so thin that its plane is undefined, a side is shorter than rounding errors, or the surface
        is in hyperbolic or spherical space.
    InvalidParameter
        A pair is not an edge between two faces, an edge is both cut and kept, kept edges close a ring around
        a vertex, faces joined by them overlap or do not fit, or the objective or rectangle is invalid.

    References
    ----------
    Schlickenrieder, Nets of polyhedra, Technische Universitaet Berlin, 1997.

    Examples
    --------
    >>> import numpy as np
    >>> from isoembed import PolyhedralMetric, embed
    >>> tetrahedron = embed(PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.ones(6)))
    >>> unfold(tetrahedron)
    Unfolding(1 sheet, 3 pairs of sides, 3 folds)
    """
    if not surface.metric.space.is_euclidean:
        raise InvalidMetric(f"the surface is in {surface.metric.space.name} space: paper is flat")
    room = np.full(2, np.inf) if within is None else np.array(within, dtype=np.float64)
    if room.shape != (2,) or not (room > 0).all():
        raise InvalidParameter(f"within is {within!r}, not the width and height of a rectangle")
    unit = surface.metric.unit
    vertices = surface.vertices / unit
    mean_length = surface.metric.mean_length
    # Coordinates with fewer than three digits are exact, and so are their fold angles.
    precision = surface.metric.precision or Precision.of(surface.vertices, mean_length, 3)
    error = 0.0 if precision is None else precision.vertex_error * mean_length / unit
    faces = true_faces(surface.triangulation, vertices, error)
    steps = vertices[faces.ends] - vertices[faces.corners]
    lengths = np.linalg.norm(steps, axis=1)
    size = float(np.ldexp(1.0, int(np.frexp(lengths.sum())[1])))
    small = faces._replace(points=faces.points / size)
    points, after, sheets = found_sheets(
        small, steps, chosen_sides(faces, cut, keep), objective, room / unit / size
    )
    outer = np.flatnonzero(after >= 0)
    apart = np.abs(points[after[outer]] - points[outer]).max(axis=1) > 0
    if not apart.all():
        v = faces.corners[outer[np.argmin(apart)]]
        raise InvalidMetric(f"vertex {v} is too near to another to be distinguished on paper")
    return replace(
        _cut_out(faces, points * size * unit, after, sheets),
        precision=None if precision is None else precision.in_means(mean_length),
        vertices=surface.vertices,
        any_surface=not surface.triangulation.is_sphere,
        kept=frozenset((int(a), int(b)) for edge in keep for a, b in (edge, edge[::-1])),
    )


def _cut_out(faces: Faces, points: Floats, after: Indices, sheets: Indices) -> Unfolding:
    """Unfolding from the cuts: outlines, identified sides and folds."""
    outlines = []
    place: dict[int, tuple[int, int]] = {}
    every = np.unique(sheets).tolist()
    for p, sheet in enumerate(every):
        s = start = int(np.flatnonzero((sheets == sheet) & (after >= 0))[0])
        outline: list[int] = []
        while not outline or s != start:
            place[s] = p, len(outline)
            outline.append(s)
            s = int(after[s])
        outlines.append(outline)
    twins = faces.twins.tolist()
    sides = tuple((place[s], place[twins[s]]) for s in place if place[s] < place[twins[s]])
    ends = faces.following
    inside = (after < 0) & (np.arange(len(after)) < faces.twins) & (faces.angles != 0)
    folds = [np.flatnonzero(inside & (sheets == sheet)) for sheet in every]
    owners = sheets[faces.first[:-1]]
    numbers = [np.flatnonzero(owners == sheet) for sheet in every]
    following = ends.tolist()

    def corner(s: int) -> int:
        """Sheet corner at the start of a side, found by rotating about it to the next side on the outline."""
        while s not in place:
            s = following[twins[s]]
        return place[s][1]

    around = [
        tuple(
            frozen(np.array([corner(s) for s in range(faces.first[f], faces.first[f + 1])]))
            for f in some.tolist()
        )
        for some in numbers
    ]
    return Unfolding(
        tuple(frozen(points[outline]) for outline in outlines),
        tuple(frozen(faces.corners[outline]) for outline in outlines),
        sides,
        tuple(frozen(np.stack([points[some], points[ends[some]]], axis=1)) for some in folds),
        tuple(frozen(faces.angles[some]) for some in folds),
        faces=tuple(around),
        numbers=tuple(map(frozen, numbers)),
    )


def _nearest(sheet: Floats, folds: Floats) -> Indices:
    """Corners at the endpoints of the folds, shape (m, 2)."""
    size = np.ptp(sheet, axis=0).max()  # prevents underflow and overflow of squares
    apart = np.linalg.norm(folds[:, :, None] / size - sheet / size, axis=3)
    return np.argmin(apart, axis=2)
