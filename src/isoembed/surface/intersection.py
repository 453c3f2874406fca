"""Self-intersections of a triangulated surface: bounding box tree and separating axes."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices, Mask

CONTACT = 2.0**-47  # relative to the largest coordinate of a pair: closer points are in contact
CHUNK = 1 << 15  # pairs compared at once, which bounds the memory


def self_intersections(faces: ArrayLike, vertices: ArrayLike, reach: float = 0.0) -> Indices:
    """Pairs of intersecting triangles.

    Two triangles intersect if they have a point in common beyond their shared corner or edge:
    triangles without a common corner if they touch or cross, triangles with one common corner if they meet
    anywhere else, triangles with a common edge if they are folded flat on each other.  Contact counts as
    intersection, and so do points closer than 7e-15 times the largest coordinate of the pair, which double
    precision cannot distinguish from contact.  Coplanar triangles that meet only in their common corner or
    edge (a subdivided flat face) do not intersect.  A triangle without area may intersect its neighbors.

    Parameters
    ----------
    faces : array_like of int, shape (F, 3)
    vertices : array_like of float, shape (V, 3)
        Finite coordinates of any scale.
    reach : float
        Bound on the error of the vertices.  Pairs not returned do not intersect for any vertices within this
        distance of the given ones.

    Returns
    -------
    ndarray of int, shape (n, 2)
        Faces ``i < j``, in lexicographic order; empty for an embedded surface.

    Notes
    -----
    Disjoint triangles have a separating plane that is parallel to one of them, or to an edge of each, or
    perpendicular to one of them along an edge (Gottschalk, Lin and Manocha, "OBBTree", 1996).  Any separating
    direction proves disjointness, however inaccurate: needles cannot produce a false "disjoint".
    The cost is proportional to the number of overlapping boxes: about N log N for a good triangulation.
    """
    corners = np.asarray(faces, dtype=np.int64)
    points = np.asarray(vertices, dtype=np.float64)
    unit = np.abs(points).max(initial=0.0) or 1.0
    points, reach = points / unit, reach / unit
    boxes = _overlapping_boxes(points[corners], reach)
    found = [pairs[_intersect(corners, points, pairs, reach)] for pairs in boxes]
    pairs = np.sort(np.concatenate([np.empty((0, 2), dtype=np.int64), *found]), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _overlapping_boxes(triangles: Floats, reach: float) -> Iterator[Indices]:
    """Yield blocks of pairs of triangles whose bounding boxes overlap, each pair once.

    The boxes are the leaves of a balanced binary tree; pairs of nodes are opened from a stack of blocks.
    """
    count = len(triangles)
    if count == 0:
        return
    depth = (count - 1).bit_length()
    # Margin for the rounding of coordinates, so that no contact is missed.
    room = CONTACT * np.abs(triangles).max(axis=(1, 2))[:, None] + reach
    low, high = triangles.min(axis=1) - room, triangles.max(axis=1) + room
    centers = low + high
    order = np.concatenate([np.arange(count), np.full((1 << depth) - count, -1)])[None]
    for _ in range(depth):
        # Split each node at the median along its widest direction; the padding (-1) goes last.
        filled = order[..., None] >= 0
        center = centers[order]
        width = np.where(filled, center, -np.inf).max(axis=1) - np.where(filled, center, np.inf).min(axis=1)
        axis = width.argmax(axis=1)[:, None, None]
        key = np.where(filled, np.take_along_axis(center, axis, axis=2), np.inf)[..., 0]
        order = np.take_along_axis(order, np.argsort(key, axis=1, kind="stable"), axis=1).reshape(
            2 * len(order), -1
        )
    leaves = order.ravel()
    lows = [np.where(leaves[:, None] >= 0, low[leaves], np.inf)]
    highs = [np.where(leaves[:, None] >= 0, high[leaves], -np.inf)]
    for _ in range(depth):
        lows.append(lows[-1].reshape(-1, 2, 3).min(axis=1))
        highs.append(highs[-1].reshape(-1, 2, 3).max(axis=1))

    stack = [(depth, np.zeros((1, 2), dtype=np.int64))]
    while stack:
        level, nodes = stack.pop()
        if len(nodes) > CHUNK:
            stack.append((level, nodes[CHUNK:]))
            nodes = nodes[:CHUNK]
        a, b = nodes.T
        overlap = (lows[level][a] <= highs[level][b]).all(axis=1) & (lows[level][b] <= highs[level][a]).all(
            axis=1
        )
        nodes = nodes[overlap]
        if level == 0:
            yield leaves[nodes[nodes[:, 0] != nodes[:, 1]]]
        elif len(nodes):
            a, b = 2 * nodes.T
            children = np.concatenate([np.stack([a + i, b + j], axis=1) for i in (0, 1) for j in (0, 1)])
            stack.append((level - 1, children[children[:, 0] <= children[:, 1]]))


def _intersect(faces: Indices, points: Floats, pairs: Indices, reach: float) -> Mask:
    """Decide whether the pairs intersect, by the number of shared corners."""
    first, second = faces[pairs[:, 0]], faces[pairs[:, 1]]
    same = first[:, :, None] == second[:, None, :]
    shared = same.sum(axis=(1, 2))
    answer = shared == 3  # the same triangle twice
    for count, decide in ((0, _apart), (1, _apart_at_corner), (2, _apart_at_edge)):
        chosen = np.flatnonzero(shared == count)
        if len(chosen) == 0:
            continue
        # Bring the distinguished corner to the front: the only shared one, or that opposite a shared edge.
        odd = 1 if count == 1 else 0
        i = (same[chosen].any(axis=2) == odd).argmax(axis=1)[:, None]
        j = (same[chosen].any(axis=1) == odd).argmax(axis=1)[:, None]
        turn = np.arange(3)
        p = points[np.take_along_axis(first[chosen], (i + turn) % 3, axis=1)]
        q = points[np.take_along_axis(second[chosen], (j + turn) % 3, axis=1)]
        # Use the pair's own unit, with one of its corners as the origin.
        coordinate = np.maximum(np.abs(p).max(axis=(1, 2)), np.abs(q).max(axis=(1, 2)))
        origin = p[:, -1:] if count == 2 else p[:, :1]
        p, q = p - origin, q - origin
        size = np.maximum(np.abs(p).max(axis=(1, 2)), np.abs(q).max(axis=(1, 2)))
        size[size == 0] = 1.0
        contact, moves = CONTACT * coordinate / size, 2 * reach / size
        answer[chosen] = ~decide(p / size[:, None, None], q / size[:, None, None], contact, moves)
    return answer


def _apart(p: Floats, q: Floats, contact: Floats, moves: Floats) -> Mask:
    """Whether triangles without a common corner are disjoint, shapes (n, 3, 3), (n, 3, 3), (n,), (n,).

    They remain disjoint if differences of corners change by at most `moves`.
    """
    e, f = np.roll(p, -1, axis=1) - p, np.roll(q, -1, axis=1) - q
    n, m = np.cross(e[:, 0], e[:, 1])[:, None], np.cross(f[:, 0], f[:, 1])[:, None]
    crossed = np.cross(e[:, :, None], f[:, None]).reshape(-1, 9, 3)
    axes = _units(np.concatenate([n, m, crossed, np.cross(n, e), np.cross(m, f)], axis=1))
    along_p, along_q = axes @ p.swapaxes(1, 2), axes @ q.swapaxes(1, 2)
    gap = np.maximum(
        along_p.min(axis=2) - along_q.max(axis=2),
        along_q.min(axis=2) - along_p.max(axis=2),
    )
    return (gap > (contact + moves)[:, None]).any(axis=1)


def _apart_at_corner(p: Floats, q: Floats, contact: Floats, moves: Floats) -> Mask:
    """Whether triangles with a common first corner, the origin, meet nowhere else.

    They meet elsewhere if their sectors at the corner, cones with two generators each, share a ray.  The
    separating planes form a cone; its generators are among the `axes`, and their sum, in the interior of the
    cone, separates strictly if any plane does.
    """
    sides = [p[:, 1], p[:, 2], -q[:, 1], -q[:, 2]]
    couples = [(0, 1), (2, 3), (0, 2), (0, 3), (1, 2), (1, 3)]
    normals = [np.cross(sides[i], sides[j]) for i, j in couples]
    in_plane = [np.cross(normals[i // 2], sides[i]) for i in range(4)]
    axes = _units(np.stack(normals + in_plane, axis=1))
    axes = np.concatenate([axes, -axes], axis=1)
    heights = axes @ np.stack(sides, axis=2)
    # Zero by construction, up to rounding of the cross product of nearly parallel sides.
    upright = np.zeros((10, 4), dtype=bool)
    for k, on in enumerate([*couples, (0,), (1,), (2,), (3,)]):
        upright[k, list(on)] = True
    heights[:, np.concatenate([upright, upright])] = 0.0
    weakly = np.all(heights >= -contact[:, None, None], axis=2)
    inner = _units((axes * weakly[..., None]).sum(axis=1))
    strictly = np.stack([(inner * side).sum(axis=1) > contact + moves for side in sides])
    return np.asarray(strictly.all(axis=0))


def _apart_at_edge(p: Floats, q: Floats, contact: Floats, moves: Floats) -> Mask:
    """Whether triangles with a common edge, from their second corner to the origin, are not folded flat."""
    e = _units(p[:, 1])
    x, y = (r[:, 0] - (r[:, 0] * e).sum(axis=1)[:, None] * e for r in (p, q))  # heights over the edge
    low, height = np.sort([np.linalg.norm(x, axis=1), np.linalg.norm(y, axis=1)], axis=0)
    farther = np.maximum(np.linalg.norm(p[:, 0], axis=1), np.linalg.norm(q[:, 0], axis=1))
    length = np.linalg.norm(p[:, 1], axis=1)
    # A height changes with its corner and, by 2 moves / length at most, with the direction of the edge.
    leaning = np.divide(farther, length, out=np.full_like(length, np.inf), where=length > 2 * moves)
    change = np.where(moves > 0, moves * (1 + 2 * leaning), 0.0)
    is_open = np.linalg.norm(np.cross(x, y), axis=1) > (contact + 3 * change) * height
    return np.asarray(is_open | ((x * y).sum(axis=1) <= 0) & (low >= 2 * change))


def _units(vectors: Floats) -> Floats:
    """Normalized vectors; zero vectors stay zero."""
    norms = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, norms, out=np.zeros_like(vectors), where=norms > 0)
