"""Energies of a surface that is given as a polyhedral metric, with data at its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
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
        What the lengths are: those of geodesics of the surface, or distances of points of it in space.  By
        default they are taken for geodesics', with errors wide enough for chords.
    angular_momentum : float, optional
        J, in units of length^2.
    charge : float
        Q, in units of length.

    Notes
    -----
    The integrals are of fourth order in the edge length, with the errors that `SmoothIntegrals` estimates.
    What k and p at a vertex differ by from fits to their neighbors is taken for noise: in integrals it
    averages out, but its square enters those of k^2 - p^2 and its root.

    Raises
    ------
    InvalidParameter
        Arrays have other shapes, the momentum has no mean curvature beside it, or the unit of length is such
        that the area is no number.
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
    if not np.finfo(np.float64).tiny <= embedding.area < np.inf:
        raise InvalidParameter(
            f"the area is {embedding.area!r}, beyond the range of numbers: use another unit of length"
        )
    parts, notes = _integrals(embedding, mean_curvature, momentum, lengths or "geodesic")
    if lengths is None:
        others, _ = _integrals(embedding, mean_curvature, momentum, "chord")
        for name, part in parts.items():
            other = others[name]
            error = max(part.error, other.error + abs(part.value - other.value))
            parts[name] = Estimate(part.value, error)
        notes.append("the lengths are taken for those of geodesics; the errors are wide enough for chords")
    return Energies.of(
        Integrals(**parts), angular_momentum=angular_momentum, charge=charge, notes=tuple(notes)
    )


def _integrals(
    embedding: Embedding, mean_curvature: ArrayLike | None, momentum: ArrayLike | None, lengths: Lengths
) -> tuple[dict[str, Estimate], list[str]]:
    """The integrals by their names in `Integrals`, and what hinders others."""
    smooth = SmoothIntegrals(embedding.triangulation, embedding.vertices, lengths, embedding.space)
    parts = {"area": smooth.area, "reference": smooth.integrated_mean_curvature.scaled(2.0)}
    if mean_curvature is None:
        return parts, ["k is not given: the irreducible mass is the only energy"]
    k = np.asarray(mean_curvature, dtype=np.float64)
    p = np.zeros_like(k) if momentum is None else np.asarray(momentum, dtype=np.float64)
    squared, noise = k**2 - p**2, _Noise.of(smooth, k, p)
    parts |= {"k": smooth.integral(k), "squared": _biased(smooth, squared, noise.squares)}
    hindrance = norm_hindrance(k, squared, "vertex {}".format, noise.typical)
    if hindrance:
        return parts, [hindrance]
    return {**parts, "norm": _biased(smooth, np.sqrt(np.maximum(squared, 0.0)), noise.of_root(squared))}, []


@dataclass(frozen=True)
class _Noise:
    """Errors of k and p at the vertices: their differences from fits to their neighbors.

    Attributes
    ----------
    squares : ndarray, shape (V,)
        The squares of both: the mean of k^2 - p^2 is off by them.
    squared : ndarray, shape (V,)
        The error of k^2 - p^2.
    typical : tuple of float
        The errors of k and of k^2 - p^2 at all but a few of the vertices.
    """

    squares: Floats
    squared: Floats
    typical: tuple[float, float]

    @classmethod
    def of(cls, smooth: SmoothIntegrals, k: Floats, p: Floats) -> _Noise:
        of_k, of_p = smooth.misfits(k), smooth.misfits(p)
        squares = of_k**2 + of_p**2
        squared = 2.0 * np.hypot(k * of_k, p * of_p) + squares
        of_most = 6.0 * np.median(np.abs([of_k, squared]), axis=1)  # four standard deviations
        return cls(squares, squared, (float(of_most[0]), float(of_most[1])))

    def of_root(self, squared: Floats) -> Floats:
        """By how much the mean of the root of k^2 - p^2 (V,) is off."""
        low, middle, high = (
            np.sqrt(np.maximum(squared + shift, 0.0)) for shift in (-self.squared, 0.0, self.squared)
        )
        shifted = np.sqrt(np.maximum(squared, 0.0) + self.squares) - middle
        return np.abs(middle - 0.5 * (low + high)) + shifted


def _biased(smooth: SmoothIntegrals, values: Floats, bias: Floats) -> Estimate:
    """The integral of values (V,), and in its error that of their bias (V,)."""
    return smooth.integral(values) + Estimate(0.0, smooth.sum_at_vertices(bias))
