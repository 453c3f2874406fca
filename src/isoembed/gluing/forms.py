"""Zipped polygons, pita forms and D-forms.

Zipping a convex outline shut from a boundary point yields a pita form; gluing two convex outlines of equal
perimeter yields a D-form.  The total angle at every point is at most 2 pi, so both are convex metrics.

References
----------
Wills, D-forms: 3D forms from two 2D sheets, Bridges 2006.  Demaine and O'Rourke, Geometric folding
algorithms, 2007, part III.
"""

from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gluing.net import Net, glue
from isoembed.gluing.outlines import Curve, Ellipse, Stadium, check_count, check_fraction, inscribed
from isoembed.gluing.polygon import Polygon, is_number, points_of_the_plane
from isoembed.space.models import Model

Outline = Curve | ArrayLike
"""A curve, replaced by an inscribed polygon of n equal sides, or a polygon, used as it is."""


def zipped(polygon: ArrayLike, at: float, *, curvature: float = 0.0, model: Model = "ambient") -> Net:
    """Zip a polygon shut: its boundary is glued to itself in both directions from a boundary point.

    Parameters
    ----------
    polygon : array_like, shape (n, 2)
        Corners, in convex position for a convex metric.
    at : float
        Start of the zip, in corners from 0 to n: 2.5 is the midpoint of side 2.
    curvature, model : float and str
        See `glue`.

    Raises
    ------
    InvalidMetric
        See `glue`.
    InvalidParameter
        `at` is out of range.
    """
    n = len(points_of_the_plane(polygon, "the polygon"))
    if not is_number(at) or not 0 <= at <= n:
        raise InvalidParameter(f"at is {at!r}, not a position on the boundary from 0 to {n}")
    return glue([polygon], [((0, at, at), (0, at, at))], curvature=curvature, model=model)


def pita(outline: Outline, at: float = 0.0, n: int = 100) -> Net:
    """Zip an outline shut.

    Parameters
    ----------
    outline : Ellipse, Stadium or array_like, shape (m, 2)
        A curve is replaced by the inscribed polygon of n equal sides with a corner at the start of the zip; a
        polygon is used as it is.
    at : float
        Start of the zip, as a fraction of the perimeter from the start of the outline, in [0, 1).
    n : int
        Number of sides for a curve.

    Raises
    ------
    InvalidMetric
        See `glue`.
    InvalidParameter
        `at` or `n` is out of range.
    """
    return zipped(*_polygon(outline, "at", at, n))


def dform(first: Outline, second: Outline, offset: float = 0.0, n: int = 100) -> Net:
    """Glue two outlines along their entire boundaries.

    Parameters
    ----------
    first, second : Ellipse, Stadium or array_like, shape (m, 2)
        Outlines, as in `pita`.  The second is scaled to the perimeter of the first.
    offset : float
        Point of the second outline glued to the start of the first, as a fraction of the perimeter, in
        [0, 1).
    n : int
        Number of sides for a curve.

    Raises
    ------
    InvalidMetric
        See `glue`.
    InvalidParameter
        `offset` or `n` is out of range.
    """
    one, start = _polygon(first, "offset", 0.0, n)
    other, meets = _polygon(second, "offset", offset, n)
    scale = Polygon.of(one, 0).perimeter / Polygon.of(other, 1).perimeter
    return glue([one, scale * other], [((0, start, start), (1, meets, meets))])


def _polygon(outline: Outline, name: str, part: float, n: int) -> tuple[Floats, float]:
    """Outline as a polygon, and the position at the given fraction of the perimeter."""
    check_fraction(name, part)
    if isinstance(outline, Ellipse | Stadium):
        check_count(n)
        return inscribed(outline, int(n), float(part)), 0.0
    corners = points_of_the_plane(outline, "the outline")
    polygon = Polygon.of(corners, 0)
    position = polygon.position((-part if polygon.turned else part) * polygon.perimeter)
    return corners, -position % polygon.n if polygon.turned else position
