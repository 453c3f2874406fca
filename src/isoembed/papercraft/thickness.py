"""Nets of thick sheets: bend allowance and setback of folds, clearance of edges of adjacent faces.

A fold by the angle A of a sheet of thickness T, with inside radius R, preserves length at the depth K T from
the inside, so that the bend takes the length BA = A (R + K T) of the flat sheet.  The setback SB of its
tangent lines from the edge of the solid is (R + T) tan(A/2) if the faces of the solid are the outer surface
of the bend, and R tan(A/2) if they are the inner surface.  Each face is thus shortened by SB - BA/2 relative
to the solid, up to the middle of the bend (Boljanovic, Sheet Metal Forming Processes and Die Design, 2004).

Two faces that were cut apart are shortened by T tan(A/2) if they would otherwise intersect: with square
edges, they touch along the edges of their inner surfaces.

If the faces around a corner do not end in a common point, a round relief is cut out there.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.gluing.offset import moved_sides
from isoembed.gluing.polygon import consecutive, interior_angles, meeting_sides
from isoembed.papercraft.material import Material

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding

Corner = tuple[int, int]
"""A face of a sheet and a corner of that face, which is the start of the side with the same number."""


def shortening(angle: float, material: Material, is_fold: bool) -> float:
    """Shortening of a face at a side relative to the solid, in mm.

    Parameters
    ----------
    angle : float
        Exterior dihedral angle in radians, positive where the solid is convex.
    material : Material
    is_fold : bool
        Whether the sheet is folded at the side, or cut.
    """
    bend = abs(angle)
    half = np.tan(bend / 2)
    is_outer = (angle > 0) == (material.surface == "outside")  # faces of the solid on the outside of the bend
    if not is_fold:
        return float(material.thickness * half) if is_outer else 0.0
    setback = (material.radius + material.thickness * is_outer) * half
    return float(setback - bend * (material.radius + material.k_factor * material.thickness) / 2)


def thickened(unfolding: Unfolding, material: Material, scale: float) -> Unfolding:
    """Net for folding a thick sheet to a solid.

    Each face is shortened at its sides, and the faces of a sheet are moved together so that shortened sides
    meet in the middle of the bend, which is the fold.

    Parameters
    ----------
    unfolding : Unfolding
    material : Material
    scale : float
        Millimeters per unit of the sheets.

    Returns
    -------
    Unfolding
        Net without `faces`: the outline has steps at folds whose sides were shortened differently, and sides
        that were cut apart may have different lengths.

    Raises
    ------
    InvalidParameter
        Faces or vertices are unknown, or a face vanishes.
    """
    if unfolding.vertices is None or not unfolding.faces:
        raise InvalidParameter(
            "a thickness requires the faces and vertices of the solid, which this net does not have"
        )
    places: dict[Corner, Corner] = {}
    normals = _normals(unfolding)
    owner = {
        (p, a): (p, f)
        for p, faces in enumerate(unfolding.faces)
        for f, face in enumerate(faces)
        for a, b in consecutive(face)
        if (a + 1) % len(unfolding.sheets[p]) == b
    }
    mates = {side: owner[mate] for pair in unfolding.sides for side, mate in (pair, pair[::-1])}
    sheets: list[Floats] = []
    corners, folds, angles = [], [], []
    for p, (sheet, faces) in enumerate(zip(unfolding.sheets, unfolding.faces, strict=True)):
        shape = _Sheet(sheet, faces)
        bends = {}
        for (f, k), (a, b) in shape.ends.items():
            twin = shape.twins.get((f, k))
            other = mates.get((p, a)) if twin is None else (p, twin[0])
            if other is None:  # boundary side
                bends[f, k] = 0.0
                continue
            vertices = unfolding.vertices[unfolding.corners[p][[a, b]]]
            bends[f, k] = _bend(normals[p, f], normals[other], vertices)
        distances = {at: -shortening(bend, material, at in shape.twins) / scale for at, bend in bends.items()}
        outline, begins, creases = shape.shortened(distances, unfolding.numbers[p])
        i, _ = meeting_sides((outline - outline.min(axis=0)) / float(np.ptp(outline, axis=0).max()))
        if i >= 0:
            raise InvalidParameter(
                f"sheet {p} would overlap itself, because the faces of a sheet of "
                f"{material.thickness:g} mm move together at folds: use more sheets, a larger scale or "
                "a thinner sheet"
            )
        number = len(sheets)
        places |= {(p, a): (number, k) for a, k in begins.items()}
        sheets.append(outline)
        corners.append(np.zeros(len(outline), dtype=np.int64))
        folds.append(np.array([line for _, line in creases]).reshape(-1, 2, 2))
        angles.append(np.array([bends[at] for at, _ in creases]))
    sides = tuple((places[one], places[other]) for one, other in unfolding.sides)
    return replace(
        unfolding,
        sheets=tuple(sheets),
        corners=tuple(corners),
        sides=sides,
        folds=tuple(folds),
        angles=tuple(angles),
        faces=(),
        numbers=(),
        vertices=None,
    )


class _Sheet:
    """Faces of a sheet, and the sides between them."""

    def __init__(self, sheet: Floats, faces: tuple[Indices, ...]) -> None:
        self.faces = [sheet[face] for face in faces]
        self.size = float(np.ptp(sheet, axis=0).max())
        self.ends = {(f, k): ends for f, face in enumerate(faces) for k, ends in enumerate(consecutive(face))}
        place = {ends: at for at, ends in self.ends.items()}
        self.twins = {at: place[b, a] for at, (a, b) in self.ends.items() if (b, a) in place}

    def shortened(
        self, distances: dict[Corner, float], numbers: Indices
    ) -> tuple[Floats, dict[int, int], list[tuple[Corner, Floats]]]:
        """Outline, start corner in it of each side of the sheet, and folds."""
        segments = []
        for f, face in enumerate(self.faces):
            try:
                segments.append(moved_sides(face, [distances[f, k] for k in range(len(face))], "it"))
            except InvalidParameter:
                raise InvalidParameter(
                    f"face {numbers[f]} is too small for this thickness: use a larger scale"
                ) from None
        shifts = self._shifts(distances)
        rings = [points + shift for (points, _, _), shift in zip(segments, shifts, strict=True)]

        def side(at: Corner) -> Floats:
            f, k = at
            _, first, last = segments[f]
            return np.asarray(rings[f][[first[k], last[k]]])

        outline: list[Floats] = []
        begins: dict[int, int] = {}
        reliefs: dict[Corner, tuple[Floats, float]] = {}
        at = next(at for at in self.ends if at not in self.twins)
        while self.ends[at][0] not in begins:
            begins[self.ends[at][0]] = len(outline)
            before, around, crossed = at, [side(at)[1]], []
            at = self._next(at)
            while at in self.twins:
                crossed.append(at)
                around.append(side(at)[0])
                at = self.twins[at]
                around.append(side(at)[1])
                at = self._next(at)
            around.append(side(at)[0])
            middle = np.mean(around, axis=0)
            radius = 1.1 * float(np.hypot(*(around - middle).T).max())
            if radius <= 1e-9 * self.size:  # the corners coincide
                outline.append(middle)
            else:
                reliefs |= dict.fromkeys(crossed, (middle, radius))
                turn = self._angle(crossed, before)
                outline += _relief(side(before)[::-1], side(at), middle, radius, turn)
        # Each side starts at the end of the preceding relief.
        corners = [*begins]
        begins = {corner: (begins[corner] - 1) % len(outline) for corner in corners}
        creases = []
        for one, other in self.twins.items():
            if one < other:
                line, opposite = side(one), side(other)[::-1]
                size = float(np.hypot(*(line[1] - line[0])))
                along = (line[1] - line[0]) / size
                low, high = (float((point - line[0]) @ along) for point in opposite)
                low, high = max(0.0, low), min(size, high)
                for twin, sign in ((one, 1), (other, -1)):
                    if twin in reliefs:
                        middle, radius = reliefs[twin]
                        reached = float((middle - line[0]) @ along) + sign * radius
                        low, high = (max(low, reached), high) if sign > 0 else (low, min(high, reached))
                if low >= high:
                    f, g = (numbers[some[0]] for some in (one, other))
                    raise InvalidParameter(f"faces {f} and {g} are too thick for a common fold")
                creases.append((one, line[0] + np.array([[low], [high]]) * along))
        return np.array(outline), begins, creases

    def _angle(self, crossed: list[Corner], before: Corner) -> float:
        """Angle of the sheet at the end corner of a side, from which the given folds start."""
        total = 0.0
        for f, k in [before, *(self.twins[at] for at in crossed)]:
            face = self.faces[f]
            here = face[(k + 1) % len(face)]
            total += float(interior_angles(face[(k + 2) % len(face)] - here, face[k] - here))
        return total

    def _next(self, at: Corner) -> Corner:
        f, k = at
        return f, (k + 1) % len(self.faces[f])

    def _shifts(self, distances: dict[Corner, float]) -> list[Floats]:
        """Displacement of each face toward the first, across the folds between them."""
        shifts: dict[int, Floats] = {0: np.zeros(2)}
        waiting = [0]
        while waiting:
            f = waiting.pop()
            face = self.faces[f]
            for k in range(len(face)):
                g = self.twins.get((f, k), (f, k))[0]
                if g not in shifts:
                    x, y = face[(k + 1) % len(face)] - face[k]
                    out = np.array([y, -x]) / np.hypot(x, y)
                    both = distances[f, k] + distances[self.twins[f, k]]
                    shifts[g] = shifts[f] + both * out
                    waiting.append(g)
        return [shifts[f] for f in range(len(self.faces))]


def _relief(before: Floats, after: Floats, middle: Floats, radius: float, angle: float) -> list[Floats]:
    """Points of a relief around a corner, from the side that ends there to the one that starts there.

    Parameters
    ----------
    before, after : ndarray, shape (2, 2)
        Endpoints of the two sides, starting at the corner.
    middle, radius
        Center and radius of the relief.
    angle : float
        Angle of the sheet at the corner.
    """
    ends = []
    for near, far in (before, after):
        step = (far - near) / np.hypot(*(far - near))
        along = (middle - near) @ step
        off = np.abs((middle - near) @ [-step[1], step[0]])
        ends.append(near + (along + np.sqrt(max(0.0, radius**2 - off**2))) * step)
    (x, y), (u, v) = ends[0] - middle, ends[1] - middle
    # Clockwise through the sheet by approximately its angle, modulo full turns.
    sweep = np.arctan2(x * v - y * u, x * u + y * v)
    sweep += 2 * np.pi * np.rint((-angle - sweep) / (2 * np.pi))
    n = max(1, int(np.ceil(abs(sweep) / (np.pi / 6))))
    turns = np.arctan2(y, x) + sweep * np.arange(1, n) / n
    arc = middle + radius * np.column_stack([np.cos(turns), np.sin(turns)])
    return [ends[0], *arc, ends[1]]


def _normals(unfolding: Unfolding) -> dict[Corner, Floats]:
    """Normal of each face of each sheet, by Newell's formula."""
    assert unfolding.vertices is not None
    found = {}
    size = float(np.ptp(unfolding.vertices, axis=0).max())
    for p, faces in enumerate(unfolding.faces):
        for f, face in enumerate(faces):
            points = unfolding.vertices[unfolding.corners[p][face]] / size
            points = points - points[0]
            normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
            found[p, f] = normal / np.linalg.norm(normal)
    return found


def _bend(normal: Floats, other: Floats, ends: Floats) -> float:
    """Exterior dihedral angle at a side with given endpoints, between faces with the given normals."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return float(np.arctan2(np.cross(normal, other) @ along, normal @ other))
