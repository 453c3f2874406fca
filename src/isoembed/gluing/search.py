"""Enumeration of the edge-to-edge gluings of a polygon to a sphere."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.gluing.polygon import Polygon
from isoembed.gluing.thresholds import GLUING
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
    """Edge-to-edge gluings of a polygon to a sphere: each side is glued to another of its length.

    The sphere leaves no pairs that cross: with 2 m sides of one length there are Catalan(m) gluings.  Those
    of a boundary stretch are found from those of the two stretches into which the partner of its first side
    divides it, and only the convex ones are kept, stretch by stretch.

    Parameters
    ----------
    polygon : array_like, shape (n, 2)
        A side in the sense of the gluing runs from one given corner to the next; corners may be flat.
    convex : bool
        Leave out gluings in which more than a full angle comes together at a vertex, which are metrics of no
        convex polyhedron.
    tolerance : float, optional
        As of `glue`.
    curvature, model : float and str
        Of the polygon, as of `glue`.

    Returns
    -------
    list
        Each the ``sides`` of `glue`, for ``glue([polygon], sides)``, in lexicographic order.  Gluings that a
        symmetry of the polygon takes into each other are all there.

    Raises
    ------
    InvalidMetric
        The polygon is invalid.
    InvalidParameter
        As `glue`, of the tolerance.

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
    most = 2 * np.pi + GLUING.full_angle + 4 * (tolerance or 0.0) / lengths.min() if convex else np.inf
    # By stretch of sides i .. j - 1: its gluings, and the angles that its two ends are glued to in between.
    known: dict[tuple[int, int], list[tuple[Pairs, float]]] = {(i, i): [((), 0.0)] for i in range(n + 1)}
    for size in range(2, n + 1, 2):
        for i in range(n - size + 1):
            j = i + size
            ends = angles[i] + (angles[j % n] if size < n else 0.0)
            found = known[i, j] = []
            for k in range(i + 1, j, 2):
                if abs(lengths[i] - lengths[k]) > allowed.between(0, 0, (lengths[i], lengths[k])):
                    continue
                for beyond, rest in known[k + 1, j]:
                    between = rest + angles[k + 1] if k + 1 < j else 0.0
                    if ends + between <= most:
                        found += [((*within, (i, k), *beyond), between) for within, _ in known[i + 1, k]]
    every = [sorted(_as_given(pair, sheet) for pair in pairs) for pairs, _ in known.get((0, n), [])]
    return [[((0, i), (0, k)) for i, k in pairs] for pairs in sorted(every)]


def _as_given(pair: tuple[int, int], sheet: Polygon) -> tuple[int, int]:
    """The sides by their numbers in the order of the corners as given."""
    i, k = ((-1 - side) % sheet.n for side in pair) if sheet.turned else pair
    return min(i, k), max(i, k)
