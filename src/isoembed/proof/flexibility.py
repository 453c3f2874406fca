"""Flexibility: infinitesimal flexes of triangulated surfaces, and their finite extension.

Floating-point results prove neither flexibility nor its absence: along a motion that was followed, the
lengths are preserved up to rounding, and a motion that could not be followed may extend to higher order.
"""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import edge_rows, length_residuals

STEPS = 10

KEPT = 1e-12
"""Change of the lengths within the effect of rounding, in mean edge lengths; also the smallest singular value
of J above rounding, as its rows have unit entries."""


def described_flex(triangulation: Triangulation, surface: Projected, lengths: Floats) -> str | None:
    """Description of the numerically observed flex of a surface in Euclidean space; None if there is none.

    Parameters
    ----------
    triangulation : Triangulation
    surface : Projected
    lengths : ndarray, shape (E,)
        Edge lengths of the surface.
    """
    x = surface.vertices
    # J is decomposed as a dense matrix.
    if len(x) > 300 or not surface.space.is_euclidean:
        return None
    motions = _infinitesimal_flexes(triangulation, surface, lengths)
    if not len(motions):
        return None
    unit = float(lengths.mean())
    if len(motions) > 1:
        return f"{len(motions)} independent motions of its vertices change no length to first order"
    # Maximum displacements per step, in mean edge lengths: curved paths are followed only in short steps.
    for step in (0.02, 0.005, 0.001):
        residual, arrived = _followed(triangulation, surface, lengths, motions[0], step)
        if arrived:
            return (
                "the surface is flexible, as far as floats tell: a motion was followed until a vertex had "
                f"moved by {step * STEPS:g} mean edge lengths, and all lengths were kept to "
                f"{max(residual / unit, 1e-16):.0e} of the mean edge length"
            )
    return (
        "a motion of its vertices changes no length to first order, as far as floats tell, and could not be "
        f"followed: where a vertex has moved by {step:g} mean edge lengths, a length differs by "
        f"{residual / unit:.0e} of the mean edge length"
    )


def _matrix(triangulation: Triangulation, x: Floats, lengths: Floats) -> Floats:
    """Dense rigidity matrix J, (E, 3 V)."""
    rows, (a, b), edges = edge_rows(triangulation, x, lengths), triangulation.edges.T, np.arange(len(lengths))
    J = np.zeros((len(lengths), len(x), 3))
    J[edges, a], J[edges, b] = rows, -rows
    return J.reshape(len(lengths), -1)


def _infinitesimal_flexes(triangulation: Triangulation, surface: Projected, lengths: Floats) -> Floats:
    """Basis of the nontrivial motions that change no length to first order, (k, 3 V)."""
    constrained = np.vstack([_matrix(triangulation, surface.vertices, lengths), surface.rigid_motions().T])
    sizes, motions = np.linalg.svd(constrained)[1:]
    return motions[sizes <= KEPT]


def _followed(
    triangulation: Triangulation, surface: Projected, lengths: Floats, motion: Floats, step: float
) -> tuple[float, bool]:
    """Largest length error after the steps of a motion, and whether all steps preserved the lengths."""
    x, unit, worst = surface.vertices, float(lengths.mean()), 0.0
    for _ in range(STEPS):
        tangent = motion / np.linalg.norm(motion)
        farthest = np.linalg.norm(tangent.reshape(-1, 3), axis=1).max()
        y = x + (step * unit / farthest * tangent).reshape(-1, 3)
        residual = np.inf
        for _ in range(10):  # Gauss-Newton steps, orthogonal to the motion
            r = length_residuals(triangulation, y, lengths)
            residual = float(np.abs(r).max())
            if not KEPT * unit / 10 < residual < unit:
                break
            rigid = Projected.of(surface.space, y).rigid_motions()
            across = np.vstack([_matrix(triangulation, y, lengths), rigid.T, tangent])
            y = y - np.linalg.lstsq(across, np.concatenate([r, np.zeros(7)]), rcond=None)[0].reshape(-1, 3)
        worst = max(worst, residual)
        if not residual <= KEPT * unit:
            return worst, False
        x, motion = y, (y - x).ravel()
    return worst, True
