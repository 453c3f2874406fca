"""Neighboring realizations: other surfaces with the same lengths, near where a surface is soft.

Along a motion v that hardly changes the lengths, ``J v = sigma u``, their errors are
``s sigma u + s^2 q`` with ``q_ab = |v_a - v_b|^2 / (2 l_ab)``: besides s = 0 they vanish, as far as u goes,
at ``s = -sigma / <u, q>``.  Where that is near, Newton's method finds a second realization from there.

Pulled back, a surface may come to either of two such neighbors.  The smoother is the one that is meant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.anneal import anneal
from isoembed.linalg import SingularMatrix
from isoembed.stages import Tally
from isoembed.surface.rigidity import LengthSystem
from isoembed.surface.smoothness import fine_roughness

Floats = NDArray[np.float64]

MOTIONS = 4  # the softest: beyond them, neighbors are far
NEAR = 0.03  # mean edge lengths: beyond, the quadratic is a poor guide
APART = 0.1  # of the distance foreseen: nearer, Newton's method fell back
FEW = 4  # Newton steps
POLISHED = 1e-13  # residual that they aim for
MOVES = 4  # from neighbor to neighbor


def smoothest(
    system: LengthSystem, vertices: Floats, lengths: Floats, tally: Tally, *, residual_tolerance: float
) -> list[Floats]:
    """The smoothest realization among neighbors of neighbors, and those that were met on the way to it.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        Has these lengths.
    lengths : ndarray, shape (E,)
        Of mean 1 or so.
    tally : Tally
    residual_tolerance : float
        For the neighbors.

    Returns
    -------
    list of ndarray, shape (V, 3)
        The smoothest comes first; last, where there is one, the nearest of its rougher neighbors.
    """
    triangulation = system.triangulation
    met, roughness = [vertices], fine_roughness(triangulation, vertices)
    for _ in range(MOVES):
        tally.factorizations += 1
        foreseen = _foreseen(system, met[0], lengths)
        if not foreseen:
            return met
        expected = [fine_roughness(triangulation, met[0] + motion) for motion in foreseen]
        motion = foreseen[int(np.argmin(expected)) if min(expected) < roughness else 0]
        neighbor = _realized(system, met[0], motion, lengths, tally, residual_tolerance)
        if neighbor is None:
            return met
        rougher = fine_roughness(triangulation, neighbor)
        if rougher >= roughness:
            return [*met, neighbor]
        met, roughness = [neighbor, *met], rougher
    return met


def _foreseen(system: LengthSystem, vertices: Floats, lengths: Floats) -> list[Floats]:
    """The motions to where the softest ones lead to the same lengths again, if near, the nearest first."""
    try:
        sigmas, motions, changes = system.softest(vertices, lengths, min(MOTIONS, len(lengths) - 1))
    except SingularMatrix:
        return []
    a, b = system.triangulation.edges.T
    found = []
    for sigma, motion, change in zip(sigmas, motions, changes, strict=True):
        q = np.sum((motion[a] - motion[b]) ** 2, axis=1) / (2 * lengths)
        found.append(-sigma / (change @ q) * motion)
    reach = [float(np.linalg.norm(motion, axis=1).max()) for motion in found]
    return [found[k] for k in np.argsort(reach) if reach[k] < NEAR]


def _realized(
    system: LengthSystem,
    vertices: Floats,
    motion: Floats,
    lengths: Floats,
    tally: Tally,
    residual_tolerance: float,
) -> Floats | None:
    """Where Newton's method leads from the end of a motion, if to another realization."""
    found = anneal(
        system,
        vertices + motion,
        lengths,
        tally,
        residual_tolerance=POLISHED,
        max_iterations=FEW,
    )
    moved = np.abs(found.vertices - vertices).max()
    apart = moved > APART * np.abs(motion).max()
    return found.vertices if apart and found.residual <= residual_tolerance else None
