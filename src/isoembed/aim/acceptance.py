"""Acceptance of surfaces as realizations: thresholds on residuals and on distances between realizations.

`Embedding.converged` refers to the tolerance of the surface.  The searches use these thresholds in addition.
"""

import math

from isoembed.embedding.embedding import Embedding

REALIZED = 1e-11  # mean edge lengths; largest residual of a realization
PLACED = 1e-10  # mean edge lengths; largest residual of a convex polyhedron, or at the end of a search
NEARLY = 1e-6  # mean edge lengths; residual from which Newton's method converges reliably
SAME = 1e-7  # mean edge lengths; distance within which realizations are always identical


def is_accepted(surface: Embedding) -> bool:
    """Whether the residual is within the tolerance, or at the level of rounding if that is tighter."""
    return surface.residual <= max(surface.tolerance, REALIZED)


def is_exact(surface: Embedding) -> bool:
    """Whether the residual is at the level of rounding, even if the tolerance is looser."""
    return is_accepted(surface) and surface.residual <= PLACED


def is_near(surface: Embedding) -> bool:
    """Whether the surface is near a realization, or is one."""
    return surface.residual < NEARLY


def is_realization(surface: Embedding) -> bool:
    """Whether the surface counts among the realizations, however loose the tolerance is."""
    return surface.converged and is_near(surface)


def identical_within(residual: float) -> float:
    """Distance within which realizations with up to this residual are identical, in mean edge lengths.

    Halfway between two surfaces at distance d, the squares of the lengths are smaller by at most d^2 / 4.  If
    this is within the residuals, all surfaces between them have the lengths equally well: they are two
    approximations of a double root, as for a rigid surface with an infinitesimal flex.
    """
    return max(SAME, math.sqrt(10 * residual))


def are_identical(one: Embedding, other: Embedding) -> bool:
    """Whether two surfaces are the same realization, as far as their residuals tell.

    The residuals of fits, which are no realizations, tell nothing.
    """
    return one.distance(other) <= identical_within(min(max(one.residual, other.residual), PLACED))
