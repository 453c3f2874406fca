"""Face numbers: placement inside the faces of a net."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.convex import Pieces, overlaps
from isoembed.papercraft.labels import HEIGHT, LEAST, SHRINK, WIDTH, Label

SIZE = 6.0  # mm
STEPS = 12  # of the grid of places in each direction, within a face
PLACES = 8  # that are tried, those far from the sides


def face_numbers(
    faces: Sequence[Floats], numbers: Sequence[int], labels: Iterable[Label] = ()
) -> list[Label]:
    """The number of each face, F0, F1, ..., as large as it can be without meeting a line or a label.

    Parameters
    ----------
    faces : sequence of ndarray, shape (n, 2)
        The corners around each, in mm on the paper.
    numbers : sequence of int
    labels : iterable of Label
        Those that are there.
    """
    rims = (np.stack([face, np.roll(face, -1, axis=0)], axis=1) for face in faces)
    lines, taken = Pieces(2, chain.from_iterable(rims)), Pieces(4, (one.box for one in labels))
    found = []
    for face, number in zip(faces, numbers, strict=True):
        one = _inside(f"F{number}", face, (lines, taken))
        taken.add(one.box)
        found.append(one)
    return found


def _inside(text: str, face: Floats, obstacles: Sequence[Pieces]) -> Label:
    places, room = _middles(face)
    close = [some.near(face) for some in obstacles]
    # In a circle of this radius around the best place no side is nearer.
    size = min(SIZE, 2 * room / (SHRINK * np.hypot(WIDTH * len(text), HEIGHT)))
    while size >= LEAST:
        for x, y in places:
            one = Label(text, x, y, 0.0, size)
            if not any(overlaps(one.box, some) for some in close):
                return one
        size *= SHRINK
    return Label(text, *places[0], 0.0, LEAST)


def _middles(face: Floats) -> tuple[list[tuple[float, float]], float]:
    """Places inside a face that are far from its sides, and how far the first one is."""
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
    best = np.argsort(-apart, kind="stable")[:PLACES]
    return [(float(x), float(y)) for x, y in points[best]], max(float(apart[best[0]]), 0.0)
