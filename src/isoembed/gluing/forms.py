"""Zipped polygons, pita forms and D-forms.

Zipping a convex outline shut from one of its points makes a pita form, gluing two convex outlines of equal
perimeter a D-form: every point gets at most a full angle, so that both are convex metrics.

References
----------
Wills, D-forms: 3D forms from two 2D sheets, Bridges 2006.  Demaine and O'Rourke, Geometric folding
algorithms, 2007, part III.
"""

from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gluing.net import Net, glue
from isoembed.gluing.outlines import Curve, Ellipse, Stadium, check_count, inscribed
from isoembed.gluing.polygon import Polygon, is_number, points_of_the_plane
from isoembed.space.models import Model

Outline = Curve | ArrayLike
"""A curve, which becomes an inscribed polygon of n equal sides, or a polygon, which stays as it is."""


def zipped(polygon: ArrayLike, at: float, *, curvature: float = 0.0, model: Model = "ambient") -> Net:
    """Polygon zipped shut: its boundary is glued to itself, both ways from one of its points.

    Parameters
    ----------
    polygon : array_like, shape (n, 2)
        Convex, if the metric is to be.
    at : float
        Where the zip begins, counted in corners, from 0 to n: 2.5 is the middle of side 2.
    curvature, model : float and str
        As of `glue`.

    Raises
    ------
    InvalidMetric
        As `glue`.
    InvalidParameter
        `at` is out of range.
    """
    n = len(points_of_the_plane(polygon, "the polygon"))
    if not is_number(at) or not 0 <= at <= n:
        raise InvalidParameter(f"at is {at!r}, not a position on the boundary from 0 to {n}")
    return glue([polygon], [((0, at, at), (0, at, at))], curvature=curvature, model=model)


def pita(outline: Outline, at: float = 0.0, n: int = 100) -> Net:
    """Outline zipped shut.

    Parameters
    ----------
    outline : Ellipse, Stadium or array_like, shape (m, 2)
        A curve becomes the inscribed polygon of n equal sides that has a corner where the zip begins; a
        polygon stays as it is.
    at : float
        Where the zip begins: this part of the perimeter from the beginning of the outline, from 0 to below 1.
    n : int
        Sides of a curve.

    Raises
    ------
    InvalidMetric
        As `glue`.
    InvalidParameter
        `at` or `n` is out of range.
    """
    return zipped(*_polygon(outline, "at", at, n))


def dform(first: Outline, second: Outline, offset: float = 0.0, n: int = 100) -> Net:
    """Two outlines glued all around, back to back.

    Parameters
    ----------
    first, second : Ellipse, Stadium or array_like, shape (m, 2)
        As of `pita`.  The second is scaled to the perimeter of the first.
    offset : float
        The beginning of the first meets the point of the second at this part of its perimeter, from 0 to
        below 1.
    n : int
        Sides of a curve.

    Raises
    ------
    InvalidMetric
        As `glue`.
    InvalidParameter
        `offset` or `n` is out of range.
    """
    one, start = _polygon(first, "offset", 0.0, n)
    other, meets = _polygon(second, "offset", offset, n)
    scale = Polygon.of(one, 0).perimeter / Polygon.of(other, 1).perimeter
    return glue([one, scale * other], [((0, start, start), (1, meets, meets))])


def _polygon(outline: Outline, name: str, part: float, n: int) -> tuple[Floats, float]:
    """An outline as a polygon, and the position on it that this part of the perimeter is behind."""
    if not is_number(part) or not 0 <= part < 1:
        raise InvalidParameter(f"{name} is {part!r}, not a part of the perimeter from 0 to below 1")
    if isinstance(outline, Ellipse | Stadium):
        check_count("n", n)
        return inscribed(outline, int(n), float(part)), 0.0
    corners = points_of_the_plane(outline, "the outline")
    polygon = Polygon.of(corners, 0)
    position = polygon.position((-part if polygon.turned else part) * polygon.perimeter)
    return corners, -position % polygon.n if polygon.turned else position
