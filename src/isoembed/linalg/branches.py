"""Branches of the elimination tree, which threads work on at the same time, and the top that joins them.

The cut depends on the tree alone, not on the number of threads, so that factors and solutions are the same
bit for bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Indices, Indices32
from isoembed.linalg.supernodes import Supernodes, subtrees
from isoembed.mesh.triangulation import frozen

LEAST = 1e8  # multiplications from which on threads are worth their start: some 30 ms
MOST_SHARE, LEAST_SHARE = 0.1, 0.01  # of the whole cost, for a branch
NOTHING = frozen(np.empty(0, dtype=np.int32))


class Part(NamedTuple):
    """A branch, or the top: supernodes and matrix, their rows numbered from 0.

    Attributes
    ----------
    nodes : Supernodes
    indptr, indices : ndarray of int32
        The lower triangle of the columns in compressed columns.
    entries : slice or ndarray of int64
        Which entries of the whole matrix these are.
    columns : slice or ndarray of int64
        Which columns of the whole matrix these are.
    beyond : ndarray of int32
        Of a branch, the columns of the top that are its further rows.
    """

    nodes: Supernodes
    indptr: Indices32
    indices: Indices32
    entries: slice | Indices
    columns: slice | Indices
    beyond: Indices32


def cut(nodes: Supernodes, indptr: Indices32, indices: Indices32) -> tuple[tuple[Part, ...], Part]:
    """Branches and top of an elimination tree; of a small one, no branches and the whole.

    Parameters
    ----------
    nodes : Supernodes
        Of the whole matrix.
    indptr, indices : ndarray of int32
        Its lower triangle in compressed columns with sorted rows.
    """
    above, first, costs = subtrees(nodes.starts, nodes.ends, nodes.rows)
    roots = _roots(above, costs)
    if len(roots) < 2:
        return (), Part(nodes, indptr, indices, slice(None), slice(None), NOTHING)
    in_top = np.ones(len(above), dtype=np.bool_)
    for r in roots:
        in_top[first[r] : r] = False  # the root itself stands in the top for what its branch passes on
    kept = np.flatnonzero(in_top)
    widths, heights = np.diff(nodes.starts), np.diff(nodes.ends)
    inside = np.zeros(nodes.starts[-1], dtype=np.bool_)
    for r in roots:
        inside[nodes.starts[first[r]] : nodes.starts[r + 1]] = True
    columns = np.flatnonzero(~inside)
    place = np.full(nodes.starts[-1], -1, dtype=np.int32)
    place[columns] = np.arange(len(columns), dtype=np.int32)
    branches = tuple(_branch(nodes, indptr, indices, first[r], r, place) for r in roots)
    widths, children, among = widths[kept], nodes.children[kept], np.searchsorted(kept, roots)
    widths[among] = children[among] = 0
    top = Supernodes.of(
        np.concatenate([[0], np.cumsum(widths)]),
        children,
        np.concatenate([[0], np.cumsum(heights[kept])]),
        place[nodes.rows[np.repeat(in_top, heights)]],
    )
    counts = np.diff(indptr)
    entries = np.flatnonzero(np.repeat(~inside, counts))
    pointers = np.concatenate([[0], np.cumsum(counts[columns])]).astype(np.int32)
    return branches, Part(top, pointers, place[indices[entries]], entries, columns, NOTHING)


def _roots(above: Indices32, costs: np.ndarray) -> list[int]:
    """The roots of the branches, in order: the costliest is cut into its children while it is too large."""
    whole = float(costs[above < 0].sum())
    if whole < LEAST:
        return []
    roots = np.flatnonzero(above < 0).tolist()
    while True:
        roots.sort(key=lambda r: -float(costs[r]))
        if not roots or costs[roots[0]] <= MOST_SHARE * whole:
            return sorted(r for r in roots if above[r] >= 0)
        children = np.flatnonzero(above == roots.pop(0))
        roots += children[costs[children] >= LEAST_SHARE * whole].tolist()


def _branch(
    nodes: Supernodes, indptr: Indices32, indices: Indices32, s: int, r: int, place: Indices32
) -> Part:
    """The branch of supernodes s to r."""
    begin, end = int(nodes.starts[s]), int(nodes.starts[r + 1])
    beyond = nodes.rows[nodes.ends[r] : nodes.ends[r + 1]]

    def numbered(rows: Indices32) -> Indices32:
        outside = rows >= end
        found = rows - begin
        found[outside] = end - begin + np.searchsorted(beyond, rows[outside])
        return found.astype(np.int32)

    own = Supernodes.of(
        nodes.starts[s : r + 2] - begin,
        nodes.children[s : r + 1],
        nodes.ends[s : r + 2] - nodes.ends[s],
        numbered(nodes.rows[nodes.ends[s] : nodes.ends[r + 1]]),
    )
    entries = slice(int(indptr[begin]), int(indptr[end]))
    pointers = indptr[begin : end + 1] - indptr[begin]
    return Part(own, pointers, numbered(indices[entries]), entries, slice(begin, end), place[beyond])
