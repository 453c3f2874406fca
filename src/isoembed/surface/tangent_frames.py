"""Tangent frames at points and faces, in Euclidean, hyperbolic and spherical space.

Around a point, space is represented in the conformal model centered there, in which lengths and curvatures of
surfaces are correct to leading order.  Vectors at a point are identified with vectors at the origin by the
translation along the line through both.
"""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.space import Space
from isoembed.space.models import to_model


def directions(space: Space, x: Floats, y: Floats) -> Floats:
    """Unit vectors (n, 3) at points x (n, 3) toward points y (n, 3)."""
    along = sides(space, x, y)
    return along / np.linalg.norm(along, axis=-1, keepdims=True)


def sides(space: Space, x: Floats, y: Floats) -> Floats:
    """Directions (n, 3) at points x (n, 3) toward points y (n, 3), with the sn of the distances as norms.

    Each is the image of y under the translation from x to the origin, without cancellation for y near x.
    """
    d = y - x
    if space.is_euclidean:
        return d
    w = space.heights(x)
    along = np.einsum("ij,ij->i", d, x + y) / (w + space.heights(y))
    squares = np.einsum("ij,ij->i", d, d) + space.curvature * along * along
    return np.asarray(d + (space.curvature * (along + squares / 2) / (1 + w))[:, None] * x)


def drawn_faces(space: Space, faces: Indices, points: Floats) -> Floats:
    """Corners (F, 3, 3) of triangles, in curved space in the conformal model about each centroid."""
    corners = points[faces]
    if space.is_euclidean:
        return corners
    centers, _ = _centers(space, corners)
    return to_model(space, space.translated(corners, -centers[:, None]), "conformal")


def carried_to_faces(space: Space, faces: Indices, points: Floats, tensors: Floats) -> Floats:
    """Tensors at the vertices, (V, 3, 3), transported to the corners of `drawn_faces`, (F, 3, 3, 3)."""
    at_corners = tensors[faces]
    if space.is_euclidean:
        return at_corners
    turns = _turns(space, points[faces])
    return np.asarray(turns @ at_corners @ turns.transpose(0, 1, 3, 2))


def _centers(space: Space, corners: Floats) -> tuple[Floats, Floats]:
    """Centroids (F, 3) of the corners and their heights (F,)."""
    mean, w = corners.mean(axis=1), space.heights(corners).mean(axis=1)
    size = np.sqrt(w * w + space.curvature * np.einsum("fi,fi->f", mean, mean))
    return mean / size[:, None], w / size


def _turns(space: Space, corners: Floats) -> Floats:
    """Rotations (F, 3, 3, 3) from the frames at the corners to those of `drawn_faces`.

    A vector u translated to the origin is ``(u - k x (x.u) / (1 + w), -k x.u)`` at X = (x, w); it moves with
    X under the translation from the centroid to the origin, and is then translated to the origin again.
    """
    k, w = space.curvature, space.heights(corners)
    centers, height = _centers(space, corners)
    m, h = centers[:, None], height[:, None]
    moved = space.translated(corners, -m)
    moved_w = space.heights(moved)
    columns = []
    for u in np.eye(3):
        along = corners @ u
        v, last = u - corners * (k * along / (1 + w))[..., None], -k * along
        v = v - m * (last + k * np.einsum("fci,fci->fc", np.broadcast_to(m, v.shape), v) / (1 + h))[..., None]
        back = k * np.einsum("fci,fci->fc", moved, v) / (moved_w * (1 + moved_w))
        columns.append(v + moved * back[..., None])
    return np.stack(columns, axis=-1)
