"""Quasi-local energies of a polyhedral metric with data at its vertices, and their deviations."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.sensitivity import Sensitivity
from isoembed.errors import InvalidParameter
from isoembed.metric.precision import shared_errors
from isoembed.relativity.energies.energies import Energies, Integrals, norm_hindrance
from isoembed.surface.checked import checked_errors
from isoembed.surface.estimate import Estimate
from isoembed.surface.smooth_integrals import Lengths, SmoothIntegrals

PROBES = 32  # number of random samples for standard deviations


def mesh_energies(
    embedding: Embedding,
    mean_curvature: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    *,
    lengths: Lengths | None = None,
    angular_momentum: float | None = None,
    charge: float = 0.0,
) -> Energies:
    """Energies of a smooth surface from a triangulation with lengths, k and p.

    Parameters
    ----------
    embedding : Embedding
        Embedding of the lengths, from `isoembed.embed`.
    mean_curvature, momentum : array_like, shape (V,), optional
        ``k = k1 + k2`` and ``p = K_ij (gamma^ij - n^i n^j)`` of the surface in its slice; p is 0 by default.
    lengths : "geodesic" or "chord", optional
        Kind of the lengths: of geodesics of the surface, or of chords between its points in space.  By
        default they are treated as geodesic, with errors large enough for chords.
    angular_momentum : float, optional
        J, in units of length^2.
    charge : float
        Q, in units of length.

    Notes
    -----
    The integrals are of fourth order in the edge length, with error estimates of `SmoothIntegrals`.
    Differences of k and p at a vertex from fits to the neighbors are treated as noise: it averages out in
    integrals, but its square biases those of k^2 - p^2 and its root.

    Raises
    ------
    InvalidParameter
        Arrays have wrong shapes, the momentum is given without the mean curvature, or the area overflows or
        underflows in the unit of length.
    """
    n = embedding.triangulation.n_vertices
    curvatures = {"mean curvature": mean_curvature, "momentum": momentum}
    for name, values in curvatures.items():
        if values is not None and np.shape(values) != (n,):
            raise InvalidParameter(
                f"the {name} has the shape {np.shape(values)}: there are {n} vertices, so it must be ({n},)"
            )
    if momentum is not None and mean_curvature is None:
        raise InvalidParameter("the momentum requires the mean curvature")
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
        notes.append("lengths are assumed to be geodesic; the errors allow for chords")
    return Energies.of(
        Integrals(**parts), angular_momentum=angular_momentum, charge=charge, notes=tuple(notes)
    )


def mesh_deviation(
    embedding: Embedding,
    errors: ArrayLike,
    mean_curvature: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    *,
    lengths: Lengths | None = None,
) -> dict[str, float | None]:
    """Standard deviations of the energies of `mesh_energies` for independent errors of the lengths.

    To first order: the vertices are displaced according to errors with random signs, and the squared changes
    are averaged.  With 32 samples, each standard deviation has a relative error of 1/8.  k and p are fixed.

    Parameters
    ----------
    embedding : Embedding
    errors : float or array_like, shape (E,)
        See `isoembed.Sensitivity.deviation`.
    mean_curvature, momentum, lengths
        See `mesh_energies`.

    Returns
    -------
    dict
        Standard deviations by the names of the energies; None for unknown energies.

    Raises
    ------
    InvalidParameter
        See `isoembed.Sensitivity.integral_deviation` and `mesh_energies`.
    SingularMatrix, OutOfMemory
        See `isoembed.Sensitivity.jvp`.
    """
    noisy = checked_errors(embedding.metric, errors)
    shared = shared_errors(embedding.metric.lengths, noisy)
    kind = lengths or "geodesic"
    values = _values(mesh_energies(embedding, mean_curvature, momentum, lengths=kind))
    squares = dict.fromkeys(values, 0.0)
    rng = np.random.default_rng(0)
    for _ in range(PROBES):
        changes = noisy * rng.choice([-1.0, 1.0], len(noisy))[shared]
        motion = Sensitivity(embedding).jvp(changes)
        farthest = float(np.linalg.norm(motion / embedding.metric.unit, axis=1).max())
        # A largest displacement of a vertex of 1e-6 mean edge lengths.
        step = 1e-6 * embedding.metric.normalized.mean_length / (farthest or 1.0)
        moved = Embedding(
            embedding.metric,
            embedding.vertices + step * motion,
            method=embedding.method,
            tolerance=embedding.tolerance,
        )
        other = _values(mesh_energies(moved, mean_curvature, momentum, lengths=kind))
        for name in squares:
            squares[name] += ((other[name] - values[name]) / step) ** 2 if name in other else np.nan
    mean = {name: float(np.sqrt(total / PROBES)) for name, total in squares.items()}
    return {each.name: mean.get(each.name) for each in fields(Energies) if each.name != "notes"}


def _values(energies: Energies) -> dict[str, float]:
    """Values of the known energies."""
    found = ((each.name, getattr(energies, each.name)) for each in fields(energies))
    return {name: estimate.value for name, estimate in found if isinstance(estimate, Estimate)}


def _integrals(
    embedding: Embedding, mean_curvature: ArrayLike | None, momentum: ArrayLike | None, lengths: Lengths
) -> tuple[dict[str, Estimate], list[str]]:
    """Integrals by their names in `Integrals`, and reasons for missing ones."""
    smooth = SmoothIntegrals.of(embedding.surface, lengths)
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
        Squares of the errors, which bias the mean of k^2 - p^2.
    squared : ndarray, shape (V,)
        Error of k^2 - p^2.
    typical : tuple of float
        Errors of k and of k^2 - p^2 exceeded at few vertices only.
    """

    squares: Floats
    squared: Floats
    typical: tuple[float, float]

    @classmethod
    def of(cls, smooth: SmoothIntegrals, k: Floats, p: Floats) -> _Noise:
        of_k, of_p = smooth.misfits(k), smooth.misfits(p)
        squares = of_k**2 + of_p**2
        squared = 2.0 * np.hypot(k * of_k, p * of_p) + squares
        deviations = 6.0 * np.median(np.abs([of_k, squared]), axis=1)  # four standard deviations
        return cls(squares, squared, (float(deviations[0]), float(deviations[1])))

    def of_root(self, squared: Floats) -> Floats:
        """Mean error (V,) of the square root of k^2 - p^2."""
        low, middle, high = (
            np.sqrt(np.maximum(squared + shift, 0.0)) for shift in (-self.squared, 0.0, self.squared)
        )
        shifted = np.sqrt(np.maximum(squared, 0.0) + self.squares) - middle
        return np.abs(middle - 0.5 * (low + high)) + shifted


def _biased(smooth: SmoothIntegrals, values: Floats, bias: Floats) -> Estimate:
    """Integral of values (V,), with that of their bias (V,) added to its error."""
    return smooth.integral(values) + Estimate(0.0, smooth.sum_at_vertices(bias))
