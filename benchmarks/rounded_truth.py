"""What could be known of a surface from lengths with errors, and how far from it an answer is.

The floor is the least-squares surface held near the true vertices X: the minimum of

    ``|r|^2 / sigma^2 + |x - X|^2 / s^2``,

r the errors of the lengths, sigma their standard deviation, s one percent of the diameter.  The second term
matters only for motions that lengths with these errors tell to less than s; without it, Newton's method
leaves soft surfaces for others far away.  It uses the true vertices, so nothing that knows only the lengths
can be expected to do better, and where the surface has several shapes within the errors it is out of reach.

Nothing here uses the package's own solvers.
"""

import numpy as np
from scipy.sparse import coo_array, eye_array
from scipy.sparse.linalg import splu

HELD = 0.01  # diameters


def farthest(vertices, true):
    """The largest distance of a vertex from its true place, after the best rigid motion or reflection."""
    a, b = vertices - vertices.mean(axis=0), true - true.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    return float(np.linalg.norm(a @ (u @ v) - b, axis=1).max())


def diameter(points):
    """The largest distance between two of the points, to a few percent: along 200 directions."""
    directions = np.random.default_rng(0).standard_normal((200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return float(np.ptp(points @ directions.T, axis=0).max())


def residuals(edges, vertices, lengths):
    """How much longer the edges are than the lengths, and their directions."""
    d = vertices[edges[:, 0]] - vertices[edges[:, 1]]
    found = np.linalg.norm(d, axis=1)
    return found - lengths, d / found[:, None]


def least_squares_surface(edges, lengths, true, sigma):
    """The floor: damped Gauss-Newton steps from the true vertices."""
    n, count, held = true.size, len(edges), HELD * diameter(true)
    rows = np.repeat(np.arange(count), 6)
    columns = (3 * edges[:, :, None] + np.arange(3)).reshape(count, 6).ravel()

    def energy(x):
        r, _ = residuals(edges, x, lengths)
        return (r @ r) / sigma**2 + np.sum((x - true) ** 2) / held**2

    x, value, damping = true, energy(true), 0.0
    for _ in range(100):
        r, directions = residuals(edges, x, lengths)
        entries = np.stack([directions, -directions], axis=1).ravel()
        rates = coo_array((entries, (rows, columns)), shape=(count, n)).tocsr()
        gradient = rates.T @ r / sigma**2 + (x - true).ravel() / held**2
        matrix = rates.T @ rates / sigma**2 + (1 + damping) / held**2 * eye_array(n)
        trial = x - splu(matrix.tocsc()).solve(gradient).reshape(-1, 3)
        reached = energy(trial)
        if reached > value:
            damping = max(10 * damping, 1.0)
            continue
        settled = value - reached <= 1e-6 * value
        x, value, damping = trial, reached, damping / 10
        if settled:
            break
    return x


def integrals(faces, vertices):
    """Area, volume, and the integral of the mean curvature, half the sum of lengths times bends."""
    p, q, r = vertices[faces].transpose(1, 0, 2)
    normals = np.cross(q - p, r - p)
    twice = np.linalg.norm(normals, axis=1)
    volume = np.einsum("ij,ij->", p, np.cross(q, r)) / 6
    unit = normals / twice[:, None]
    sides = {
        (a, b): f
        for f, face in enumerate(faces.tolist())
        for a, b in zip(face, face[1:] + face[:1], strict=True)
    }
    total = 0.0
    for (a, b), f in sides.items():
        if a < b:
            edge, g = vertices[b] - vertices[a], sides[b, a]
            length = np.linalg.norm(edge)
            sine = np.cross(unit[f], unit[g]) @ edge / length
            total += length * np.arctan2(sine, unit[f] @ unit[g])
    return {"area": twice.sum() / 2, "volume": volume, "integrated_mean_curvature": total / 2}
