"""Triangle inequality checks in the plane, the hyperbolic plane and on the sphere."""

import math
from collections.abc import Callable
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.space import Space

MOST_ERRORS = 4.0  # standard deviations, by which errors may change a length
MOST_TURNS = 1000  # changes of one triangle
LONGEST_SIDE = 70.0  # radii of curvature: angles between longer sides are lost beside a full turn


def check_triangles(
    faces: Indices, sides: Indices, lengths: Floats, space: Space, name: Callable[[int], str]
) -> None:
    """Refuse lengths that break the triangle inequality, or are too large for the curvature.

    On the sphere sides are shorter than half a great circle, and perimeters than a whole one.

    Parameters
    ----------
    faces : ndarray of int, shape (F, 3)
    sides : ndarray of int, shape (F, 3)
        Index of the length of each half-edge.
    lengths : ndarray, shape (n,)
    space : Space
    name : callable
        Name of a half-edge in messages.

    Raises
    ------
    InvalidMetric
        The message names the first triangle, or else the first side.
    """
    f = first_broken(sides, lengths, 0.0)
    if f >= 0:
        a, b, c = sorted(lengths[sides[f]].tolist())
        raise InvalidMetric(
            f"face {f} {faces[f].tolist()} breaks the triangle inequality: "
            f"its sides are {a!r}, {b!r} and {c!r}"
        )
    if not space.is_euclidean:
        _check_sizes(space, faces, lengths[sides], name)


def first_broken(face_edges: Indices, lengths: Floats, margin: float) -> int:
    """The first face that breaks the triangle inequality up to a share of its longest side, or -1."""
    broken = broken_triangles(face_edges, lengths, margin)
    return int(np.argmax(broken)) if broken.any() else -1


def broken_triangles(face_edges: Indices, lengths: Floats, margin: float = 0.0) -> Mask:
    """Faces that break the triangle inequality up to a share of their longest sides, shape (F,)."""
    a, b, c = (lengths[edges] for edges in face_edges.T)
    low, high = np.minimum(a, b), np.maximum(a, b)
    shortest, middle, longest = np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)
    # A difference of neighbors neither over- nor underflows.
    return cast(Mask, ~(longest - middle < shortest - margin * longest))


def too_large_triangles(space: Space, lengths: Floats) -> Mask:
    """Triangles with lengths (F, 3) that are too large for a curved space, shape (F,)."""
    sides = space.root * lengths
    if space.curvature > 0:
        return cast(Mask, ~((sides < math.pi).all(axis=1) & (sides.sum(axis=1) < 2 * math.pi)))
    return cast(Mask, ~(sides < LONGEST_SIDE).all(axis=1))


def within_inequalities(sides: Indices, lengths: Floats, errors: Floats) -> Floats:
    """Lengths nearest to those given that obey the triangle inequality in the plane, or nearly the nearest.

    Where a triangle breaks it, or is flat, its sides are changed in turn with others by the least sum of
    squares over their variances, so that the two shorter ones exceed the longest by its error, or by half of
    the shortest if that is less.

    Parameters
    ----------
    sides : ndarray of int, shape (F, 3)
        Index of the length of each half-edge.
    lengths, errors : ndarray, shape (n,)
        With standard deviations.

    Returns
    -------
    ndarray, shape (n,)
        The lengths as given, if changes of no more than `MOST_ERRORS` deviations do not do.
    """
    changed = lengths.copy()
    for _ in range(MOST_TURNS):
        f = first_broken(sides, changed, 0.0)
        if f < 0:
            return changed if (changed != lengths).any() else lengths
        three = sides[f][np.argsort(changed[sides[f]], kind="stable")]
        a, b, c = changed[three]
        variances = errors[three] ** 2
        excess = (c - b - a + min(errors[three[2]], a / 2)) / variances.sum()
        changed[three] += excess * variances * [1.0, 1.0, -1.0]
        if (np.abs(changed - lengths) > MOST_ERRORS * errors).any():
            break
    return lengths


def _check_sizes(space: Space, faces: Indices, lengths: Floats, name: Callable[[int], str]) -> None:
    sides = space.root * lengths
    spherical = space.curvature > 0
    beyond = ~(sides < (math.pi if spherical else LONGEST_SIDE))
    if beyond.any():
        h = int(np.argmax(beyond))
        length = f"{name(h)} has length {float(lengths.flat[h])!r}"
        if spherical:
            half = math.pi * space.radius
            raise InvalidMetric(
                f"{length}, not below {half:.9g}, half of a great circle of the sphere of curvature "
                f"{space.curvature:.9g}"
            )
        raise InvalidMetric(
            f"{length}, which is {sides.flat[h]:.6g} radii of curvature: beyond {LONGEST_SIDE:g} floats do "
            "not tell the angles of hyperbolic triangles from zero"
        )
    whole = ~(sides.sum(axis=1) < 2 * math.pi)
    if spherical and whole.any():
        f = int(np.argmax(whole))
        raise InvalidMetric(
            f"face {f} {faces[f].tolist()} has the perimeter {float(lengths[f].sum())!r}, not below "
            f"{2 * math.pi * space.radius:.9g}, a great circle of the sphere of curvature "
            f"{space.curvature:.9g}"
        )
