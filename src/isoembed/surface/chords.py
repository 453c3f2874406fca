"""Chords of the geodesics of a surface, which are the edges of an inscribed polyhedron."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.shape_operator import normal_curvatures, shape_operators


def chord_lengths(
    triangulation: Triangulation, vertices: Floats, lengths: Floats, operators: Floats | None = None
) -> Floats:
    """Distances in R^3 between the ends of geodesics of a smooth surface.

    A geodesic of length l has the surface's normal curvature kappa for its own.  Its chord is
    ``l (1 - kappa^2 l^2 / 24 + ...)``; here it is that of a circle, ``2 sin(kappa l / 2) / kappa``, with the
    mean of kappa at the two ends.  What is left is of fourth order in l, relative to it, with the derivatives
    of kappa and the torsion; on spheres nothing is.

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

    Returns
    -------
    ndarray, shape (E,)
    """
    B = shape_operators(triangulation, vertices) if operators is None else operators
    kappa = normal_curvatures(triangulation, vertices, B)
    # Beyond half a circle no chord is longer.
    return lengths * np.sinc(np.clip(kappa * lengths / (2 * np.pi), -0.5, 0.5))
