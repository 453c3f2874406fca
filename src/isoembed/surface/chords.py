"""Lengths of chords from lengths of geodesics, to the order of the curvature."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.shape_operator import normal_curvatures, shape_operators

TINY = float(np.finfo(np.float64).tiny)


def chord_lengths(
    triangulation: Triangulation,
    vertices: Floats,
    lengths: Floats,
    operators: Floats | None = None,
    space: Space = EUCLIDEAN,
) -> Floats:
    """Distances in space between the ends of geodesics of a smooth surface.

    A geodesic of length l has the surface's normal curvature kappa for its own.  Its chord is
    ``l (1 - kappa^2 l^2 / 24 + ...)``; here it is that of a circle, ``2 sin(kappa l / 2) / kappa``, with the
    mean of kappa at the two ends.  What is left is of fourth order in l, relative to it, with the derivatives
    of kappa and the torsion; on spheres nothing is.  In space of curvature k it is the c of
    ``sn(c / 2) = sn_m(l / 2)``, m = kappa^2 + k being the curvature of the sphere that has the circle for an
    equator.

    Lengths that geodesics measure are not those of the polyhedron inscribed in the surface.  Where K > 0, the
    polyhedron that has them is about as far from the surface as that bulges out of the faces; where K < 0,
    rough differences from the chords are blown up, and there may be none near the surface at all.  So correct
    the lengths with a first, smooth solution, and embed again.  Where the surface has K < 0 and is strongly
    curved, what this leaves may be too much, too.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
        Near the surface, such as an embedding of the geodesic lengths.
    lengths : ndarray, shape (E,)
        Of the geodesics.
    operators : ndarray, shape (V, 3, 3), optional
        The `shape_operators`, where they are at hand.
    space : Space
        In which the vertices are.

    Returns
    -------
    ndarray, shape (E,)
    """
    B = shape_operators(triangulation, vertices, space=space) if operators is None else operators
    kappa = normal_curvatures(triangulation, vertices, B, space)
    # Beyond half a circle no chord is longer.
    if space.is_euclidean:
        return lengths * np.sinc(np.clip(kappa * lengths / (2 * np.pi), -0.5, 0.5))
    m = kappa**2 + space.curvature
    turn = np.sqrt(np.abs(m)) * lengths / 2
    ratio = np.where(m > 0, np.sinc(np.minimum(turn / np.pi, 0.5)), np.sinh(turn) / np.maximum(turn, TINY))
    return space.arc(np.where(turn > 0, ratio, 1.0) * lengths)
