"""Acceptance of surfaces as realizations: thresholds on residuals and on distances between realizations.

A surface says `converged` by its own tolerance.  What the searches ask besides is here.
"""

from isoembed.embedding.embedding import Embedding

REALIZED = 1e-11  # mean edge lengths: the largest residual of a realization
PLACED = 1e-10  # mean edge lengths: residual asked of convex polyhedra, and of surfaces that end a search
NEARLY = 1e-6  # mean edge lengths: near a realization, Newton's method does not get lost from here
SAME = 1e-7  # mean edge lengths: realizations within this distance are the same


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
