"""Placement of the vertices of a polytope without curvature.

As the apex may move, the unit vectors from the apex, ``x_i / r_i``, span the kernel of ``d kappa / d r``:
three columns obtained for all vertices from one factorization.  Building the body pyramid by pyramid instead
would lose all digits on large ones.
"""

import numpy as np

from isoembed.alexandrov.ambient import (
    ambient_lengths,
    away_from_apex,
    conformal_radii,
    distances_from_apex,
)
from isoembed.alexandrov.lengths import conformal_lengths, worst_of_conformal
from isoembed.alexandrov.newton import Solution
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.progress.stages import StageRecorder

ROUGH = 1e-4  # relative residual of linear equations for a correction


def realized(solution: Solution, recorder: StageRecorder) -> Floats:
    """Vertices, shape (V, 3), to floating-point accuracy; in Euclidean space the apex is the origin.

    Parameters
    ----------
    solution : Solution
    recorder : StageRecorder
        Counter of refinement steps.
    """
    about = around_apex(solution)
    for _ in range(3):
        worst = worst_of_conformal(solution.polytope.tables, about)
        if worst <= (8 * 2.0**-52) * float(np.abs(about).max()):  # rounding
            break
        about = polished(solution, about)
        recorder.iterations += 1
    return away_from_apex(solution.polytope.space, about)


def placed(solution: Solution) -> Floats:
    """Vertices, shape (V, 3); in Euclidean space the apex is the origin."""
    return away_from_apex(solution.polytope.space, around_apex(solution))


def around_apex(solution: Solution) -> Floats:
    """Vertices in conformal coordinates with the apex as the origin, shape (V, 3)."""
    p = solution.polytope
    directions = np.zeros((p.radii.size, 3))
    directions[solution.pins] = np.eye(3)
    directions += solution.solve(p.times_jacobian(directions), 1e-12)[0]  # residual for a kernel
    # These are the directions up to a linear map B: fit G = B B^T to |x_i| = sn(r_i) and |x_i - x_j|.
    i, j, lengths = _edges(p)
    lengths = ambient_lengths(p.space, lengths, p.radii[i], p.radii[j])
    raw = directions * p.space.sn(p.radii)[:, None]
    products = np.concatenate([_products(directions), _products((raw[i] - raw[j]) / lengths[:, None])])
    g, *_ = np.linalg.lstsq(products, np.ones(len(products)), rcond=None)
    values, vectors = np.linalg.eigh(g[SYMMETRIC])
    raw = directions * conformal_radii(p.space, p.radii)[:, None]
    return raw @ (vectors * np.sqrt(np.abs(values)))  # all positive if the polytope has no curvature


def polished(solution: Solution, about: Floats) -> Floats:
    """Refine the vertices by a Newton step on the lengths, which removes rounding errors of the placement.

    The vertices define an exact polytope with nearly correct lengths, without curvature and with its
    directions as the kernel.  The correction is linear in the length errors, so these may be magnified before
    the curvatures, which are differences of nearly equal numbers, are evaluated.

    Parameters
    ----------
    solution : Solution
    about : ndarray, shape (V, 3)
        Vertices from `around_apex` or a previous refinement.

    Returns
    -------
    ndarray, shape (V, 3)
        Refined vertices; the argument itself if there is no improvement.
    """
    tables, space = solution.polytope.tables, solution.polytope.space
    radii = distances_from_apex(space, about)
    actual = conformal_lengths(tables, about)
    missing = tables.lengths - actual
    error = float(np.abs(missing).max())
    if error == 0:
        return about
    # Errors are magnified to 1e-6 mean edge lengths, above rounding.
    scale = 1e-6 * float(tables.lengths.mean()) / error
    wrong = tables._replace(lengths=actual + scale * missing)
    p = Polytope.on(wrong, radii)
    if p is None:
        return about
    dr, _ = solution.solve(p.curvatures, ROUGH)
    q = Polytope.on(wrong, radii + dr)
    if q is None:
        return about
    directions = about / np.linalg.norm(about, axis=1)[:, None]
    turned = directions + solution.solve(q.times_jacobian(directions), ROUGH)[0] / scale
    radii = radii + dr / scale
    moved = turned * space.sn(radii)[:, None]
    # Again up to a linear map, now near the identity.
    i, j, lengths = _edges(solution.polytope)
    lengths = ambient_lengths(space, lengths, radii[i], radii[j])
    chords = moved[i] - moved[j]
    strain, *_ = np.linalg.lstsq(
        _products(chords) / lengths[:, None], lengths - np.linalg.norm(chords, axis=1), rcond=None
    )
    moved += moved @ strain[SYMMETRIC]
    if not space.is_euclidean:
        moved *= (conformal_radii(space, radii) / space.sn(radii))[:, None]
    return moved if np.abs(conformal_lengths(tables, moved) - tables.lengths).max() < error else about


SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])


def _products(v: Floats) -> Floats:
    """Coefficients of ``v^T S v`` in the six entries of a symmetric S, shape (n, 6)."""
    x, y, z = v.T
    return np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=1)


def _edges(p: Polytope) -> tuple[Indices, Indices, Floats]:
    """Ends and lengths of the edges, or of an evenly spaced sample of them."""
    tables = p.tables
    h = np.flatnonzero(np.arange(tables.twins.size) < tables.twins)
    h = h[:: -(-h.size // 20_000)]  # enough edges for the six numbers of a linear map
    return tables.corners[h], tables.corners[tables.twins[h]], tables.lengths[h]
