"""Flexibility: infinitesimal flexes of triangulated surfaces, and their finite extension.

Floats prove neither that a surface flexes nor that it does not: a motion that was followed is one along which
the lengths were kept to rounding, and one that could not be followed is not shown to be of first order only.
"""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import edge_rows, length_residuals

MOST_VERTICES = 300
"""Largest number of vertices for which motions are sought: J is decomposed as a dense matrix."""

STEPS_TRIED = (0.02, 0.005, 0.001)
"""Steps of the vertex that moves farthest, in mean edge lengths, tried in turn: where a path bends, Newton's
method stays on it in short steps only."""

STEPS = 10

KEPT = 1e-12
"""Change of the lengths that may be rounding, in mean edge lengths; also the least singular value of J that
is not rounding, as its rows have unit entries."""


def described_flex(triangulation: Triangulation, surface: Projected, lengths: Floats) -> str | None:
    """Description of how a surface in Euclidean space flexes, as far as floats tell; None if it does not.

    Parameters
    ----------
    triangulation : Triangulation
    surface : Projected
    lengths : ndarray, shape (E,)
        That the surface has.
    """
    x = surface.vertices
    if len(x) > MOST_VERTICES or not surface.space.is_euclidean:
        return None
    motions = _infinitesimal_flexes(triangulation, surface, lengths)
    if not len(motions):
        return None
    unit = float(lengths.mean())
    if len(motions) > 1:
        return f"{len(motions)} independent motions of its vertices change no length to first order"
    for step in STEPS_TRIED:
        missed, arrived = _followed(triangulation, surface, lengths, motions[0], step)
        if arrived:
            return (
                "the surface is flexible, as far as floats tell: a motion was followed until a vertex had "
                f"moved by {step * STEPS:g} mean edge lengths, and all lengths were kept to "
                f"{max(missed / unit, 1e-16):.0e} of the mean edge length"
            )
    return (
        "a motion of its vertices changes no length to first order, as far as floats tell, and could not be "
        f"followed: where a vertex has moved by {step:g} mean edge lengths, a length differs by "
        f"{missed / unit:.0e} of the mean edge length"
    )


def _matrix(triangulation: Triangulation, x: Floats, lengths: Floats) -> Floats:
    """J, (E, 3 V)."""
    rows, (a, b), edges = edge_rows(triangulation, x, lengths), triangulation.edges.T, np.arange(len(lengths))
    J = np.zeros((len(lengths), len(x), 3))
    J[edges, a], J[edges, b] = rows, -rows
    return J.reshape(len(lengths), -1)


def _infinitesimal_flexes(triangulation: Triangulation, surface: Projected, lengths: Floats) -> Floats:
    """A basis of the motions that change no length to first order, (k, 3 V), rigid ones apart."""
    held = np.vstack([_matrix(triangulation, surface.vertices, lengths), surface.rigid_motions().T])
    sizes, motions = np.linalg.svd(held)[1:]
    return motions[sizes <= KEPT]


def _followed(
    triangulation: Triangulation, surface: Projected, lengths: Floats, motion: Floats, step: float
) -> tuple[float, bool]:
    """Most that a length was off where steps of a motion ended, and whether all of them kept the lengths."""
    x, unit, worst = surface.vertices, float(lengths.mean()), 0.0
    for _ in range(STEPS):
        tangent = motion / np.linalg.norm(motion)
        farthest = np.linalg.norm(tangent.reshape(-1, 3), axis=1).max()
        y = x + (step * unit / farthest * tangent).reshape(-1, 3)
        missed = np.inf
        for _ in range(10):  # of Gauss and Newton, across the motion
            r = length_residuals(triangulation, y, lengths)
            missed = float(np.abs(r).max())
            if not KEPT * unit / 10 < missed < unit:
                break
            rigid = Projected.of(surface.space, y).rigid_motions()
            across = np.vstack([_matrix(triangulation, y, lengths), rigid.T, tangent])
            y = y - np.linalg.lstsq(across, np.concatenate([r, np.zeros(7)]), rcond=None)[0].reshape(-1, 3)
        worst = max(worst, missed)
        if not missed <= KEPT * unit:
            return worst, False
        x, motion = y, (y - x).ravel()
    return worst, True
