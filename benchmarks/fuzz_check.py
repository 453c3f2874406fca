"""Whether an answer is right: checks in extended precision that share no code with the solvers.

In R^3, in hyperbolic space and on the 3-sphere.  All take vertices and tables, with numpy and scipy alone.
"""

import itertools
from decimal import Decimal, InvalidOperation, localcontext

import numpy as np
from scipy.spatial import ConvexHull, QhullError

LENGTHS = 1.01e-10  # mean edge lengths: the tolerance, and the rounding of measuring it
PATHS = 3e-10  # mean edge lengths
DIGITS = 50  # of unfolded triangles: far out in hyperbolic space, rounding grows with e^(distance)
OFF_HULL = 1e-9  # of the size
CLEAR = 1e-12  # of the size, cubed: volumes that are not rounding
ASIDE = 1e-7  # mean edge lengths by which a straight path may miss the side that it crosses


def heights(x, k):
    """The fourth coordinate of points on hyperboloid or sphere, times the root of |k|."""
    return np.sqrt(1 - k * (x * x).sum(axis=-1))


def distances(x, y, k):
    """Distances between points, (..., 3) each."""
    x, y = np.asarray(x, dtype=np.longdouble), np.asarray(y, dtype=np.longdouble)
    squares = ((x - y) ** 2).sum(axis=-1)
    if k == 0:
        return np.sqrt(squares)
    # 1 - <x, y>, without the difference of heights where these are large.
    p, q = (x * x).sum(axis=-1), (y * y).sum(axis=-1)
    rise = k * (p - q) / (heights(x, k) + heights(y, k))
    chords = np.sqrt(np.maximum(squares + rise * rise / k, 0))
    root = np.sqrt(np.longdouble(abs(k)))
    half = root * chords / 2
    return 2 / root * (np.arcsin(np.minimum(half, 1)) if k > 0 else np.arcsinh(half))


def length_error(vertices, faces, lengths, k):
    """Largest error of a side, over the mean."""
    sides = distances(vertices[faces], vertices[np.roll(faces, -1, axis=1)], k)
    return float(np.abs(sides - lengths).max() / lengths.mean())


def path_error(found):
    """Errors of the given edges, drawn straight over unfolded triangles of the answer, in mean edge lengths.

    Parameters
    ----------
    found : ConvexPolyhedron

    Returns
    -------
    length : float
        Largest error of a length; infinite if the triangles that it is to cross are no chain.
    aside : float
        By how much a straight path misses a side that it is to cross.
    """
    with localcontext() as context:
        context.prec = DIGITS
        try:
            return _path_error(found)
        except InvalidOperation:  # vertices coincide
            return np.inf, np.inf


def _path_error(found):
    paths, k = found.edge_paths, found.metric.curvature
    corners, twins = np.asarray(paths.tables.corners), np.asarray(paths.tables.twins)
    after = np.arange(corners.size) // 3 * 3 + (np.arange(corners.size) + 1) % 3
    x = np.array([[Decimal(c) for c in vertex] for vertex in found.vertices.tolist()])
    if k:
        x *= Decimal(abs(k)).sqrt()
        x = np.column_stack([x, [(1 - int(np.sign(k)) * (vertex @ vertex)).sqrt() for vertex in x]])
    sides = {(corners[h], corners[after[h]]) for h in range(corners.size)}
    unit, scale = found.given.mean_length, np.sqrt(np.longdouble(abs(k) or 1))
    length, aside = 0.0, 0.0
    given = given_lengths(found)
    for e, (a, b) in enumerate(np.asarray(paths.ends).tolist()):
        crossed = paths.halfedges[paths.offsets[e] : paths.offsets[e + 1]].tolist()
        if not crossed:
            direct = float(distances(found.vertices[a], found.vertices[b], k))
            linked = (a, b) in sides or (b, a) in sides
            length = max(length, abs(direct - given[e]) / unit if linked else np.inf)
            continue
        if corners[after[after[crossed[0]]]] != a:
            return np.inf, np.inf
        plane = Plane(x, a, corners[crossed[0]], corners[after[crossed[0]]], int(np.sign(k)))
        tail, head, gates = plane.tail, plane.head, []
        for h, then in itertools.zip_longest(crossed, crossed[1:]):
            gates.append((tail, head))
            back = int(twins[h])
            tip = corners[after[after[back]]]
            place = plane.beyond(x, (corners[h], corners[after[h]], tip), (tail, head), -1)
            if then is None and tip == b:
                break
            if then == after[back]:
                head = place
            elif then == after[after[back]]:
                tail = place
            else:
                return np.inf, np.inf
        straight, missed = plane.straight(place, gates)
        length = max(length, abs(float(straight / scale) - given[e]) / unit)
        aside = max(aside, float(missed / scale) / unit)
    return length, aside


def given_lengths(found):
    """Lengths of the given edges in the order of the paths."""
    twins = np.asarray(found.given.twins)
    lengths = np.asarray(found.given.face_lengths).ravel()
    corners = np.asarray(found.given.faces).ravel()
    halfedges = np.flatnonzero(np.arange(twins.size) < twins)
    ends = np.stack([corners[halfedges], corners[twins[halfedges]]], axis=1)
    if np.array_equal(np.sort(ends, axis=1), np.sort(found.edge_paths.ends, axis=1)):
        return lengths[halfedges]
    order = np.lexsort((ends.max(axis=1), ends.min(axis=1)))
    return lengths[halfedges][order]


