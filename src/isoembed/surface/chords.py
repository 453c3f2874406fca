"""Chord lengths from geodesic lengths, to second order in the curvature."""

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

    The curvature of a geodesic is the normal curvature kappa of the surface.  The chord of a geodesic of
    length l is ``l (1 - kappa^2 l^2 / 24 + ...)``; it is approximated by that of a circle,
    ``2 sin(kappa l / 2) / kappa``, with the mean of kappa at the two ends.  The relative error is of fourth
    order in l, with the derivatives of kappa and the torsion; it vanishes on spheres.  In space of curvature
    k the chord is the c of ``sn(c / 2) = sn_m(l / 2)``, where m = kappa^2 + k is the curvature of the sphere
    with the circle as its equator.

    Geodesic lengths are not the edge lengths of the polyhedron inscribed in the surface.  Where K > 0, the
    distance of the polyhedron with these lengths from the surface is about the height of the surface over
    the faces; where K < 0, rough differences from the chords are amplified, and there may be no such
    polyhedron near the surface.  In that case, correct the lengths with a first, smooth solution and embed
    again.  Where K < 0 and the surface is strongly curved, the remaining error may still be too large.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
        Points near the surface, such as an embedding of the geodesic lengths.
    lengths : ndarray, shape (E,)
        Geodesic lengths.
    operators : ndarray, shape (V, 3, 3), optional
        The `shape_operators`, if known.
    space : Space
        Ambient space.

    Returns
    -------
    ndarray, shape (E,)
    """
    B = shape_operators(triangulation, vertices, space=space) if operators is None else operators
    kappa = normal_curvatures(triangulation, vertices, B, space)
    # The chord is longest at half a circle.
    if space.is_euclidean:
        return lengths * np.sinc(np.clip(kappa * lengths / (2 * np.pi), -0.5, 0.5))
    m = kappa**2 + space.curvature
    turn = np.sqrt(np.abs(m)) * lengths / 2
    ratio = np.where(m > 0, np.sinc(np.minimum(turn / np.pi, 0.5)), np.sinh(turn) / np.maximum(turn, TINY))
    return space.arc(np.where(turn > 0, ratio, 1.0) * lengths)
