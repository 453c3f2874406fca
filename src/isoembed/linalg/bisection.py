"""Recursive bisection of a mesh, by separators of few vertices or cuts of few edges.

A cell of the graph is cut across its longest axis in coordinates of the vertices, where that severs few
edges; then the smallest separator near the cut is found.
"""

import numpy as np

from isoembed.arrays import Floats, Indices, Indices32
from isoembed.kernel import kernel
from isoembed.linalg.separator import SEPARATOR, Graph, empty_band, separate

WINDOW = 0.25  # distance of a cut from the median of its cell, at most, in cells
PLACES = 64  # positions of a cut that are compared


def separators(graph: Graph, position: Floats) -> tuple[Indices, Indices, Indices]:
    """Elimination order of the vertices of a graph by nested dissection, and where they are in its tree.

    Parameters
    ----------
    graph : Graph
        Planar or nearly so.
    position : ndarray, shape (n, 3)
        Coordinates in which neighbors are near.

    Returns
    -------
    order, path, depth : ndarray of int64, shape (n,)
        Binary digits of the path, as many as the depth, the highest first, tell the parts of the graph taken
        on the way to the cell of each vertex, or to the cell that it separates.
    """
    return _bisected(graph, position, True)


@kernel
def lift_ends(indptr: Indices32, indices: Indices32, path: Indices, depth: Indices) -> int:
    """Where an edge of another graph joins two parts, move an end into what separates them; how often.

    The deeper end goes.  Then every edge joins a vertex to one of the same cell, or of a separator above.
    """
    lifted = 0
    for v in range(path.size):
        for p in range(indptr[v], indptr[v + 1]):
            u = indices[p]
            if u >= v:
                continue
            level = min(depth[u], depth[v])
            a, b = path[u] >> (depth[u] - level), path[v] >> (depth[v] - level)
            if a == b:
                continue
            while a != b:
                a, b, level = a >> 1, b >> 1, level - 1
            w = v if depth[v] >= depth[u] else u
            path[w], depth[w] = a, level
            lifted += 1
    return lifted


def bisection_paths(graph: Graph, position: Floats) -> Indices:
    """Cut a graph in two, where few edges are severed, and the parts in two, down to a few vertices.

    A cut runs along the smallest separator, whose vertices go to the side where they have more neighbors.
    Binary digits, the highest first and as many for every vertex, tell the parts taken on the way down, (n,).
    """
    _, paths, depths = _bisected(graph, position, False)
    return paths << (depths.max() - depths)


@kernel
def _bisected(graph: Graph, position: Floats, separated: bool) -> tuple[Indices, Indices, Indices]:
    """Return the vertices, both parts of a cell before the separator, if any, and their paths and depths."""
    n = graph.indptr.size - 1
    order, members = np.arange(n), np.empty(n, dtype=np.int64)
    cell, path, depth = np.zeros((3, n), dtype=np.int64)
    height, heights = np.empty((2, n))
    table = np.empty((2, PLACES + 1), dtype=np.int64)
    band = empty_band(n)
    cells = 1
    waiting = [(0, n)]
    while waiting:
        start, end = waiting.pop()
        size = end - start
        if size <= 4:  # cutting smaller cells saves hardly any fill
            continue
        for k in range(size):
            members[k] = order[start + k]
        _measure(members[:size], position, height)
        _cut(graph, members[:size], cell, height, heights[:size], table)
        # a band of .05 sqrt(size) layers on either side, at most six
        separate(graph, members[:size], cell, min(int(0.05 * np.sqrt(size)), 6), band)
        if not separated:
            _dissolve(graph, members[:size], cell)
        lower = upper = 0
        for v in members[:size]:
            if cell[v] != SEPARATOR:
                lower += 1 - (cell[v] & 1)
                upper += cell[v] & 1
        if max(lower, upper) == size:
            continue
        a, b, c = start, start + lower, start + lower + upper
        waiting.append((a, b))
        waiting.append((b, c))
        for v in members[:size]:
            if cell[v] == SEPARATOR:
                order[c] = v
                c += 1
                continue
            depth[v] += 1
            path[v] = 2 * path[v] + (cell[v] & 1)
            if cell[v] & 1 == 0:
                order[a] = v
                a += 1
                cell[v] = 2 * cells
            else:
                order[b] = v
                b += 1
                cell[v] = 2 * cells + 2
        cells += 2
    return order, path, depth


