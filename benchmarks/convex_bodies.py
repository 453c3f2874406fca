"""Random convex bodies: vertices and outward triangles."""

import numpy as np

from alexandrov import outward_hull


def log_uniform(rng, low, high):
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def sphere(rng, n):
    x = rng.normal(size=(n, 3))
    return x / np.linalg.norm(x, axis=1)[:, None]


def round_body(rng, least=6, most=60):
    """Hull of points of a normal distribution, in a cube, or on a sphere."""
    n = int(rng.integers(least, most))
    kind = rng.integers(3)
    x = (rng.normal(size=(n, 3)), rng.uniform(-1, 1, (n, 3)), sphere(rng, n))[kind]
    return outward_hull(x)


def with_flat_vertices(rng, points, faces, count):
    """Put vertices into faces and on edges."""
    points, faces = list(points), [list(f) for f in faces]
    for _ in range(count):
        f, new = int(rng.integers(len(faces))), len(points)
        a, b, c = faces[f]
        if rng.random() < 0.5 or len(points) == 3:  # a triangle covered twice is no complex before that
            points.append(rng.dirichlet((2, 2, 2)) @ [points[a], points[b], points[c]])
            faces[f] = [a, b, new]
            faces += [[b, c, new], [c, a, new]]
            continue
        s = rng.uniform(0.2, 0.8)
        points.append((1 - s) * points[a] + s * points[b])
        g = next(g for g, t in enumerate(faces) if any(t[k] == b and t[k - 2] == a for k in range(3)))
        d = next(v for v in faces[g] if v not in (a, b))
        faces[f], faces[g] = [a, new, c], [b, new, d]
        faces += [[new, b, c], [new, a, d]]
    return np.array(points), np.array(faces)


def fan(cycle):
    """Triangles of a polygon, from its first corner."""
    return [[cycle[0], cycle[k], cycle[k + 1]] for k in range(1, len(cycle) - 1)]


def prism_like(rng, low=1e-2, high=1e2):
    """A prism, frustum, antiprism, pyramid, bipyramid, or a prism with a roof, over any polygon."""
    n, height = int(rng.integers(3, 13)), log_uniform(rng, low, high)
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(0, 0.9, n) * (rng.random() < 0.7)) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) * [rng.uniform(1, 3), 1, 1]
    up, tip = np.array([*rng.uniform(-0.3, 0.3, 2), height]), np.array([*rng.uniform(-0.2, 0.2, 2), height])
    i = np.arange(n)
    j, kind = (i + 1) % n, rng.integers(6)
    base = fan(i[::-1].tolist())
    if kind == 0:  # pyramid
        return np.vstack([ring, tip]), np.array([*base, *([a, b, n] for a, b in zip(i, j, strict=True))])
    if kind == 1:  # bipyramid
        down = [0, 0, -log_uniform(rng, low, high)]
        faces = [[a, b, n] for a, b in zip(i, j, strict=True)] + [
            [b, a, n + 1] for a, b in zip(i, j, strict=True)
        ]
        return np.vstack([ring, tip, down]), np.array(faces)
    if kind == 2:  # antiprism: any two polygons
        turned = angle + np.pi / n
        top = np.column_stack([np.cos(turned), np.sin(turned), 0 * turned]) + up
        return outward_hull(np.vstack([ring, top]))
    top = ring * (1 if kind != 3 else rng.uniform(0.2, 0.9)) + up
    walls = [[a, b, n + b] for a, b in zip(i, j, strict=True)] + [
        [a, n + b, n + a] for a, b in zip(i, j, strict=True)
    ]
    if kind < 5:
        return np.vstack([ring, top]), np.array([*base, *walls, *fan((n + i).tolist())])
    roof = top.mean(axis=0) + np.array([0, 0, log_uniform(rng, 1e-3, 1)])
    return np.vstack([ring, top, roof]), np.array(
        [*base, *walls, *([n + a, n + b, 2 * n] for a, b in zip(i, j, strict=True))]
    )
