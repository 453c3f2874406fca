"""Functions of the direction projected onto harmonics, up to the degree where only rounding is left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import trimmed
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class ProjectionThresholds:
    """Thresholds of the projection of functions onto harmonics."""

    first_degree: int = threshold(16, "count", "Degree in which a function is sought first; it is doubled.")
    highest_degree: int = threshold(
        128, "count", "Degree above which harmonics of a function are not sought."
    )
    rounding: float = threshold(1e-15, "relative", "Rounding in the harmonics of a function.")
    exact: float = threshold(1e-12, "relative", "Miss of a function below which it is exact.")
    missed: float = threshold(1e-6, "relative", "Miss of a function above which it is not smooth.")
    directions: int = threshold(200, "count", "Directions at which the miss of a function is measured.")


PROJECTION = ProjectionThresholds()


@dataclass(frozen=True)
class Projection:
    """Functions of the direction in harmonics.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size, c)
    misfit : float
        Root mean square, in the function's unit, of what is missed at directions that were not used.
    """

    harmonics: Harmonics
    coefficients: Floats
    misfit: float


def project(function: Callable[[Floats], Floats], what: str) -> Projection:
    """The projection of functions onto harmonics.

    Parameters
    ----------
    function : callable
        Takes unit vectors u (n, 3) and returns values (n, c); smooth.
    what : str
        For messages.

    Raises
    ------
    InvalidParameter
        Harmonics up to degree 128 miss it by more than a millionth.
    """
    apart = fibonacci_directions(PROJECTION.directions)
    expected = function(apart)
    largest = float(np.linalg.norm(expected, axis=1).max())
    found: list[tuple[float, Projection]] = []
    degree = PROJECTION.first_degree
    while degree <= PROJECTION.highest_degree:
        harmonics = Harmonics(degree, degree)
        transform = SphereTransform(harmonics, degree + 1, 2 * degree + 2)
        coefficients = transform.analysis(function(transform.u))
        sizes = np.linalg.norm(coefficients, axis=1)
        sizes /= np.linalg.norm(sizes)
        tail = float(sizes[harmonics.labels[0] > 3 * degree // 4].max())
        coefficients, harmonics = trimmed(coefficients, harmonics, sizes > PROJECTION.rounding / 4.0)
        errors = np.linalg.norm(harmonics.values(apart) @ coefficients - expected, axis=1)
        missed = float(errors.max()) / largest
        if missed <= PROJECTION.missed:
            found.append((missed, Projection(harmonics, coefficients, float(np.sqrt(np.mean(errors**2))))))
            if tail <= PROJECTION.rounding and missed <= PROJECTION.exact:
                return found[-1][1]
        degree *= 2
    if not found:
        raise InvalidParameter(
            f"{what} is not smooth enough for harmonics: those of degree {PROJECTION.highest_degree} are "
            f"still {tail:.3g} of it, and miss it by {missed:.3g}; fit points instead"
        )
    # Harmonics that come no nearer would be noise, and their second derivatives loud noise.
    enough = 2.0 * min(missed for missed, _ in found)
    return next(projection for missed, projection in found if missed <= enough)
