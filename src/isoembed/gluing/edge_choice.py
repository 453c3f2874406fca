"""Constraints of edge unfoldings: edges that must or must not be cut."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral
from typing import Any

import numpy as np

from isoembed.arrays import Indices, Mask
from isoembed.errors import InvalidParameter
from isoembed.gluing.faces import Faces

Edges = Sequence[tuple[int, int]]
"""Pairs of vertex indices."""


def chosen_sides(faces: Faces, cut: Edges, keep: Edges) -> tuple[Mask, Indices]:
    """Mark the edges to be cut and those to be kept.

    Parameters
    ----------
    faces : Faces
    cut, keep : sequence of (int, int)
        Edges by their endpoints.

    Returns
    -------
    cut : ndarray of bool, shape (S,)
        Both sides of each edge to be cut.
    keep : ndarray of int
        First side of each edge to be kept, without repetitions.

    Raises
    ------
    InvalidParameter
        A pair is not an edge between two faces, an edge is in both lists, or kept edges close a ring of
        faces, as around a vertex, which cannot lie flat.
    """
    glued = np.flatnonzero(faces.twins != np.arange(len(faces.twins)))
    pairs = zip(faces.corners[glued].tolist(), faces.ends[glued].tolist(), strict=True)
    number = dict(zip(pairs, glued.tolist(), strict=True))
    twins = faces.twins.tolist()
    found: dict[str, list[int]] = {"cut": [], "keep": []}
    for name, edges in (("cut", cut), ("keep", keep)):
        for k, edge in enumerate(edges):
            s = number.get(_pair(edge, f"{name}[{k}]"))
            if s is None:
                a, b = edge
                vertex = next((v for v in edge if v in faces.corners), None)
                others = ", ".join(str(end) for start, end in sorted(number) if start == vertex)
                raise InvalidParameter(
                    f"{name}[{k}] ({a}, {b}) is not an edge between two faces that meet at an angle"
                    + (f"; those of vertex {vertex} lead to {others}" if others else "")
                )
            found[name].append(min(s, twins[s]))
    is_cut = np.zeros(len(twins), dtype=np.bool_)
    is_cut[found["cut"]] = True
    is_cut |= is_cut[faces.twins]
    kept_edges = list(dict.fromkeys(found["keep"]))
    for k, s in enumerate(found["keep"]):
        if is_cut[s]:
            a, b = keep[k]
            raise InvalidParameter(f"keep[{k}] ({a}, {b}) is in cut, too")
    if len(forest(faces, np.array(kept_edges, dtype=np.int64))) < len(kept_edges):
        raise InvalidParameter(_around(faces, found["keep"], keep))
    return is_cut, np.array(kept_edges, dtype=np.int64)


def _pair(edge: Any, name: str) -> tuple[int, int]:
    try:
        a, b = edge
    except (TypeError, ValueError):
        raise InvalidParameter(f"{name} is {edge!r}, not a pair of vertex numbers") from None
    if not isinstance(a, Integral) or not isinstance(b, Integral):
        raise InvalidParameter(f"{name} is {edge!r}, not a pair of vertex numbers")
    return int(a), int(b)


def forest(faces: Faces, order: Indices) -> Indices:
    """Sides that form a spanning forest of the faces when added in this order without closing rings."""
    owner = np.repeat(np.arange(len(faces.first) - 1), np.diff(faces.first))
    pairs = np.column_stack([owner[order], owner[faces.twins[order]]]).tolist()
    root = list(range(len(faces.first) - 1))

    def find(f: int) -> int:
        while root[f] != f:
            root[f] = f = root[root[f]]
        return f

    found = []
    for s, (f, g) in zip(order.tolist(), pairs, strict=True):
        f, g = find(f), find(g)
        if f != g:
            root[f] = g
            found.append(s)
    return np.array(found, dtype=np.int64)


def _around(faces: Faces, sides: Sequence[int], keep: Edges) -> str:
    """Clause about the first kept edge that closes a ring."""
    for k in range(len(sides)):
        boundary = np.unique(sides[: k + 1])
        if len(forest(faces, boundary)) < len(boundary):
            break
    a, b = keep[k]
    left = np.bincount(faces.corners, minlength=1) - np.bincount(
        faces.corners[np.concatenate([boundary, faces.twins[boundary]])], minlength=faces.corners.max() + 1
    )
    around = next((v for v in (a, b) if left[v] == 0), None)
    where = "closes a ring of faces" if around is None else f"joins all faces around vertex {around}"
    return f"keep[{k}] ({a}, {b}) {where}, which cannot lie flat"
