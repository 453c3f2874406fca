"""Energies of a surface that is given as a polyhedral metric, with data at its vertices."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.energies import Energies, Integrals, norm_hindrance
from isoembed.surface.embedding import Embedding
from isoembed.surface.estimate import Estimate
from isoembed.surface.smooth_integrals import Lengths, SmoothIntegrals


def mesh_energies(
    embedding: Embedding,
    mean_curvature: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    *,
    lengths: Lengths | None = None,
    angular_momentum: float | None = None,
    charge: float = 0.0,
) -> Energies:
    """Energies of a smooth surface of which a triangulation and its lengths, k and p are known.

    Parameters
    ----------
    embedding : Embedding
        Of the lengths, from `isoembed.embed`.
    mean_curvature, momentum : array_like, shape (V,), optional
        ``k = k1 + k2`` and ``p = K_ij (gamma^ij - n^i n^j)`` of the surface in its slice; p is 0 by default.
    lengths : "geodesic" or "chord", optional
        What the lengths are: those of geodesics of the surface, or distances of points of it in R^3.  By
        default they are taken for geodesics', with errors wide enough for chords.
    angular_momentum : float, optional
        J, in units of length^2.
    charge : float
        Q, in units of length.

    Notes
    -----
    The integrals are of fourth order in the edge length, with the errors that `SmoothIntegrals` estimates.
    """
    n = embedding.triangulation.n_vertices
    given = {"mean curvature": mean_curvature, "momentum": momentum}
    for name, values in given.items():
        if values is not None and np.shape(values) != (n,):
            raise InvalidParameter(
                f"the {name} has the shape {np.shape(values)}: there are {n} vertices, so it must be ({n},)"
            )
    if momentum is not None and mean_curvature is None:
        raise InvalidParameter("the momentum is of use only with the mean curvature")
    parts, notes = _integrals(embedding, mean_curvature, momentum, lengths or "geodesic")
    if lengths is None:
        others, _ = _integrals(embedding, mean_curvature, momentum, "chord")
        for name, part in parts.items():
            parts[name] = Estimate(part.value, part.error + abs(part.value - others[name].value))
        notes.append("the lengths are taken for those of geodesics; the errors are wide enough for chords")
    return Energies.of(
        Integrals(**parts), angular_momentum=angular_momentum, charge=charge, notes=tuple(notes)
    )


def _integrals(
    embedding: Embedding, mean_curvature: ArrayLike | None, momentum: ArrayLike | None, lengths: Lengths
) -> tuple[dict[str, Estimate], list[str]]:
    """The integrals by their names in `Integrals`, and what hinders others."""
    smooth = SmoothIntegrals(embedding.triangulation, embedding.vertices, lengths)
    parts = {"area": smooth.area, "reference": smooth.integrated_mean_curvature.scaled(2.0)}
    if mean_curvature is None:
        return parts, ["k is not given: the irreducible mass is the only energy"]
    k = np.asarray(mean_curvature, dtype=np.float64)
    p = np.zeros_like(k) if momentum is None else np.asarray(momentum, dtype=np.float64)
    squared = k**2 - p**2
    parts |= {"k": smooth.integral(k), "squared": smooth.integral(squared)}
    hindrance = norm_hindrance(k, squared, "vertex {}".format)
    if hindrance:
        return parts, [hindrance]
    return {**parts, "norm": smooth.integral(np.sqrt(squared))}, []
