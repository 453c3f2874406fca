"""Meshes of discs, bands and tori for the tests, and surfaces over them."""

import numpy as np
from scipy.spatial import Delaunay

from isoembed import InvalidMetric, PolyhedralMetric
from isoembed.gallery import SURFACES, triangulate


def hexagonal(n):
    """Points (V, 2) and triangles of the unit disc: n rings of 6, 12, ... points about the center."""
    angles = [np.zeros(1)] + [2 * np.pi * np.arange(6 * k) / (6 * k) for k in range(1, n + 1)]
    rings = [k / n * np.stack([np.cos(a), np.sin(a)], axis=1) for k, a in enumerate(angles)]
    start = np.concatenate([[0], 1 + 3 * np.arange(n + 1) * np.arange(1, n + 2)])

    def at(k, j):
        return start[k] + j % (6 * k) if k else 0

    faces = []
    for k in range(1, n + 1):
        for side in range(6):
            for i in range(k):
                outer, inner = side * k + i, side * (k - 1) + i
                faces.append((at(k - 1, inner), at(k, outer), at(k, outer + 1)))
                if i < k - 1:
                    faces.append((at(k - 1, inner), at(k, outer + 1), at(k - 1, inner + 1)))
    return np.concatenate(rings), np.array(faces)


def irregular(n, seed=0):
    """Points (V, 2) and triangles of the unit disc: about n points at random, relaxed a little."""
    rng = np.random.default_rng(seed)
    count = int(np.sqrt(3.6 * n))
    turn = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    h = 2 * np.pi / count
    r, phi = (1 - 0.7 * h) * np.sqrt(rng.uniform(size=n - count)), 2 * np.pi * rng.uniform(size=n - count)
    inner = r[:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    for _ in range(12):
        points = np.concatenate([rim, inner])
        faces = Delaunay(points).simplices
        sums, counts = np.zeros_like(points), np.zeros(len(points))
        for corner in faces.T:
            np.add.at(sums, corner, points[faces].mean(axis=1))
            np.add.at(counts, corner, 1)
        inner = (sums / counts[:, None])[count:]
        size = np.linalg.norm(inner, axis=1)
        inner *= (np.minimum(size, 1 - 0.6 * h) / size)[:, None]
    points = np.concatenate([rim, inner])
    faces = Delaunay(points).simplices
    a, b, c = points[faces].transpose(1, 0, 2)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)
    return points, faces[np.abs(area) > 1e-9]


def round_cap(points, angle):
    """The part of the unit sphere within an angle of the pole, over a disc."""
    r, phi = angle * np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
    return np.stack([np.sin(r) * np.cos(phi), np.sin(r) * np.sin(phi), np.cos(r)], axis=1)


def hyperbolic_lengths(points, radius, edges):
    """Lengths of geodesics in a disc of the hyperbolic plane."""
    r, phi = radius * np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
    x = np.stack([np.cosh(r), np.sinh(r) * np.cos(phi), np.sinh(r) * np.sin(phi)], axis=1)
    d = x[edges[:, 0]] - x[edges[:, 1]]
    return 2 * np.arcsinh(np.sqrt(d[:, 1] ** 2 + d[:, 2] ** 2 - d[:, 0] ** 2) / 2)


def band(around, along, profile):
    """A surface of revolution between two circles: vertices, triangles.  profile(t) is (rho, z)."""
    vertices, faces = [], []
    for j in range(along + 1):
        rho, z = profile(j / along)
        turn = 2 * np.pi * (np.arange(around) + 0.5 * (j % 2)) / around
        vertices.append(np.stack([rho * np.cos(turn), rho * np.sin(turn), np.full(around, z)], axis=1))
    for j in range(along):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            if j % 2:
                c, d = (j + 1) * around + i, (j + 1) * around + (i + 1) % around
                faces += [(a, b, d), (a, d, c)]
            else:
                c, d = (j + 1) * around + (i - 1) % around, (j + 1) * around + i
                faces += [(a, b, d), (a, d, c)]
    return np.concatenate(vertices), np.array(faces)


def torus(n, m, bump=0.0):
    """A torus of radii 2 and 0.8, n by m, with bumps."""
    u = 2 * np.pi * np.arange(n)[:, None] / n
    v = 2 * np.pi * (np.arange(m) + 0.5 * (np.arange(n)[:, None] % 2)) / m
    q = 0.8 * (1 + bump * np.cos(2 * u + v) + bump * np.sin(3 * v - u))
    x = (2 + q * np.cos(v)) * np.cos(u) * (1 + 0.5 * bump * np.cos(u))
    vertices = np.stack([x, (2 + q * np.cos(v)) * np.sin(u), q * np.sin(v)], axis=2).reshape(-1, 3)
    faces = []
    for i in range(n):
        for j in range(m):
            a, b, c, d = i * m + j, i * m + (j + 1) % m, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m
            faces += [(a, d, b), (a, c, d)] if i % 2 else [(a, c, b), (b, c, d)]
    return vertices, np.array(faces)


def random_disc(name, seed):
    """Vertices and triangles of a bumpy graph with K of both signs, a round cap or half a gallery body."""
    rng = np.random.default_rng(seed)
    if name == "half":
        return _half(seed, rng)
    points, faces = irregular(int(rng.integers(60, 250)), seed)
    if name == "cap":
        return round_cap(points, rng.uniform(0.3, 1.5)), faces
    x, y = points.T
    a, b, c, d = rng.uniform([1.5, 1.2, 0.15, -0.2], [2.5, 2.2, 0.3, 0.2])
    return np.column_stack([points, c * np.sin(a * x + 0.3) * np.cos(b * y) + d * x * y]), faces


def _half(seed, rng):
    """The triangles of a gallery body on one side of a random plane through its center that are a disc."""
    body = list(SURFACES.values())[seed % len(SURFACES)]()
    vertices, faces = triangulate(body, int(rng.integers(120, 500)), irregular=seed)
    while True:
        normal = rng.normal(size=3)
        kept = faces[((vertices - vertices.mean(axis=0)) @ normal > 0)[faces].all(axis=1)]
        used, renumbered = np.unique(kept, return_inverse=True)
        try:
            t = PolyhedralMetric.from_mesh(vertices[used], renumbered.reshape(-1, 3)).triangulation
        except InvalidMetric:  # in parts, or two of its triangles have one vertex in common
            continue
        if len(t.boundaries) == 1 and t.genus == 0:
            return vertices[used], t.faces
