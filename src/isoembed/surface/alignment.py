"""Alignment of two point sets by a rigid motion, and their distance."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.space import EUCLIDEAN, Space


def best_rotation(points: Floats, onto: Floats, weights: Floats | None = None) -> Floats:
    """Rotation R (3, 3) that minimizes the squared distance of ``points @ R`` from `onto`, (n, 3), centered.

    The sum of squares is weighted by the weights (n,), if given.  Reflections are excluded.
    Kabsch, Acta Cryst. A32 (1976).
    """
    left, _, right = np.linalg.svd((points if weights is None else points * weights[:, None]).T @ onto)
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ proper @ right)


def aligned(vertices: Floats, onto: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Vertices aligned with other positions of them, by least squares.

    Parameters
    ----------
    vertices, onto : ndarray, shape (V, 3)
        Ambient coordinates in hyperbolic and spherical space.
    space : Space

    Returns
    -------
    ndarray, shape (V, 3)
        The vertices after a rotation and a translation, without a reflection.
    """
    if not space.is_euclidean:
        near = _moved_near(space.centered(vertices), space.centered(onto), space)
        return space.translated(near, space.center(onto))
    center = onto.mean(axis=0)
    x = vertices - vertices.mean(axis=0)
    return x @ best_rotation(x, onto - center) + center


def aligned_image(vertices: Floats, onto: Floats) -> Floats:
    """Vertices in R^3, or their mirror image if that is nearer, as `aligned`, (V, 3)."""
    images = aligned(vertices, onto), aligned(vertices * [1.0, 1.0, -1.0], onto)
    return min(images, key=lambda x: float(np.linalg.norm(x - onto)))


def distance(vertices: Floats, others: Floats, space: Space = EUCLIDEAN) -> float:
    """Largest distance of a vertex from its other position, after the best rotation and translation."""
    moved = aligned(vertices, others, space)
    if space.is_euclidean:
        return float(np.linalg.norm(moved - others, axis=1).max())
    return float(space.distances(moved, others).max())


def _moved_near(x: Floats, onto: Floats, space: Space) -> Floats:
    """Move centered points (n, 3) to a stationary point of the sum of squared chords to others.

    In a motion ``x' = w p + q x y w`` of the points, w changes by ``-k p . x``.
    """
    for _ in range(20):  # rotations and translations alternate
        x = x @ best_rotation(x, onto)
        w = space.heights(x)
        fields = np.array(
            [w[:, None] * axis for axis in np.eye(3)] + [np.cross(axis, x) for axis in np.eye(3)]
        )
        falls = np.concatenate([x.T, np.zeros((3, len(x)))])  # of w, over k
        apart = onto - x
        fall = np.einsum("ij,ij->i", apart, x + onto) / (w + space.heights(onto))
        products = np.einsum("kij,lij->kl", fields, fields) + space.curvature * falls @ falls.T
        forces = np.einsum("kij,ij->k", fields, apart) + space.curvature * falls @ fall
        shift = np.linalg.lstsq(products, forces, rcond=None)[0][:3]
        x = space.translated(x, shift)
        if np.linalg.norm(shift) <= 1e-15 * np.abs(x).max():  # rounding
            break
    return x
