"""Models of hyperbolic and spherical space: ambient, projective and conformal coordinates.

Coordinates of a point X = (x, w): ``"ambient"`` is x; ``"conformal"`` is ``2 x / (1 + w)``, the Poincare
ball, with the sphere at infinity at radius 2 / sqrt(-k), or stereographic projection; ``"projective"`` is
``x / w``, the Klein ball, of radius 1 / sqrt(-k), or gnomonic projection, which map geodesics to straight
lines.  All of them are lengths, and tend to Cartesian coordinates as the curvature tends to zero.
"""

from typing import Literal

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.space.space import Space

Model = Literal["ambient", "conformal", "projective"]

MODELS: tuple[Model, ...] = ("conformal", "projective", "ambient")


def to_model(space: Space, x: Floats, model: Model) -> Floats:
    """Coordinates (..., 3) in a model of points x (..., 3)."""
    if model == "ambient" or space.is_euclidean:
        return x
    w = space.heights(x)
    return x * ((2 / (1 + w)) if model == "conformal" else 1 / w)[..., None]


def from_model(space: Space, p: Floats, model: Model) -> Floats:
    """Points x (..., 3) from coordinates (..., 3) in a model.

    Raises
    ------
    InvalidParameter
        The model is unknown, or a point is not in the ball, or on the sphere not in the open hemisphere about
        the origin; the message names the first.
    """
    if model not in MODELS:
        raise InvalidParameter(f"the model is {model!r}, none of {', '.join(MODELS)}")
    if space.is_euclidean:
        return p
    limit = radius_of(space, model)
    with np.errstate(over="ignore"):  # overflow counts as outside
        sizes = np.linalg.norm(p, axis=-1)
    outside = ~(sizes < limit)
    if outside.any():
        i = int(np.argmax(np.ravel(outside)))
        if not np.isfinite(np.ravel(sizes)[i]):
            raise InvalidParameter(f"point {i} is {p.reshape(-1, 3)[i].tolist()}, which is not finite")
        raise InvalidParameter(
            f"point {i} is {np.ravel(sizes)[i]:.9g} from the center of the {model} "
            f"model, whose boundary is at {limit:.9g}"
        )
    if model == "ambient":
        return p
    squares = np.einsum("...i,...i->...", p, p)
    if model == "conformal":
        return p / (1 + space.curvature * squares / 4)[..., None]
    return p / np.sqrt(1 + space.curvature * squares)[..., None]


def radius_of(space: Space, model: Model) -> float:
    """Radius of the ball that represents hyperbolic space, or a hemisphere, in a model."""
    if space.curvature < 0:
        return {"ambient": np.inf, "conformal": 2.0, "projective": 1.0}[model] * space.radius
    return {"ambient": 1.0, "conformal": 2.0, "projective": np.inf}[model] * space.radius
