"""Convex bodies with flat vertices on their faces and edges, and their triangulations without these."""

import numpy as np

from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric


def tables_of(vertices, faces):
    """The tables of the triangles of a surface."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return GluedMetric.of(metric).half_edges()


def checked(tables):
    """The same as a metric, if it is one."""
    return GluedMetric(tables.faces, tables.twins, tables.face_lengths)


def box(n, sides=(1.0, 1.0, 1.0)):
    """A box with n x n rectangles, each cut in two, on every side: (vertices, faces, which are flat)."""
    number, faces = {}, []
    for axis in range(3):
        for far in (0, n):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for i in range(n):
                for j in range(n):
                    corners = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        place = [0, 0, 0]
                        place[axis], place[u], place[v] = far, i + di, j + dj
                        corners.append(number.setdefault(tuple(place), len(number)))
                    a, b, c, d = corners if far else corners[::-1]
                    faces += [[a, b, c], [a, c, d]]
    vertices = np.array(list(number)) / n
    return vertices * sides, np.array(faces), ((vertices > 0) & (vertices < 1)).any(axis=1)


def doubled(n, seed, length=1.0):
    """A random n-gon covered twice, n > 3, its sides cut up differently: (vertices, faces)."""
    angles = np.sort(np.random.default_rng(seed).uniform(0, 2 * np.pi, n)) + 0.1 * np.arange(n)
    points = np.column_stack([length * np.cos(angles * 0.9), np.sin(angles * 0.9), np.zeros(n)])
    top = [(0, i, i + 1) for i in range(1, n - 1)]
    bottom = [(1, (i + 1) % n, i) for i in range(2, n)]
    return points, np.array(top + bottom)


def sprinkled(vertices, faces, n, seed):
    """The same surface with n vertices more, a third of them on edges, and all renumbered.

    Returns vertices, faces, and which are new.
    """
    rng = np.random.default_rng(seed)
    points, triangles = [np.asarray(v) for v in vertices], [list(face) for face in faces]
    for v in range(len(points), len(points) + n):
        f = int(rng.integers(len(triangles)))
        a, b, c = np.roll(triangles[f], rng.integers(3)).tolist()
        if rng.random() < 1 / 3:
            t = rng.uniform(0.1, 0.9)
            points.append((1 - t) * points[a] + t * points[b])
            sides = [[(g[0], g[1]), (g[1], g[2]), (g[2], g[0])] for g in triangles]
            other = next(g for g, of_g in enumerate(sides) if (b, a) in of_g)
            d = sum(triangles[other]) - a - b
            triangles[f], triangles[other] = [a, v, c], [b, v, d]
            triangles += [[v, b, c], [v, a, d]]
        else:
            points.append(rng.dirichlet([2, 2, 2]) @ [points[a], points[b], points[c]])
            triangles[f] = [a, b, v]
            triangles += [[b, c, v], [c, a, v]]
    new = rng.permutation(len(points))
    moved = np.empty((len(points), 3))
    moved[new] = points
    flat = np.ones(len(points), dtype=bool)
    flat[new[: len(vertices)]] = False
    return moved, new[np.array(triangles)][rng.permutation(len(triangles))], flat


def polyhedron(tables, vertices):
    """Flip to the triangles of a convex polyhedron, and tell at which half-edges it is bent.

    Squared distances from a point inside are the weights of which these are the weighted Delaunay triangles.
    """
    tables = tables.copy()
    make_delaunay(tables, ((vertices - vertices.mean(axis=0)) ** 2).sum(axis=1))
    a, b, c = vertices[tables.faces.T]
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    here, there = np.repeat(normals, 3, axis=0), normals[tables.twins // 3]
    return tables, (here * there).sum(axis=1) < 1 - 1e-9


def distances(tables, vertices):
    """Straight through space along every half-edge."""
    return np.linalg.norm(vertices[tables.corners] - vertices[tables.corners[tables.twins]], axis=1)


def turning_errors(tables):
    """By how much directions fail to grow, around every vertex, by the angles of the triangles."""
    angles = checked(tables).triangles.angles.ravel()
    total = np.bincount(tables.corners, angles)[tables.corners]
    into = np.roll(np.arange(tables.corners.size).reshape(-1, 3), 1, axis=1).ravel()
    turns = (tables.directions[tables.twins[into]] - tables.directions - angles) / total
    return np.abs(turns - np.round(turns)) * total