class Plane:
    """Where triangles are unfolded: vectors of R^3, with a plane, hyperboloid or sphere of radius 1 in it.

    All numbers are `Decimal`.
    """

    def __init__(self, x, a, tail, head, sign):
        self.sign = sign
        self.start = np.array([Decimal(0), Decimal(0), Decimal(1)])
        if sign == 0:
            u = x[tail] - x[a]
            self.tail = np.array([(u @ u).sqrt(), 0, 1])
        else:
            c = sign * self.form(x[a], x[tail])
            self.tail = np.array([abs(1 - c * c).sqrt(), 0, c])
        self.head = self.beyond(x, (a, tail, head), (self.start, self.tail), 1)

    def form(self, u, v):
        """The scalar product: of differences in the plane, of points on hyperboloid or sphere."""
        return u[:-1] @ v[:-1] + self.sign * u[-1] * v[-1]

    def beyond(self, x, corners, edge, side):
        """Place the third corner of a triangle, left (1) or right (-1) of the edge that has the others."""
        a, b, c = (x[v] for v in corners)
        start, arm = edge[0], edge[1] - edge[0]
        u, v = b - a, c - a
        if self.sign == 0:
            along = (u @ v) / (u @ u)
            off = v - along * u
            height = ((off @ off) / (u @ u)).sqrt()
            return start + along * arm + side * height * np.array([-arm[1], arm[0], Decimal(0)])
        f = u - self.sign * self.form(u, a) * a
        along = self.form(f, v) / self.form(f, f)
        up = self.sign * self.form(a, v)
        off = v - along * f - up * a
        height = max(self.form(off, off), Decimal(0)).sqrt()
        arm = arm - self.sign * self.form(arm, start) * start
        normal = np.cross(start, arm)
        normal[2] *= self.sign  # orthogonal in the form
        normal /= self.form(normal, normal).sqrt()
        return start + up * start + along * arm + side * height * normal

    def straight(self, end, gates):
        """Distance of the ends, and by how much the line between passes beside the gates."""
        line, chord = np.cross(self.start, end), end - self.start
        size = (line @ line).sqrt() or Decimal(1)
        missed = max(max(-(line @ head), line @ tail, 0) / size for tail, head in gates)
        if self.sign == 0:
            return np.longdouble((chord @ chord).sqrt()), np.longdouble(missed)
        half = np.longdouble(abs(self.form(chord, chord)).sqrt()) / 2
        distance = 2 * (np.arcsin(min(half, 1)) if self.sign > 0 else np.arcsinh(half))
        return distance, np.longdouble(missed)


def outside_hull(vertices, faces, k):
    """How far the surface is from its own hull, over the size; infinite if vertices are inside of it."""
    y = np.asarray(vertices, dtype=np.longdouble)
    y = (y / heights(y, np.longdouble(k))[:, None]).astype(float)
    y = y - y.mean(axis=0)
    y /= np.abs(y).max()
    try:
        hull = ConvexHull(y)
    except QhullError:
        return 0.0
    points = np.vstack([y, y[faces].mean(axis=1)])
    return float(np.abs((points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)).max())


def apart(first, second, k):
    """Largest difference of the distances between vertices, over the largest distance."""
    one, two = (between(x, k) for x in (first, second))
    return float(np.abs(one - two).max() / two.max())


def gap(first, second, k):
    """Largest difference of the distances between vertices."""
    return float(np.abs(between(first, k) - between(second, k)).max())


def between(x, k):
    """Distances of every two points."""
    x = np.asarray(x)
    i, j = np.triu_indices(len(x), 1)
    return distances(x[i], x[j], k)


def misfit(first, second, weights):
    """Distances of the vertices after the isometry of R^3 that is best in weighted least squares, (V,)."""
    a, b = (x - np.average(x, axis=0, weights=weights) for x in (first, second))
    u, _, v = np.linalg.svd(a.T @ (weights[:, None] * b))
    return np.linalg.norm(a @ u @ v - b, axis=1)


def pierced(vertices, faces, k):
    """An edge and a face without a common corner that cross, clearly, or None."""
    y = np.asarray(vertices) / heights(np.asarray(vertices), k)[:, None]
    y = (y - y.mean(axis=0)) / np.ptp(y, axis=0).max()
    edges = np.unique(np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)), axis=0)
    p, q, r = (y[faces[:, c]] for c in range(3))
    normals = np.cross(q - p, r - p)
    for edge in edges:
        a, b = y[edge]
        apart = ~np.isin(faces, edge).any(axis=1)
        ends = [np.einsum("fi,fi->f", normals, end - p) for end in (a, b)]
        sides = [np.cross(u - a, v - a) @ (b - a) for u, v in ((p, q), (q, r), (r, p))]
        through = apart & (ends[0] * ends[1] < 0) & (np.abs(np.sign(sides).sum(axis=0)) == 3)
        through &= np.abs([*ends, *sides]).min(axis=0) > CLEAR
        if through.any():
            return edge.tolist(), faces[np.argmax(through)].tolist()
    return None
