"""Nearby realizations: other surfaces with the same lengths, near where a surface is soft.

Along motions v_j that hardly change the lengths, ``J v_j = sigma_j u_j``, the errors of the lengths are, as
far as the u_i go,

    ``<u_i, r> + sigma_i s_i + 1/2 sum_jk s_j s_k <u_i, q_jk>``,  ``q_jk = (dv_j . dv_k) / l``,

a few quadratic equations.  Their roots predict realizations; Newton's method finds these from there.  In
hyperbolic and spherical space sn(l) is in the place of l, and the products have one more term.

Pulled back, a surface may come to any of them.  The smoothest is the one that is meant.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from isoembed.aim.anneal import anneal
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smoothness import QuinticResiduals, fine_roughness
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class NearbyThresholds:
    """Thresholds of the search for nearby realizations."""

    motions: int = threshold(4, "count", "The softest motions: beyond them, realizations are far.")
    near: float = threshold(0.03, "mean edge lengths", "Farther, quadratic equations are a poor guide.")
    apart: float = threshold(0.1, "relative", "Nearer, of the distance expected, Newton's method fell back.")
    few: int = threshold(4, "count", "Newton steps to a realization at most.")
    moves: int = threshold(4, "count", "Moves from realization to realization at most.")
    least: float = threshold(1e-9, "mean edge lengths", "Nearer, it is the surface itself.")
    root_steps: int = threshold(30, "count", "Newton steps toward a root at most.")
    root: float = threshold(1e-12, "relative", "A step this short has found a root.")
    same_root: float = threshold(1e-3, "relative", "Roots as near to each other as this are one.")


NEARBY = NearbyThresholds()


def nearby_realizations(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    *,
    residual_tolerance: float,
) -> list[Floats]:
    """The smoothest realization among neighbors of neighbors, and those that were met on the way to it.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        Has these lengths.
    lengths : ndarray, shape (E,)
        Of mean 1 or so.
    recorder : StageRecorder
    residual_tolerance : float
        For the neighbors.

    Returns
    -------
    list of ndarray, shape (V, 3)
        The smoothest comes first; last, where there is one, a rougher neighbor of it.  Empty if the
        vertices do not have these lengths, and no neighbor is found that has.
    """
    triangulation = system.triangulation
    best, met, roughness = vertices, [], np.inf
    errors = length_residuals(triangulation, vertices, lengths, system.space)
    if np.abs(errors).max() <= residual_tolerance:
        met, roughness = [vertices], fine_roughness(triangulation, vertices)
    for _ in range(NEARBY.moves):
        recorder.factorizations += 1
        predicted = _predicted(system, best, lengths)
        if not predicted:
            return met
        charts = QuinticResiduals.of(triangulation, best)
        expected = [charts.roughness(best + motion) for motion in predicted]
        motion = predicted[int(np.argmin(expected)) if min(expected) < roughness else 0]
        neighbor = _realized(system, best, motion, lengths, recorder, residual_tolerance)
        if neighbor is None:
            return met
        rougher = fine_roughness(triangulation, neighbor)
        if rougher >= roughness:
            return [*met, neighbor]
        best, met, roughness = neighbor, [neighbor, *met], rougher
    return met


def _predicted(system: LengthSystem, vertices: Floats, lengths: Floats) -> list[Floats]:
    """The motions to where the lengths are the given ones, as far as the softest go, the shortest first."""
    try:
        sigmas, motions, changes = system.smallest_singular_values(
            vertices, lengths, min(NEARBY.motions, len(lengths) - 1)
        )
    except SingularMatrix:
        return []
    r = length_residuals(system.triangulation, vertices, lengths, system.space)
    a, b = system.triangulation.edges.T
    d, weights = motions[:, a] - motions[:, b], changes / system.space.sn(lengths)
    Q = np.einsum("ie,jec,kec->ijk", weights, d, d, optimize=True)
    if not system.space.is_euclidean:
        Q += np.einsum("ie,jke->ijk", weights, _bending(system, vertices, motions))
    roots = quadratic_roots(changes @ r, sigmas, Q)
    found = [np.tensordot(root, motions, axes=1) for root in roots]
    reach = [float(np.linalg.norm(motion, axis=1).max()) for motion in found]
    unit = float(lengths.mean())
    least = NEARBY.apart * max(float(np.abs(r).max()), NEARBY.least * unit)
    return [found[k] for k in np.argsort(reach) if least < reach[k] < NEARBY.near * unit]


def _bending(system: LengthSystem, vertices: Floats, motions: Floats) -> Floats:
    """What hyperboloid or sphere add to ``dv_j . dv_k``: half the second derivatives of w, squared, over k.

    Returns
    -------
    ndarray, shape (k, k, E)
    """
    k, w = system.space.curvature, system.space.heights(vertices)
    a, b = system.triangulation.edges.T
    slopes = np.einsum("vc,jvc->jv", vertices, motions) / w  # w changes by -k times them
    second = (np.einsum("jvc,kvc->jkv", motions, motions) + k * slopes[:, None] * slopes) / w
    change = slopes[:, a] - slopes[:, b]
    return k * change[:, None] * change - (w[a] - w[b]) * (second[..., a] - second[..., b])


def quadratic_roots(constant: Floats, slope: Floats, Q: Floats) -> list[Floats]:
    """Real roots of ``c_i + sigma_i s_i + 1/2 sum_jk Q_ijk s_j s_k``, from where the axes have theirs.

    Parameters
    ----------
    constant, slope : ndarray, shape (k,)
    Q : ndarray, shape (k, k, k)
        Symmetric in the last two.

    Returns
    -------
    list of ndarray, shape (k,)
        Not always all of them.
    """
    k = len(slope)
    alone = -2 * slope / np.einsum("iii->i", Q)
    roots: list[Floats] = []
    for corner in itertools.product((0.0, 1.0), repeat=k):
        s = np.array(corner) * alone
        for _ in range(NEARBY.root_steps):
            f = constant + slope * s + np.einsum("ijk,j,k->i", Q, s, s) / 2
            try:
                step = np.linalg.solve(np.diag(slope) + Q @ s, f)
            except np.linalg.LinAlgError:
                break
            s = s - step
            if np.linalg.norm(step) <= NEARBY.root * np.linalg.norm(s):
                break
        else:
            continue
        if all(np.linalg.norm(s - root) > NEARBY.same_root * np.linalg.norm(root) for root in roots):
            roots.append(s)
    return roots


def _realized(
    system: LengthSystem,
    vertices: Floats,
    motion: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    residual_tolerance: float,
) -> Floats | None:
    """Where Newton's method leads from the end of a motion, if to another realization."""
    found = anneal(system, vertices + motion, lengths, recorder, max_iterations=NEARBY.few)
    moved = np.abs(found.vertices - vertices).max()
    apart = moved > NEARBY.apart * np.abs(motion).max()
    return found.vertices if apart and found.residual <= residual_tolerance else None
