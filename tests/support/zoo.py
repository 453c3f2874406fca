"""Meshes for the tests, made in-line: platonic bodies, spheres, random hulls, and what is no sphere."""

import numpy as np
from scipy.spatial import ConvexHull


def outward_hull(points):
    """Faces of the convex hull, outward, with vertices renumbered without gaps: (vertices, faces)."""
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (hull.points[faces[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    used, renumbered = np.unique(faces, return_inverse=True)
    return hull.points[used], renumbered.reshape(-1, 3)


def tetrahedron():
    """Regular, edge length 2 sqrt 2."""
    return outward_hull(np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]))


def octahedron():
    """Regular, edge length sqrt 2."""
    return outward_hull(np.vstack([np.eye(3), -np.eye(3)]))


def cube():
    """Edge length 1, each square cut along a diagonal."""
    return outward_hull(np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]))


def icosahedron():
    """Regular, edge length 2."""
    phi = (1 + 5**0.5) / 2
    points = [np.roll([0.0, s, t * phi], k) for k in range(3) for s in (1, -1) for t in (1, -1)]
    return outward_hull(np.array(points))


def subdivided(vertices, faces):
    """Each triangle cut into four at the midpoints of its edges."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, of_halfedge = np.unique(ends, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = (len(vertices) + of_halfedge.reshape(-1, 3)).T
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    points = np.vstack([vertices, vertices[edges].mean(axis=1)])
    return points, np.concatenate([np.stack(q, axis=1) for q in quarters])


def icosphere(level):
    """Unit sphere: the icosahedron subdivided and projected, 10 * 4^level + 2 vertices."""
    vertices, faces = icosahedron()
    for _ in range(level):
        vertices, faces = subdivided(vertices, faces)
    return vertices / np.linalg.norm(vertices, axis=1)[:, None], faces


def random_hull(n, seed):
    """Convex hull of n random points on an ellipsoid with axes 1, 0.8, 0.6: every point is a vertex."""
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return outward_hull(points / np.linalg.norm(points, axis=1)[:, None] * [1.0, 0.8, 0.6])


def shallow_cap(n, height, seed):
    """Convex hull of n random points on a paraboloid over the unit disk, and of a point below it."""
    rng = np.random.default_rng(seed)
    r, angle = np.sqrt(rng.uniform(size=n)), rng.uniform(0, 2 * np.pi, n)
    top = np.stack([r * np.cos(angle), r * np.sin(angle), height * (1 - r * r)], axis=1)
    return outward_hull(np.vstack([top, [[0.0, 0.0, -1.0]]]))


def rotation(seed):
    """Return a random rotation matrix."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def relabeled(vertices, faces, seed):
    """Same surface, other vertex numbers, face order and first corners: (vertices, faces, new numbers)."""
    rng = np.random.default_rng(seed)
    new = rng.permutation(len(vertices))
    moved = np.empty_like(vertices)
    moved[new] = vertices
    turned = np.array(
        [np.roll(face, k) for face, k in zip(new[faces], rng.integers(3, size=len(faces)), strict=True)]
    )
    return moved, turned[rng.permutation(len(faces))], new


def edge_opposites(triangulation):
    """The vertex across each edge in its left and in its right face, (E, 2)."""
    face, corner = np.divmod(triangulation.edge_halfedges, 3)
    return triangulation.faces[face, (corner + 2) % 3]


def torus(m=4, n=5):
    """Faces of an m x n grid with opposite sides identified: genus 1."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))
    here, right, up, both = (((i + a) % m) * n + (j + b) % n for a, b in ((0, 0), (1, 0), (0, 1), (1, 1)))
    return np.concatenate([np.stack([here, right, both], axis=1), np.stack([here, both, up], axis=1)])


def projective_plane():
    """Faces of the six-vertex projective plane: closed, one-sided."""
    return np.array(
        [
            [0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1],
            [1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2], [5, 1, 3],
        ]
    )  # fmt: skip


def klein_bottle(m=4, n=5):
    """Faces of an m x n grid with one pair of sides identified backward: closed, one-sided."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))

    def index(i, j):
        j = np.where(i == m, -j, j) % n
        return (i % m) * n + j

    here, right, up, both = index(i, j), index(i + 1, j), index(i, j + 1), index(i + 1, j + 1)
    return np.concatenate([np.stack([here, right, both], axis=1), np.stack([here, both, up], axis=1)])


TETRAHEDRON = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def doubly_covered(outline):
    """Both sides of a plane convex polygon (n, 2): (faces, twins, face lengths) of the gluing."""
    n = len(outline)
    i = np.arange(1, n - 1)
    front = np.stack([np.zeros_like(i), i, i + 1], axis=1)
    faces = np.concatenate([front, front[:, ::-1]])
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    side = np.repeat([0, 1], front.size)
    halfedge = {key: h for h, key in enumerate(zip(start, end, side, strict=True))}
    twins = [
        halfedge.get((b, a, s), halfedge.get((b, a, 1 - s))) for a, b, s in zip(start, end, side, strict=True)
    ]
    lengths = np.linalg.norm(outline[start] - outline[end], axis=1)
    return faces, np.array(twins), lengths.reshape(-1, 3)


def aligned(found, true):
    """Largest distance after the best rigid motion, mirror images allowed."""
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    return np.linalg.norm(a @ u @ v - b, axis=1).max()
