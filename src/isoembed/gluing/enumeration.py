"""Enumeration of the edge-to-edge gluings of a polygon to a sphere."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.gluing.polygon import Polygon
from isoembed.gluing.tolerance import Tolerance
from isoembed.space import Space
from isoembed.space.models import Model

Pairs = tuple[tuple[int, int], ...]
Sides = list[tuple[tuple[int, int], tuple[int, int]]]


def edge_gluings(
    polygon: ArrayLike,
    *,
    convex: bool = True,
    tolerance: float | None = None,
    curvature: float = 0.0,
    model: Model = "ambient",
) -> list[Sides]:
    """Enumerate the edge-to-edge gluings of a polygon to a sphere; glued sides have equal lengths.

    On a sphere the pairs do not cross: 2 m sides of equal length have Catalan(m) gluings.  Dynamic
    programming: the gluings of a part of the boundary combine those of the two parts into which the mate of
    its first side divides it, and only convex ones are kept at every step.

    Parameters
    ----------
    polygon : array_like, shape (n, 2)
        Corners; each side runs from one given corner to the next, and corners may be flat.
    convex : bool
        Whether to omit gluings with a total angle above 2 pi at a vertex, which are not metrics of convex
        polyhedra.
    tolerance : float, optional
        See `glue`.
    curvature, model : float and str
        Curvature and model of the polygon; see `glue`.

    Returns
    -------
    list
        Arguments ``sides`` for ``glue([polygon], sides)``, in lexicographic order.  Gluings equivalent by a
        symmetry of the polygon are all included.

    Raises
    ------
    InvalidMetric
        The polygon is invalid.
    InvalidParameter
        The tolerance is invalid; see `glue`.

    References
    ----------
    Lubiw and O'Rourke, When can a polygon fold to a polytope?, 1996.

    Examples
    --------
    >>> square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> edge_gluings(square)
    [[((0, 0), (0, 1)), ((0, 2), (0, 3))], [((0, 0), (0, 3)), ((0, 1), (0, 2))]]
    """
    sheet = Polygon.of(polygon, 0, Space(curvature), model)
    allowed = Tolerance.of([sheet], tolerance)
    n, lengths, angles = sheet.n, sheet.sides, sheet.angles
    rounding = 1e-9  # radians, of the sum of angles at a vertex
    max_angle = 2 * np.pi + rounding + 4 * (tolerance or 0.0) / lengths.min() if convex else np.inf
    # By range of sides i .. j - 1: its gluings, and the angles glued between its two ends.
    parts: dict[tuple[int, int], list[tuple[Pairs, float]]] = {(i, i): [((), 0.0)] for i in range(n + 1)}
    for size in range(2, n + 1, 2):
        for i in range(n - size + 1):
            j = i + size
            ends = angles[i] + (angles[j % n] if size < n else 0.0)
            found = parts[i, j] = []
            for k in range(i + 1, j, 2):
                if abs(lengths[i] - lengths[k]) > allowed.between(0, 0, (lengths[i], lengths[k])):
                    continue
                for beyond, rest in parts[k + 1, j]:
                    between = rest + angles[k + 1] if k + 1 < j else 0.0
                    if ends + between <= max_angle:
                        found += [((*within, (i, k), *beyond), between) for within, _ in parts[i + 1, k]]
    every = [sorted(_in_original_order(pair, sheet) for pair in pairs) for pairs, _ in parts.get((0, n), [])]
    return [[((0, i), (0, k)) for i, k in pairs] for pairs in sorted(every)]


def _in_original_order(pair: tuple[int, int], sheet: Polygon) -> tuple[int, int]:
    """Indices of the sides in the given order of the corners."""
    i, k = ((-1 - side) % sheet.n for side in pair) if sheet.turned else pair
    return min(i, k), max(i, k)
