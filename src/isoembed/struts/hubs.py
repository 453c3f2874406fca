"""Hubs of a frame: their sphere, angles between struts within and to the tangent plane, and types of hubs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.struts.frame import Frame
from isoembed.struts.types import first_reading, letters, readings


@dataclass(frozen=True)
class HubType:
    """Hubs at which struts of the same types meet at the same angles, or at mirrored ones.

    Attributes
    ----------
    name : str
        Number of struts, followed by a letter if there are several types with this number.
    count : int
    struts : tuple of str
        Types of the struts in order around the hub; at a boundary from one end to the other.
    angles : tuple of float
        Angles between consecutive struts, projected onto the tangent plane, in degrees.
    bends : tuple of float
        Angle of each strut to the tangent plane, in degrees, positive if it points inward, below the plane.
    is_on_boundary : bool
    """

    name: str
    count: int
    struts: tuple[str, ...]
    angles: tuple[float, ...]
    bends: tuple[float, ...]
    is_on_boundary: bool

    @property
    def strut_angles(self) -> tuple[float, ...]:
        """Angles between consecutive struts in space, in degrees, as for holes drilled into a ball."""
        leans = np.radians(self.bends)
        after = np.roll(leans, -1)[: len(self.angles)]
        leans = leans[: len(self.angles)]
        cosines = np.sin(leans) * np.sin(after) + np.cos(leans) * np.cos(after) * np.cos(
            np.radians(self.angles)
        )
        return tuple(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).tolist())


def sphere_through(points: Floats, tolerance: float) -> tuple[Floats, float] | None:
    """Center and radius of a sphere that contains points within a tolerance; None if there is none.

    The center is the linear least-squares solution of |x|^2 = 2 c . x + r^2 - |c|^2, about the mean.
    """
    mean = points.mean(axis=0)
    x = points - mean
    solution, _, rank, _ = np.linalg.lstsq(
        np.column_stack([2 * x, np.ones(len(x))]), (x * x).sum(axis=1), rcond=1e-9
    )
    if rank < 4:  # coplanar points
        return None
    center = solution[:3]
    distances = np.linalg.norm(x - center, axis=1)
    radius = float(distances.mean())
    if np.abs(distances - radius).max() > tolerance:
        return None
    return center + mean, radius


def hub_angles(
    frame: Frame, edges: Indices, around: Sequence[Indices], center: Floats | None
) -> tuple[Floats, list[Floats]]:
    """Bends (n, 2) of struts at both ends, and angles between consecutive struts at each hub, in degrees.

    Parameters
    ----------
    frame : Frame
    edges : ndarray of int, shape (n, 2)
        End vertices of the struts.
    around : sequence of ndarray of int
        Struts at each vertex, counterclockwise.
    center : ndarray, shape (3,), optional
        Center of the sphere that contains the hubs, if any.
    """
    x, normals = frame.vertices, frame.normals()
    if center is not None:
        hubs = np.unique(edges)
        radial = (x[hubs] - center) / np.linalg.norm(x[hubs] - center, axis=1, keepdims=True)
        # The outside of a surface with boundary is a convention.
        normals[hubs] = radial if (radial * normals[hubs]).sum() >= 0 else -radial
    bends = np.empty((len(edges), 2))
    between = []
    for v, struts in enumerate(around):
        ends = edges[struts]
        at_end = (ends[:, 1] == v).astype(np.int64)
        arms = x[ends.sum(axis=1) - v] - x[v]
        arms /= np.linalg.norm(arms, axis=1, keepdims=True)
        up = arms @ normals[v]
        bends[struts, at_end] = -np.degrees(np.arcsin(np.clip(up, -1.0, 1.0)))
        flat = arms - up[:, None] * normals[v]
        after = np.roll(flat, -1, axis=0)
        turned = np.degrees(np.arctan2(np.cross(flat, after) @ normals[v], (flat * after).sum(axis=1)))
        between.append(turned % 360.0)
    return bends, between


def hub_types(
    around: Sequence[Indices],
    edges: Indices,
    types: Indices,
    bends: Floats,
    angles: Sequence[Floats],
    on_boundary: Mask,
) -> tuple[Indices, tuple[HubType, ...]]:
    """Hub type of each vertex, -1 if it has no struts, and the types ordered by number of struts."""
    kinds: list[HubType] = []
    members: list[list[int]] = []
    alike: dict[tuple[bool, tuple[int, ...]], list[int]] = {}
    for v, struts in enumerate(around):
        if not struts.size:
            continue
        closed = not on_boundary[v]
        here, bent = types[struts], bends[struts, (edges[struts, 1] == v).astype(np.int64)]
        key = closed, first_reading(here, closed)
        ways = [
            (angles[v][gaps], bent[order])
            for order, gaps in readings(len(struts), closed)
            if tuple(here[order].tolist()) == key[1]
        ]
        same = alike.setdefault(key, [])
        found = next((k for k in same if any(_is_like(kinds[k], *way) for way in ways)), len(kinds))
        if found == len(kinds):
            turns, leans = (tuple(some.tolist()) for some in ways[0])
            kinds.append(HubType("", 0, tuple(map(letters, key[1])), turns, leans, not closed))
            members.append([])
            same.append(found)
        members[found].append(v)
    order = sorted(range(len(kinds)), key=lambda k: (len(kinds[k].struts), kinds[k].is_on_boundary, k))
    valences = [len(kinds[k].struts) for k in order]
    found_types, hubs = np.full(len(around), -1), []
    for place, (k, n) in enumerate(zip(order, valences, strict=True)):
        found_types[members[k]] = place
        letter = letters(place - valences.index(n)).lower() if valences.count(n) > 1 else ""
        hubs.append(replace(kinds[k], name=f"{n}{letter}", count=len(members[k])))
    return found_types, tuple(hubs)


def _is_like(kind: HubType, angles: Floats, bends: Floats) -> bool:
    off = np.concatenate([angles - kind.angles, bends - kind.bends])
    return bool(np.abs(off).max(initial=0.0) <= 0.1)  # degrees: beyond manufacturing accuracy
