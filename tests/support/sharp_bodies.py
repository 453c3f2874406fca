"""Bodies with sharp edges for tests and benchmarks: vertices, and triangles that are irregular.

Each builder has a seed: vertices inside flat faces are moved at random, diagonals and turns of rings chosen.
"""

from itertools import pairwise

import numpy as np

import zoo

JITTER = 0.15  # edge lengths, of vertices inside of faces


def jittered(vertices, faces, seed):
    """Move vertices inside flat faces at random, in their planes."""
    rng, x = np.random.default_rng(seed), np.array(vertices, dtype=float)
    a, b, c = x[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    size = np.sqrt(np.linalg.norm(normals, axis=1).mean())
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    moved = x.copy()
    for v in range(len(x)):
        around = normals[(faces == v).any(axis=1)]
        if np.ptp(around, axis=0).max() < 1e-9:
            step = JITTER * size * rng.standard_normal(3).clip(-1.5, 1.5)
            moved[v] += step - (step @ around[0]) * around[0]
    return moved, faces


def box(shape, size, seed):
    """A grid of rectangles on each side, with diagonals at random."""
    rng, number, triangles = np.random.default_rng(seed), {}, []
    for axis, end in np.ndindex(3, 2):
        n, m = np.delete(shape, axis)
        corners = np.insert(np.argwhere(np.ones((n + 1, m + 1))), axis, end * shape[axis], axis=1)
        at = np.array([number.setdefault(tuple(each), len(number)) for each in corners.tolist()])
        at = at.reshape(n + 1, m + 1)
        squares = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(-1, 4)
        for square in squares if (end + axis) % 2 else squares[:, ::-1]:
            turned = np.roll(square, rng.integers(2))
            triangles += [turned[[0, 1, 2]], turned[[0, 2, 3]]]
    return jittered(np.array(list(number)) * np.divide(size, shape), np.array(triangles), seed)


def rings(profile, counts, seed):
    """A body of revolution: points at random turns on rings at each (radius, height) of a profile."""
    rng, at, points, faces = np.random.default_rng(seed), [], [], []
    for (radius, height), n in zip(profile, counts, strict=True):
        turns = 2 * np.pi * (np.arange(n) + rng.uniform() + rng.uniform(-0.12, 0.12, n)) / n
        at.append((len(points), turns))
        points += [(radius * np.cos(t), radius * np.sin(t), height) for t in turns]
    for (first, low), (second, high) in pairwise(at):
        n, m = len(low), len(high)
        turned = int(np.argmin(np.abs(np.angle(np.exp(1j * (high - low[0])))))) if m > 1 else 0
        high = np.r_[high[turned:], high[:turned] + 2 * np.pi]
        high -= 2 * np.pi * np.round((high[0] - low[0]) / (2 * np.pi))
        i = k = 0
        steps = (n if n > 1 else 0), (m if m > 1 else 0)
        while (i, k) != steps:
            a, b = first + i % n, second + (k + turned) % m
            next_low, next_high = low[(i + 1) % n] + 2 * np.pi * ((i + 1) // n), 2 * np.pi * ((k + 1) // m)
            if k == steps[1] or (i < steps[0] and next_low < high[(k + 1) % m] + next_high):
                faces.append((a, first + (i + 1) % n, b))
                i += 1
            else:
                faces.append((a, second + (k + 1 + turned) % m, b))
                k += 1
    return np.array(points), np.array(faces)


def profile(pieces, edge):
    """Radii and heights of rings along pieces of a profile, and numbers of their points."""
    found = [pieces[0](0.0)]
    for piece in pieces:
        t = np.linspace(0, 1, 400)
        length = np.linalg.norm(np.diff([piece(s) for s in t], axis=0), axis=1).sum()
        steps = max(1, round(length / (0.87 * edge)))
        found += [piece(s) for s in np.arange(1, steps + 1) / steps]
    counts = [max(1 if radius < 1e-9 else 5, round(2 * np.pi * radius / edge)) for radius, _ in found]
    return [(max(r, 0.0), z) for r, z in found], counts


def line(start, end):
    return lambda s: (start[0] + s * (end[0] - start[0]), start[1] + s * (end[1] - start[1]))


def cylinder(height, edge, seed):
    sides = [line((0, 0), (1, 0)), line((1, 0), (1, height)), line((1, height), (0, height))]
    return rings(*profile(sides, edge), seed)


def cone(height, edge, seed):
    return rings(*profile([line((0, 0), (1, 0)), line((1, 0), (0, height))], edge), seed)


def half_ball(edge, seed):
    def arc(s):
        return np.cos(s * np.pi / 2), np.sin(s * np.pi / 2)

    return rings(*profile([line((0, 0), (1, 0)), arc], edge), seed)


def lens(angle, edge, seed):
    def cap(sign):
        return lambda s: (np.sin(s * angle) / np.sin(angle), sign * (np.cos(s * angle) - np.cos(angle)))

    up = cap(1.0)
    return rings(*profile([cap(-1.0), lambda s: up(1 - s)], edge), seed)


def prism(outline, height, times, seed):
    """A prism over a convex outline, its triangles divided."""
    n = len(outline)
    low, high = np.pad(outline, ((0, 0), (0, 1))), np.pad(outline, ((0, 0), (0, 1)), constant_values=height)
    vertices = np.vstack([low, high, low.mean(axis=0), high.mean(axis=0)])
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.vstack(
        [
            np.stack(each, axis=1)
            for each in (
                (i, j, j + n),
                (i, j + n, i + n),
                (j, i, 0 * i + 2 * n),
                (i + n, j + n, 0 * i + 2 * n + 1),
            )
        ]
    )
    for _ in range(times):
        vertices, faces = zoo.subdivided(vertices, faces)
    return jittered(vertices, faces, seed)


def pyramid(n, height, times, seed):
    turn = 2 * np.pi * np.arange(n) / n
    vertices = np.vstack(
        [np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), [[0, 0, height], [0, 0, 0.0]]]
    )
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.vstack([np.stack([i, j, 0 * i + n], axis=1), np.stack([j, i, 0 * i + n + 1], axis=1)])
    for _ in range(times):
        vertices, faces = zoo.subdivided(vertices, faces)
    return jittered(vertices, faces, seed)


def notched(times, seed):
    """A prism over an L, which is not convex."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    bottom = [(2, 1, 0), (3, 2, 0), (5, 3, 0), (5, 4, 3)]
    top = [(6 + a, 6 + b, 6 + c) for c, b, a in bottom]
    sides = [
        side for i in range(6) for side in ((i, (i + 1) % 6, (i + 1) % 6 + 6), (i, (i + 1) % 6 + 6, i + 6))
    ]
    vertices = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline])
    faces = np.array(bottom + top + sides)
    for _ in range(times):
        vertices, faces = zoo.subdivided(vertices, faces)
    return jittered(vertices, faces, seed)


def polygon(n):
    turn = 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)


def rod(n, times, step, seed):
    """A prism over a polygon of n unit sides, with vertices on its long edges only."""
    rng, outline = np.random.default_rng(seed), polygon(n) / (2 * np.sin(np.pi / n))
    vertices = np.vstack(
        [np.pad(outline, ((0, 0), (0, 1)), constant_values=step * k) for k in range(times + 1)]
    )
    faces = []
    for k, i in np.ndindex(times, n):
        a, b = n * k + i, n * k + (i + 1) % n
        faces += [(a, b, b + n), (a, b + n, a + n)] if rng.integers(2) else [(a, b, a + n), (b, b + n, a + n)]
    last = n * times
    faces += [(0, i + 1, i) for i in range(1, n - 1)]
    faces += [(last, last + i, last + i + 1) for i in range(1, n - 1)]
    return vertices, np.array(faces)


BODIES = {
    "box": lambda s: box((5, 4, 3), (10, 7, 4.5), s),
    "flat box": lambda s: box((8, 8, 2), (8.5, 8, 2.2), s),
    "cylinder": lambda s: cylinder(1.2, 0.33, s),
    "flat cylinder": lambda s: cylinder(0.5, 0.24, s),
    "half ball": lambda s: half_ball(0.27, s),
    "lens 0.5": lambda s: lens(0.5, 0.22, s),
    "lens 1.0": lambda s: lens(1.0, 0.24, s),
    "prism 3": lambda s: prism(polygon(3), 1.5, 2, s),
    "prism 6": lambda s: prism(polygon(6), 1.0, 2, s),
    "pyramid 4": lambda s: pyramid(4, 1.1, 3, s),
    "cone 0.5": lambda s: cone(0.5, 0.24, s),
    "cone 1": lambda s: cone(1.0, 0.26, s),
    "cone 2": lambda s: cone(2.0, 0.33, s),
    "cone 1 coarse": lambda s: cone(1.0, 0.42, s),
    "cone 3 fine": lambda s: cone(3.0, 0.28, s),
    "rod 1 x 1 x 8": lambda s: box((8, 1, 1), (8, 1, 1), s),
    "rod 1 x 2 x 12": lambda s: box((12, 1, 2), (12, 1, 2), s),
    "rod 3 x 10": lambda s: rod(3, 10, 1.0, s),
    "rod 4 x 20": lambda s: rod(4, 20, 1.0, s),
    "rod 5 x 6": lambda s: rod(5, 6, 1.0, s),
    "rod 6 x 12": lambda s: rod(6, 12, 0.8, s),
    "plate 1 x 6 x 6": lambda s: box((6, 6, 1), (6, 6, 1), s),
    "notched prism": lambda s: notched(2, s),
}
