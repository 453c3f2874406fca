"""Gluing by corner names: sides with the same two names are identified."""

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from isoembed.arrays import Indices
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gluing.polygon import Polygon, Side
from isoembed.gluing.tolerance import ROUNDING, Tolerance, UnequalLengths

Names = Sequence[Sequence[Hashable]]


def read_names(corners: Any, sheets: Sequence[Polygon]) -> Names:
    """Corner names of each polygon, in the given order.

    Raises
    ------
    InvalidParameter
        The names do not match the corners.
    """
    if not isinstance(corners, list | tuple) or len(corners) != len(sheets):
        raise InvalidParameter(f"the corners are not {len(sheets)} lists of names, one for each polygon")
    for p, (names, sheet) in enumerate(zip(corners, sheets, strict=True)):
        if not isinstance(names, str | list | tuple | np.ndarray) or len(names) != sheet.n:
            raise InvalidParameter(
                f"corners[{p}] is {names!r}, not a list of the names of the {sheet.n} corners of polygon {p}"
            )
        for k, name in enumerate(names):
            if isinstance(name, bool) or not isinstance(name, str | int | np.integer):
                raise InvalidParameter(
                    f"corner {k} of polygon {p} is called {name!r}, neither text nor a whole number"
                )
    return [list(names) for names in corners]


def sides_of(
    corners: Names, sheets: Sequence[Polygon], tolerance: Tolerance, any_surface: bool
) -> list[tuple[Side, Side]]:
    """Pairs of sides whose endpoints have the same names; sides without a mate are a boundary if permitted.

    Raises
    ------
    InvalidMetric
        A side has no mate although it needs one, has several, or differs in length from its mate.
    """
    found: dict[frozenset[Hashable], list[Side]] = {}
    for p, names in enumerate(corners):
        for k, name in enumerate(names):
            other = names[(k + 1) % len(names)]
            if name == other:
                raise InvalidMetric(
                    f"side {k} of polygon {p} has corner {name!r} at both ends: corner names do not "
                    "determine its gluing: use sides"
                )
            found.setdefault(frozenset((name, other)), []).append((p, k))
    wrong, difference = "", 0.0
    for some in found.values():
        (p, k), a, b = some[0], *_ends(corners, some[0])
        if len(some) == 1 and any_surface:
            continue
        if len(some) == 1:
            raise InvalidMetric(
                f"side {k} of polygon {p} is glued to nothing: no other side joins corners {a!r} and {b!r}, "
                "and only any_surface permits a boundary"
            )
        if len(some) > 2:
            named = ", ".join(f"{m} of polygon {q}" for q, m in some)
            raise InvalidMetric(
                f"{len(some)} sides join corners {a!r} and {b!r}: side {named}; corner names do not "
                "determine the gluing: use sides"
            )
        q, m = some[1]
        ours, theirs = _length(sheets[p], k), _length(sheets[q], m)
        allowed, difference = tolerance.between(p, q, (ours, theirs)), max(difference, abs(ours - theirs))
        rounding = ROUNDING * (sheets[p].perimeter + sheets[q].perimeter)
        if not wrong and abs(ours - theirs) > allowed + rounding:
            wrong = (
                f"side {k} of polygon {p} has length {ours!r}, but side {m} of polygon {q}, which joins the "
                f"same corners {a!r} and {b!r}, has {theirs!r}: more than the {tolerance.limit_text(allowed)}"
            )
    if wrong:
        raise UnequalLengths(wrong, difference)
    return [(some[0], some[1]) for some in found.values() if len(some) == 2]


def faced_alike(
    corners: Names, sheets: Sequence[Polygon], sides: Sequence[tuple[Side, Side]]
) -> list[Polygon]:
    """Reverse polygons such that glued sides run in opposite directions.

    Raises
    ------
    InvalidMetric
        The surface is not orientable.
    """
    neighbors: list[list[tuple[int, bool]]] = [[] for _ in sheets]
    for one, other in sides:
        against = _ends(corners, one) != _ends(corners, other)
        p, q = one[0], other[0]
        alike = against == (sheets[p].turned == sheets[q].turned)
        neighbors[p].append((q, alike))
        neighbors[q].append((p, alike))
    over: list[bool | None] = [None] * len(sheets)
    for begin in range(len(sheets)):
        if over[begin] is None:
            over[begin], waiting = False, [begin]
            while waiting:
                p = waiting.pop()
                for q, alike in neighbors[p]:
                    wanted = over[p] == alike
                    if over[q] is None:
                        over[q] = wanted
                        waiting.append(q)
                    elif over[q] != wanted:
                        raise InvalidMetric(
                            "the polygons make a surface with one side, not a sphere: a path from "
                            f"polygon {begin} to polygon {q} arrives face up, and another face down"
                        )
    return [sheet.turned_over() if flip else sheet for sheet, flip in zip(sheets, over, strict=True)]


def check_together(corners: Names, vertices: Sequence[Indices]) -> None:
    """Raise InvalidMetric if corners with the same name became different vertices."""
    first: dict[Hashable, tuple[int, int]] = {}
    for p, (names, own) in enumerate(zip(corners, vertices, strict=True)):
        for name, vertex in zip(names, own.tolist(), strict=True):
            q, same = first.setdefault(name, (p, vertex))
            if vertex != same:
                raise InvalidMetric(f"the corners {name!r} of polygons {q} and {p} do not meet at one vertex")


def _ends(corners: Names, side: Side) -> tuple[Hashable, Hashable]:
    p, k = side
    return corners[p][k], corners[p][(k + 1) % len(corners[p])]


def _length(sheet: Polygon, k: int) -> float:
    """Length of the k-th side in the given order."""
    return float(sheet.sides[(-k - 1 if sheet.turned else k) % sheet.n])