@kernel
def _measure(members: Indices, position: Floats, height: Floats) -> None:
    """Set `height` of the vertices of a cell: their coordinate along its longest axis."""
    x = y = z = 0.0
    for v in members:
        x += position[v, 0]
        y += position[v, 1]
        z += position[v, 2]
    x /= members.size
    y /= members.size
    z /= members.size
    xx = xy = xz = yy = yz = zz = 0.0
    for v in members:
        a, b, c = position[v, 0] - x, position[v, 1] - y, position[v, 2] - z
        xx += a * a
        xy += a * b
        xz += a * c
        yy += b * b
        yz += b * c
        zz += c * c
    # Squares of the matrix of moments, until the longest axis is left; its longest column then is that axis.
    for _ in range(5):
        trace = xx + yy + zz
        if trace <= 0:
            break
        xx, xy, xz, yy, yz, zz = (xx / trace, xy / trace, xz / trace, yy / trace, yz / trace, zz / trace)
        xx, xy, xz, yy, yz, zz = (
            xx * xx + xy * xy + xz * xz,
            xx * xy + xy * yy + xz * yz,
            xx * xz + xy * yz + xz * zz,
            xy * xy + yy * yy + yz * yz,
            xy * xz + yy * yz + yz * zz,
            xz * xz + yz * yz + zz * zz,
        )
    if xx >= yy and xx >= zz:
        a, b, c = xx, xy, xz
    elif yy >= zz:
        a, b, c = xy, yy, yz
    else:
        a, b, c = xz, yz, zz
    for v in members:
        height[v] = a * position[v, 0] + b * position[v, 1] + c * position[v, 2]


@kernel
def _cut(
    graph: Graph, members: Indices, cell: Indices, height: Floats, heights: Floats, table: Indices
) -> None:
    """Cut a cell at a height near the median that severs little: numbers above it become odd.

    ``heights`` and ``table``, (2, places + 1), are room to work in.
    """
    size = members.size
    for k in range(size):
        heights[k] = height[members[k]]
    low = _selected(heights, int((0.5 - WINDOW) * size))
    high = _selected(heights, int((0.5 + WINDOW) * size))
    if not low < high:
        _halve(members, cell, height, low)
        return
    # Bin 0 is below low, bins 1, 2, .. lie between low and high.
    bins = min(PLACES, max(4, size // 4))
    scale = bins / (high - low)
    inside, change = table  # vertices in a bin, and severed edges above it less those below
    for b in range(bins + 1):
        inside[b] = change[b] = 0
    for v in members:
        if height[v] < low:
            inside[0] += 1
        elif height[v] <= high:
            here = min(int((height[v] - low) * scale) + 1, bins)
            inside[here] += 1
            for p in range(graph.indptr[v], graph.indptr[v + 1]):
                u = graph.indices[p]
                if cell[u] == cell[v]:
                    if height[u] > height[v]:
                        there = min(int((min(height[u], high) - low) * scale) + 1, bins)
                        change[here] += 1
                        change[there] -= 1
                    elif height[u] < low:
                        change[0] += 1
                        change[here] -= 1
    least, best = np.inf, 0
    below = severed = 0
    for b in range(bins):
        below += inside[b]
        severed += change[b]
        # the factor 2 weighs balance against severed edges
        cost = (severed + 1) * (1 + 2.0 * (below / size - 0.5) * (below / size - 0.5))
        if below > 0 and cost < least:
            least, best = cost, b
    level = low + best / scale
    for v in members:
        cell[v] += height[v] >= level


@kernel
def _halve(members: Indices, cell: Indices, height: Floats, level: float) -> None:
    """Cut a cell at a height that many vertices have: these one by one, until the halves are equal."""
    left = members.size // 2
    for v in members:
        left -= height[v] < level
    for v in members:
        if height[v] == level and left > 0:
            left -= 1
        elif height[v] >= level:
            cell[v] += 1


@kernel
def _dissolve(graph: Graph, members: Indices, cell: Indices) -> None:
    """Put every vertex of a separator on the side where it has more neighbors."""
    odd = 1
    for v in members:
        if cell[v] != SEPARATOR:
            odd = cell[v] | 1
    for v in members:
        if cell[v] == SEPARATOR:
            excess = 0
            for p in range(graph.indptr[v], graph.indptr[v + 1]):
                side = cell[graph.indices[p]]
                excess += int(side == odd) - int(side == odd - 1)
            cell[v] = odd - int(excess < 0)


@kernel
def _selected(values: Floats, k: int) -> float:
    """The k-th smallest value, from 0; the values are moved about (Hoare, Find, Comm. ACM 4, 1961)."""
    first, last = 0, values.size - 1
    while first < last:
        pivot = values[(first + last) // 2]
        i, j = first, last
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if k <= j:
            last = j
        elif k >= i:
            first = i
        else:
            break
    return float(values[k])
