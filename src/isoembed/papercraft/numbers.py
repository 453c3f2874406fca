"""Face numbers: placement inside the faces of a net."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.gluing.polygon import segments
from isoembed.papercraft.convex import Pieces, overlapping
from isoembed.papercraft.labels import HEIGHT, SHRINK, WIDTH, Label

STEPS = 12  # of the grid of candidate positions in each direction, within a face


def face_numbers(
    faces: Sequence[Floats],
    numbers: Sequence[int],
    labels: Iterable[Label] = (),
    *,
    lines: Iterable[Floats] | None = None,
    is_seen: Callable[[int, Floats], Mask] | None = None,
) -> list[Label | None]:
    """Labels F0, F1, ... of faces, as large as possible without meeting a line or a label.

    A face without room for a legible label has None.

    Parameters
    ----------
    faces : sequence of ndarray, shape (n, 2)
        Corners around each face, in mm on the paper.
    numbers : sequence of int
    labels : iterable of Label
        Labels already placed.
    lines : iterable of ndarray, shape (2, 2), optional
        Lines to avoid; by default the sides of all faces.
    is_seen : callable, optional
        Returns which points, (n, 2), of the k-th face are visible, in a drawing of the solid.
    """
    if lines is None:
        lines = chain.from_iterable(map(segments, faces))
    drawn, occupied = Pieces(2, lines), Pieces(4, (one.box for one in labels))
    found = []
    for k, (face, number) in enumerate(zip(faces, numbers, strict=True)):
        one = _inside(f"F{number}", *_middles(face, is_seen and partial(is_seen, k)), (drawn, occupied))
        if one is not None:
            occupied.add(one.box)
        found.append(one)
    return found


def _inside(text: str, places: Floats, room: float, obstacles: Sequence[Pieces]) -> Label | None:
    # A circle of this radius around the best place meets no side.
    size = min(6.0, 2 * room / (SHRINK * np.hypot(WIDTH * len(text), HEIGHT)))
    around = np.concatenate([Label(text, x, y, 0.0, max(size, 0.0)).box for x, y in places.tolist()])
    close = [some.near(around) for some in obstacles]
    while size >= 1.0:  # mm
        some = [Label(text, x, y, 0.0, size) for x, y in places.tolist()]
        boxes = np.array([one.box for one in some])
        is_free = ~np.any([overlapping(boxes, others) for others in close], axis=0)
        if is_free.any():
            return some[int(np.argmax(is_free))]
        size *= SHRINK
    return None


def _middles(face: Floats, is_seen: Callable[[Floats], Mask] | None) -> tuple[Floats, float]:
    """Candidate positions inside a face, (p, 2), far from its sides, and the distance of the first."""
    low, high = face.min(axis=0), face.max(axis=0)
    steps = (np.arange(STEPS) + 0.5) / STEPS
    grid = low + (high - low) * np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    points = np.vstack([face.mean(axis=0), grid])
    start, side = face, np.roll(face, -1, axis=0) - face
    to = points[:, None] - start
    along = np.clip(np.einsum("pkj,kj->pk", to, side) / np.einsum("kj,kj->k", side, side), 0.0, 1.0)
    apart = np.linalg.norm(to - along[:, :, None] * side, axis=2).min(axis=1)
    crossed = (to[:, :, 1] < 0) != (to[:, :, 1] < side[:, 1])
    right = (side[:, 0] * to[:, :, 1] - side[:, 1] * to[:, :, 0]) * np.sign(side[:, 1]) > 0
    apart[(crossed & right).sum(axis=1) % 2 == 0] *= -1.0
    if is_seen is not None:
        inside = np.flatnonzero(apart > 0)
        apart[inside[~is_seen(points[inside])]] = -np.inf
    best = np.argsort(-apart, kind="stable")[:8]  # those farthest from the sides
    return points[best], max(float(apart[best[0]]), 0.0)
