"""Projection of functions onto spherical harmonics, to rounding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import ROUNDING, trimmed

HIGHEST_DEGREE = 128
DIRECTIONS = 200  # number of points at which the misfit is measured


@dataclass(frozen=True)
class Projection:
    """Harmonic expansion of functions of the direction.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size, c)
    misfit : float
        Root-mean-square error at directions other than the nodes, in the unit of the function.
    """

    harmonics: Harmonics
    coefficients: Floats
    misfit: float


def project(function: Callable[[Floats], Floats], subject: str) -> Projection:
    """Project functions onto harmonics.

    Parameters
    ----------
    function : callable
        Smooth function that takes unit vectors u (n, 3) and returns values (n, c).
    subject : str
        Name of the function, for messages.

    Raises
    ------
    InvalidParameter
        The relative error exceeds 1e-6 with harmonics up to degree 128.
    """
    apart = fibonacci_directions(DIRECTIONS)
    expected = function(apart)
    largest = float(np.linalg.norm(expected, axis=1).max())
    found: list[tuple[float, Projection]] = []
    degree = 16  # initial degree, which is doubled
    while degree <= HIGHEST_DEGREE:
        harmonics = Harmonics(degree, degree)
        transform = SphereTransform(harmonics, degree + 1, 2 * degree + 2)
        coefficients = transform.analysis(function(transform.u))
        sizes = np.linalg.norm(coefficients, axis=1)
        sizes /= np.linalg.norm(sizes)
        tail = float(sizes[harmonics.labels[0] > 3 * degree // 4].max())
        coefficients, harmonics = trimmed(coefficients, harmonics, sizes > ROUNDING / 4.0)
        errors = np.linalg.norm(harmonics.values(apart) @ coefficients - expected, axis=1)
        error = float(errors.max()) / largest
        if error <= 1e-6:  # otherwise the function is not smooth
            found.append((error, Projection(harmonics, coefficients, float(np.sqrt(np.mean(errors**2))))))
            if tail <= ROUNDING and error <= 1e-12:
                return found[-1][1]
        degree *= 2
    if not found:
        raise InvalidParameter(
            f"{subject} is not smooth enough for harmonics: those of degree {HIGHEST_DEGREE} still "
            f"contribute {tail:.3g}, and the error is {error:.3g}; fit points instead"
        )
    # Further harmonics would be noise, which second derivatives amplify.
    enough = 2.0 * min(error for error, _ in found)
    return next(projection for error, projection in found if error <= enough)
