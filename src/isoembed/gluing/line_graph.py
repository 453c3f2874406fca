"""Planar straight-line graph of a drawing: faces, and sheets as connected faces."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.gluing.drawn_lines import CUT, FOLD, Line
from isoembed.gluing.polygon import Side, consecutive, signed_area
from isoembed.mesh.merging import representatives


@dataclass(frozen=True, eq=False)
class LineGraph:
    """Faces enclosed by lines, counterclockwise.

    Attributes
    ----------
    points : ndarray, shape (V, 2)
    faces : list of list of int
        Vertices around each face.
    lines : dict
        Line that contains each side ``(f, k)``.
    twins : dict
        Opposite side of each side shared by two faces.
    loose : int
        Number of edges that enclose nothing.
    """

    points: Floats
    faces: list[list[int]]
    lines: dict[Side, Line]
    twins: dict[Side, Side]
    loose: int

    def ends(self, side: Side) -> Floats:
        """Endpoints of a side, (2, 2)."""
        f, k = side
        return self.points[[self.faces[f][k], self.faces[f][(k + 1) % len(self.faces[f])]]]

    def folds(self, f: int) -> list[Side]:
        """Sides of a face across which the sheet continues."""
        return [(f, k) for k in range(len(self.faces[f])) if (f, k) in self.twins]

    def without(self, left_out: Collection[int]) -> LineGraph:
        """Graph without some faces; sides shared with them become part of the outline."""
        remaining = [f for f in range(len(self.faces)) if f not in left_out]
        place = {f: k for k, f in enumerate(remaining)}
        lines = {(place[f], k): line for (f, k), line in self.lines.items() if f in place}
        twins = {
            (place[f], k): (place[g], m) for (f, k), (g, m) in self.twins.items() if f in place and g in place
        }
        return LineGraph(self.points, [self.faces[f] for f in remaining], lines, twins, self.loose)

    @classmethod
    def of(cls, lines: Sequence[Line], near: float) -> LineGraph:
        """Graph of the faces enclosed by lines.

        Duplicate lines are merged, and lines that enclose nothing are ignored.

        Parameters
        ----------
        lines : sequence of Line
        near : float
            Distance within which points are merged.

        Raises
        ------
        InvalidMetric
            Lines cross, a fold ends inside a sheet, or an outline is inside another.
        """
        points, every = _edges(lines, near)
        edges = _without_ends(points, every)
        around: dict[int, list[int]] = {}
        for a, b in edges:
            around.setdefault(a, []).append(b)
            around.setdefault(b, []).append(a)
        for a, others in around.items():
            others.sort(key=lambda b: float(np.arctan2(*(points[b] - points[a])[::-1])))
        following = {(b, a): (a, others[k - 1]) for a, others in around.items() for k, b in enumerate(others)}
        faces: list[list[int]] = []
        outer: list[list[int]] = []
        left = dict.fromkeys(following)
        while left:
            step = first = next(iter(left))
            face: list[int] = []
            while not face or step != first:
                del left[step]
                face.append(step[0])
                step = following[step]
            (faces if signed_area(points[face]) > 0 else outer).append(face)
        _check_apart(points, faces, outer)
        place = {ends: (f, k) for f, face in enumerate(faces) for k, ends in enumerate(consecutive(face))}
        on = {side: edges[min(ends), max(ends)] for ends, side in place.items()}
        twins = {
            side: place[b, a] for (a, b), side in place.items() if (b, a) in place and on[side].purpose != CUT
        }
        return cls(points, faces, on, twins, len(every) - len(edges))


def _edges(lines: Sequence[Line], near: float) -> tuple[Floats, dict[Side, Line]]:
    """Vertices, and the line on each edge between two of them."""
    every = np.concatenate([line.points for line in lines])
    size = float(np.ptp(every, axis=0).max()) or 1.0
    names, number = np.unique(
        representatives((every - every.min(axis=0)) / size, near / size), return_inverse=True
    )
    points = every[names]
    number = number.ravel()
    edges: dict[Side, Line] = {}
    by_x = np.argsort(points[:, 0], kind="stable")
    x = points[by_x, 0]
    first = 0
    for line in lines:
        way = number[first : first + len(line.points)]
        first += len(way)
        for a, b in pairwise(way.tolist()):
            if a == b:
                continue
            step = points[b] - points[a]
            length = float(np.hypot(*step))
            low, high = sorted([points[a, 0], points[b, 0]])
            some = by_x[np.searchsorted(x, low - near) : np.searchsorted(x, high + near, side="right")]
            some = some[(some != a) & (some != b)]  # rounding may place b before itself
            away = points[some] - points[a]
            along = away @ step / length
            off = np.abs(away[:, 0] * step[1] - away[:, 1] * step[0])
            inside = np.flatnonzero((off <= near * length) & (along > near) & (length - along > near))
            stops = [a, *some[inside[np.argsort(along[inside])]].tolist(), b]
            for u, v in pairwise(stops):
                earlier = edges.get((min(u, v), max(u, v)))
                if earlier is None or line.purpose == CUT:
                    edges[min(u, v), max(u, v)] = line
    _check_crossings(points, np.array([*edges], dtype=np.int64).reshape(-1, 2))
    return points, edges


def _check_crossings(points: Floats, edges: np.ndarray) -> None:
    starts, ends = points[edges[:, 0]], points[edges[:, 1]]

    def turns(a: Floats, b: Floats, c: Floats) -> Floats:
        u, v = b - a, c - a
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    # Sweep from left to right: a later edge that crosses an edge starts before that edge ends.
    left, right = np.minimum(starts[:, 0], ends[:, 0]), np.maximum(starts[:, 0], ends[:, 0])
    order = np.argsort(left, kind="stable")
    until = np.searchsorted(left[order], right[order], side="right")
    for k, e in enumerate(order.tolist()):
        others = order[k + 1 : until[k]]
        a, b = edges[e]
        apart = (edges[others] != a).all(axis=1) & (edges[others] != b).all(axis=1)
        others = others[apart]
        u, v = starts[others], ends[others]
        crossing = turns(points[a], points[b], u) * turns(points[a], points[b], v) < 0
        crossing &= turns(u, v, points[a]) * turns(u, v, points[b]) < 0
        if crossing.any():
            one, other = edges[sorted((e, int(others[np.argmax(crossing)])))]
            raise InvalidMetric(f"the lines {_formatted(points[one])} and {_formatted(points[other])} cross")


def _without_ends(points: Floats, edges: dict[Side, Line]) -> dict[Side, Line]:
    """Edges that bound a face; those with a loose end are removed one by one."""
    around: dict[int, set[Side]] = {}
    for edge in edges:
        for v in edge:
            around.setdefault(v, set()).add(edge)
    loose = [v for v, some in around.items() if len(some) == 1]
    removed = []
    while loose:
        v = loose.pop()
        if not around[v]:
            continue
        (edge,) = around[v]
        removed.append(edge)
        for u in edge:
            around[u].discard(edge)
            if len(around[u]) == 1:
                loose.append(u)
    for edge in removed:
        if edges[edge].purpose == FOLD and any(around[v] for v in edge):
            raise InvalidMetric(f"the fold {_formatted(points[[*edge]])} ends inside a sheet")
    return {edge: line for edge, line in edges.items() if edge in around[edge[0]]}


def _check_apart(points: Floats, faces: list[list[int]], outer: list[list[int]]) -> None:
    """Raise an error if an outline is inside a face."""
    firsts = points[[other[0] for other in outer]]
    for face in faces:
        corners = points[face]
        own = set(face)
        within = ((firsts > corners.min(axis=0)) & (firsts < corners.max(axis=0))).all(axis=1)
        for k in np.flatnonzero(within).tolist():
            v = firsts[k]
            if own.isdisjoint(outer[k]) and is_inside(v, corners):
                raise InvalidMetric(
                    f"an outline lies inside another, at {_at(v)}: sheets with holes cannot be glued, "
                    "and frames must be removed"
                )


def is_inside(point: Floats, corners: Floats) -> bool:
    """Whether a point is inside a polygon: a ray from it crosses the boundary an odd number of times."""
    a, b = corners - point, np.roll(corners, -1, axis=0) - point
    across = (a[:, 1] > 0) != (b[:, 1] > 0)
    a, b = a[across], b[across]
    return bool(((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0) == (b[:, 1] > a[:, 1])).sum() % 2)


def _at(point: Floats) -> str:
    return f"[{point[0]:.6g}, {point[1]:.6g}]"


def _formatted(ends: Floats) -> str:
    return f"from {_at(ends[0])} to {_at(ends[1])}"
