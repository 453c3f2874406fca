"""Standard deviations of the energies of triangles whose lengths have errors."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import ArrayLike

from isoembed.metric.precision import shared_errors
from isoembed.relativity.energies.energies import Energies
from isoembed.relativity.energies.mesh_energies import mesh_energies
from isoembed.surface.checked import checked_errors
from isoembed.surface.embedding import Embedding
from isoembed.surface.estimate import Estimate
from isoembed.surface.smooth_integrals import Lengths

PROBES = 32  # random errors, from whose effects the standard deviations are estimated


def mesh_deviation(
    embedding: Embedding,
    errors: ArrayLike,
    mean_curvature: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    *,
    lengths: Lengths | None = None,
) -> dict[str, float | None]:
    """Standard deviations of the energies of `mesh_energies`, by independent errors of the lengths.

    To first order: signs are drawn at random for the errors, the vertices are moved as they follow, and the
    squares of what that changes are averaged.  With 32 draws, each standard deviation is known to an eighth.
    k and p are taken as they are.

    Parameters
    ----------
    embedding : Embedding
    errors : float or array_like, shape (E,)
        As of `Embedding.deviation`.
    mean_curvature, momentum, lengths
        As of `mesh_energies`.

    Returns
    -------
    dict
        By the names of the energies; None for those that are not known.

    Raises
    ------
    InvalidParameter
        As `Embedding.integral_deviation`, and `mesh_energies`.
    SingularMatrix, OutOfMemory
        As `Embedding.jvp`.
    """
    noisy = checked_errors(embedding.metric, errors)
    shared = shared_errors(embedding.metric.lengths, noisy)
    given = lengths or "geodesic"
    values = _values(mesh_energies(embedding, mean_curvature, momentum, lengths=given))
    squares = dict.fromkeys(values, 0.0)
    rng = np.random.default_rng(0)
    for _ in range(PROBES):
        changes = noisy * rng.choice([-1.0, 1.0], len(noisy))[shared]
        motion = embedding.jvp(changes)
        farthest = float(np.linalg.norm(motion / embedding.metric.unit, axis=1).max())
        # The largest displacement of a vertex, in mean edge lengths.
        step = 1e-6 * embedding.metric.normalized.mean_length / (farthest or 1.0)
        moved = Embedding(
            embedding.metric,
            embedding.vertices + step * motion,
            method=embedding.method,
            tolerance=embedding.tolerance,
        )
        other = _values(mesh_energies(moved, mean_curvature, momentum, lengths=given))
        for name in squares:
            squares[name] += ((other[name] - values[name]) / step) ** 2 if name in other else np.nan
    mean = {name: float(np.sqrt(total / PROBES)) for name, total in squares.items()}
    return {each.name: mean.get(each.name) for each in fields(Energies) if each.name != "notes"}


def _values(energies: Energies) -> dict[str, float]:
    """Those of the energies that are known."""
    found = ((each.name, getattr(energies, each.name)) for each in fields(energies))
    return {name: estimate.value for name, estimate in found if isinstance(estimate, Estimate)}
