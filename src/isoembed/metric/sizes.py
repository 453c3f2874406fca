"""How large triangles of the sphere and of the hyperbolic plane can be."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.space import Space
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class SizeThresholds:
    """Thresholds of the sizes of triangles."""

    longest: float = threshold(
        70.0,
        "radii of curvature",
        "Sides in the hyperbolic plane: angles between longer ones are lost beside a full turn.",
    )


SIZES = SizeThresholds()


def check_sizes(space: Space, faces: Indices, lengths: Floats, name: Callable[[int], str]) -> None:
    """Refuse triangles that are too large for the curvature.

    On the sphere sides are shorter than half a great circle, and perimeters than a whole one.

    Parameters
    ----------
    space : Space
    faces : ndarray of int, shape (F, 3)
    lengths : ndarray, shape (F, 3)
        Of each half-edge.
    name : callable
        What a half-edge is called.

    Raises
    ------
    InvalidMetric
        The message names the first side, or else the first triangle.
    """
    if space.is_euclidean:
        return
    sides = space.root * lengths
    spherical = space.curvature > 0
    beyond = ~(sides < (math.pi if spherical else SIZES.longest))
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
            f"{length}, which is {sides.flat[h]:.6g} radii of curvature: beyond {SIZES.longest:g} floats do "
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
