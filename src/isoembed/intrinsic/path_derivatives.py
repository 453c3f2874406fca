"""How the lengths of straight paths follow those of the edges of the triangles that they cross, in the plane.

A path and the triangles around it are a framework that one bar too many stiffens: with the path itself it has
one stress, w_e on the edges and -1 on the path, in balance at every corner, and for changes that keep the
triangles in one plane ``d path = sum of w_e dl_e``.  The corners are balanced one after the other, from the
end of the path back to its start; each then has two edges left.
"""

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats, Indices, Points
from isoembed.errors import InvalidParameter
from isoembed.intrinsic.edge_paths import EdgePaths
from isoembed.intrinsic.halfedges import HalfEdges, following, preceding
from isoembed.intrinsic.trigonometry import cross, norm
from isoembed.kernel import kernel


def path_derivatives(paths: EdgePaths) -> csr_array:
    """Derivatives of the lengths of paths by those of half-edges, sparse of shape (n, 3F).

    Of the two half-edges of an edge one has the derivative, and the other none.

    Parameters
    ----------
    paths : EdgePaths
        Over flat triangles that are a simplicial complex.

    Raises
    ------
    InvalidParameter
        The triangles are not flat, or a path has not been found.
    """
    tables = paths.tables
    if tables.curvature != 0:
        raise InvalidParameter(f"the triangles have the curvature {tables.curvature:g}, not 0")
    if paths.lost.size:
        lost = int(paths.lost[0])
        raise InvalidParameter(f"the path of edge {lost} {paths.ends[lost].tolist()} has not been found")
    counts = np.diff(paths.offsets)
    pointers = np.concatenate([[0], np.cumsum(np.where(counts == 0, 1, 2 * counts + 3))])
    columns, values = np.zeros(pointers[-1], dtype=np.int64), np.ones(pointers[-1])
    columns[pointers[:-1][counts == 0]] = _sides(tables, paths.ends[counts == 0])
    for e in np.flatnonzero(counts).tolist():
        crossed, entries = slice(*paths.offsets[e : e + 2]), slice(*pointers[e : e + 2])
        _balance(paths.halfedges[crossed], tables, columns[entries], values[entries])
    return csr_array((values, columns, pointers), shape=(len(counts), tables.corners.size))


def _sides(tables: HalfEdges, ends: Indices) -> Indices:
    """Half-edges between pairs of vertices (n, 2)."""
    n = int(tables.corners.max()) + 1
    keys = [np.min(pair, axis=0) * n + np.max(pair, axis=0) for pair in (tables.ends, ends.T)]
    order = np.argsort(keys[0], kind="stable")
    return np.asarray(order[np.searchsorted(keys[0][order], keys[1])])


@kernel
def _balance(crossed: Indices, tables: HalfEdges, columns: Indices, values: Floats) -> None:
    """The half-edges around one path that crosses some, and their stresses."""
    n, l = crossed.size, tables.lengths
    z, load = np.zeros(n + 3, dtype=np.complex128), np.zeros(n + 3, dtype=np.complex128)
    near, far = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)  # the ends of what is crossed
    h = crossed[0]
    z[1] = complex(l[preceding(h)], 0.0)
    z[2] = _third(z[0], z[1], l[preceding(h)], l[following(h)], l[h])
    tail, head = 1, 2
    for k in range(n):
        near[k], far[k], tip = tail, head, k + 3
        g = tables.twins[crossed[k]]
        z[tip] = _third(z[head], z[tail], l[g], l[preceding(g)], l[following(g)])
        columns[2 * k], columns[2 * k + 1] = following(g), preceding(g)
        if k + 1 < n:
            if crossed[k + 1] == preceding(g):
                tail = tip
            else:
                head = tip
    end = n + 2
    load[end] = (z[end] - z[0]) / norm(z[end] - z[0])
    for k in range(n - 1, -1, -1):
        _carry(k + 3, near[k], far[k], z, load, values[2 * k : 2 * k + 2])
    columns[2 * n], columns[2 * n + 1], columns[2 * n + 2] = following(h), h, preceding(h)
    _carry(2, 0, 1, z, load, values[2 * n : 2 * n + 2])
    values[2 * n + 2] = load[1].real


@kernel
def _third(a: complex, b: complex, base: float, at_a: float, at_b: float) -> complex:
    """The corner to the left of the side from a to b, of this length, at these distances from both."""
    along = (base * base + (at_a - at_b) * (at_a + at_b)) / (2 * base)
    height = np.sqrt(max((at_a - along) * (at_a + along), 0.0))
    return a + (b - a) / base * complex(along, height)


@kernel
def _carry(v: int, a: int, b: int, z: Points, load: Points, stresses: Floats) -> None:
    """Balance the load at v by the edges to a and b, and hand it on to these."""
    to_a, to_b = z[v] - z[a], z[v] - z[b]
    to_a, to_b = to_a / norm(to_a), to_b / norm(to_b)
    area = cross(to_a, to_b)
    stresses[0], stresses[1] = cross(load[v], to_b) / area, cross(to_a, load[v]) / area
    load[a] += stresses[0] * to_a
    load[b] += stresses[1] * to_b
