"""The convexity routine (paper, section 2.2): reflect inverted and partially inverted vertices."""

from collections.abc import Callable

import numpy as np

from isoembed.aim.anneal import Annealed
from isoembed.arrays import Floats, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.convexity import concave_edges, inverted_vertices, partially_inverted_vertices

CORRECTED, PRINTED = -1.0, 1.0


def crumpled_vertices(triangulation: Triangulation, vertices: Floats) -> tuple[Mask, Mask]:
    """Inverted and partially inverted vertices, two masks of shape (V,)."""
    concave = concave_edges(triangulation, vertices)
    return inverted_vertices(triangulation, concave), partially_inverted_vertices(triangulation, concave)


def reflected(triangulation: Triangulation, vertices: Floats, which: Mask, sign: float = CORRECTED) -> Floats:
    """Reflect vertices in the mean of their neighbors.

    With ``v_diff = v - v_avg`` the paper prints ``v + 2 v_diff``, which pushes an inverted vertex further
    in; ``v - 2 v_diff`` is its mirror image and turns it out.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    which : ndarray of bool, shape (V,)
    sign : {-1, 1}
        `CORRECTED`, or `PRINTED` for the paper's formula.

    Returns
    -------
    ndarray, shape (V, 3)
    """
    mean = (triangulation.adjacency @ vertices) / triangulation.degrees[:, None]
    return np.where(which[:, None], vertices + sign * 2 * (vertices - mean), vertices)


def reflect_and_anneal(
    triangulation: Triangulation,
    annealed: Annealed,
    relax: Callable[[Floats], Annealed],
) -> Annealed:
    """Reflect the crumpled vertices, anneal, and keep the result only if it is better.

    Parameters
    ----------
    triangulation : Triangulation
    annealed : Annealed
        The surface so far.
    relax : callable
        Function that anneals given vertices to the same lengths.

    Returns
    -------
    Annealed
        The surface with fewer crumpled vertices, if it converged or its residual did not grow; otherwise
        `annealed`.
    """
    inverted, partial = crumpled_vertices(triangulation, annealed.vertices)
    if not (inverted | partial).any():
        return annealed
    candidate = relax(reflected(triangulation, annealed.vertices, inverted | partial))
    inverted_after, partial_after = crumpled_vertices(triangulation, candidate.vertices)
    fewer = (inverted_after | partial_after).sum() < (inverted | partial).sum()
    sound = candidate.converged or candidate.residual <= annealed.residual
    return candidate if fewer and sound else annealed
