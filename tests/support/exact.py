"""Polygons of the plane in exact arithmetic."""

from fractions import Fraction
from itertools import combinations


def is_simple(points):
    """Whether the sides of a closed polygon meet in common corners only: every pair, in rational numbers."""
    corners = [tuple(map(Fraction, point)) for point in points.tolist()]
    n = len(corners)
    sides = [(corners[k], corners[(k + 1) % n]) for k in range(n)]
    for (i, (a, b)), (j, (c, d)) in combinations(enumerate(sides), 2):
        if any(max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]) for k in (0, 1)):
            continue
        if j - i in (1, n - 1):
            p, q, r = (a, b, d) if j - i == 1 else (c, d, b)
            if _turn(p, q, r) == 0 and sum((q[k] - p[k]) * (r[k] - q[k]) for k in (0, 1)) < 0:
                return False
        elif _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0:
            return False
    return True


def _turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
