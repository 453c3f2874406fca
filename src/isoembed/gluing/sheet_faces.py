"""Nets with one polygon per face: sheets cut along their folds, which are glued again."""

from collections.abc import Sequence

from isoembed.arrays import Indices
from isoembed.gluing.polygon import Side, consecutive


def glued_faces(
    faces: Sequence[Sequence[Sequence[int] | Indices]],
    sides: Sequence[tuple[Side, Side]],
    counts: Sequence[int],
) -> list[tuple[Side, Side]]:
    """Pairs of glued sides of the faces of all sheets, numbered consecutively, including folds.

    Parameters
    ----------
    faces : sequence of sequence of sequence of int
        Corners of the sheet around each of its faces, counterclockwise.
    sides : sequence of pairs
        Glued sides of the sheets.
    counts : sequence of int
        Number of corners of each sheet.
    """
    place: dict[tuple[int, int, int], Side] = {}
    f = 0
    for p, own in enumerate(faces):
        for face in own:
            for k, (a, b) in enumerate(consecutive(face)):
                place[p, a, b] = f, k
            f += 1

    def moved(side: Side) -> Side:
        p, k = side
        return place[p, k, (k + 1) % counts[p]]

    pairs = [(moved(one), moved(other)) for one, other in sides]
    pairs += [(at, place[p, b, a]) for (p, a, b), at in place.items() if a < b and (p, b, a) in place]
    return pairs
