"""The integrals of a surface's energies by spectral quadrature over the sphere of directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidParameter
from isoembed.relativity.energies import Energies, Integrals
from isoembed.relativity.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import gauss_rule
from isoembed.smooth.two_metric import area_density
from isoembed.surface.estimate import Estimate

Floats = NDArray[np.float64]

ROUNDING = 1e-14
COARSER = 0.75  # of the nodes: the quadrature that tells the error of the other
FEWEST, INTRINSIC = 48, 96  # heights of the nodes
TRAPPED = 1e-9  # of k^2: a k^2 - p^2 that is more negative is no rounding


def smooth_energies(data: SurfaceData, embedding: SmoothEmbedding) -> Energies:
    """The energies of a surface with a smooth embedding.

    Parameters
    ----------
    data : SurfaceData
    embedding : SmoothEmbedding
        Of ``data.metric``.

    Notes
    -----
    The quadrature's error is the difference from that with 3/4 of its nodes; that of int k0 dA is twice the
    embedding's ``curvature_error``; and every integral is uncertain by what the lengths are.
    """
    degree, order = embedding.harmonics.degree, embedding.harmonics.order
    symmetric = order < degree
    values, notes = _integrated(data, max(FEWEST, (4 if symmetric else 2) * degree), 8 if symmetric else None)
    reference = 2.0 * embedding.integrated_mean_curvature
    error = 2.0 * embedding.curvature_error + (ROUNDING + data.relative_error) * abs(reference)
    if embedding.converged and embedding.least_curvature < 0.0:
        notes.append(
            f"the Gaussian curvature is negative in places, least {embedding.least_curvature:.3g}: other "
            "embeddings, with other energies, cannot be excluded"
        )
    if not embedding.converged:
        error += embedding.residual * abs(reference)
        notes.append(f"not an embedding, but the best fit: lengths are off by up to {embedding.residual:.1e}")
    return _energies(data, {**values, "reference": Estimate(reference, error)}, notes)


def intrinsic_energies(data: SurfaceData) -> Energies:
    """The energies of a surface that no embedding is needed for."""
    return _energies(data, *_integrated(data, INTRINSIC, None))


def _energies(data: SurfaceData, values: dict[str, Estimate], notes: list[str]) -> Energies:
    return Energies.of(
        Integrals(**values),
        angular_momentum=data.angular_momentum if data.marginal else None,
        charge=data.charge,
        notes=tuple(notes),
    )


def _integrated(data: SurfaceData, n: int, around: int | None) -> tuple[dict[str, Estimate], list[str]]:
    """The integrals over the surface by their names in `Integrals`, and what hinders others."""
    relative = ROUNDING + data.relative_error
    fine, coarse = (_Nodes.of(data, m, around or 2 * m) for m in (n, int(COARSER * n)))
    values, notes = fine.integrals(relative)
    others, _ = coarse.integrals(relative)
    for name, part in values.items():
        # The coarser nodes may see a surface as not spacelike where the finer do not.
        change = abs(part.value - others[name].value) if name in others else 0.0
        values[name] = Estimate(part.value, change + part.error)
    return values, notes


@dataclass(frozen=True)
class _Nodes:
    """The data at the nodes u (n, 3) of a quadrature."""

    u: Floats
    dA: Floats
    k: Floats | None
    p: Floats
    marginal: bool

    @classmethod
    def of(cls, data: SurfaceData, n: int, around: int) -> _Nodes:
        u, weights = gauss_rule(n, around)
        k = None if data.mean_curvature is None else _at(data.mean_curvature, u, "the mean curvature")
        p = np.zeros(len(u)) if data.momentum is None else _at(data.momentum, u, "the momentum")
        return cls(u, weights * area_density(data.metric.tensor(u)), k, p, data.marginal)

    def integrals(self, relative: float) -> tuple[dict[str, Estimate], list[str]]:
        """The integrals by their names in `Integrals`, and what hinders others."""
        area = float(self.dA.sum())
        values, notes = {"area": Estimate(area, 2.0 * relative * area)}, []
        if self.k is not None:
            values["k"] = Estimate(_sum(self.dA, self.k), 2.0 * relative * _sum(self.dA, np.abs(self.k)))
        else:
            notes.append("k is not given: there is no Brown-York energy")
        if self.marginal:
            return {**values, "norm": Estimate(0.0, 0.0), "squared": Estimate(0.0, 0.0)}, notes
        if self.k is None:
            return values, notes
        squared, uncertain = self.k**2 - self.p**2, 2.0 * relative * (self.k**2 + self.p**2)
        values["squared"] = Estimate(_sum(self.dA, squared), _sum(self.dA, uncertain))
        if squared.min() < -max(TRAPPED, 2.0 * relative) * (self.k**2).max():
            notes.append(
                f"k^2 - p^2 = {squared.min():.3g} < 0 at {self._place(squared)}: the mean curvature vector "
                "is not spacelike there, and there is no Kijowski-Liu-Yau energy"
            )
        elif self.k.min() < -TRAPPED * self.k.max() < 0.0:
            notes.append(
                f"k changes its sign, least {self.k.min():.3g} at {self._place(self.k)}: the mean "
                "curvature vector vanishes in between, and there is no Kijowski-Liu-Yau energy"
            )
        else:
            low, middle, high = (
                np.sqrt(np.maximum(squared + shift, 0.0)) for shift in (-uncertain, 0.0, uncertain)
            )
            values["norm"] = Estimate(_sum(self.dA, middle), _sum(self.dA, high - low))
        return values, notes

    def _place(self, values: Floats) -> str:
        """Where values are least."""
        x, y, z = self.u[int(np.argmin(values))]
        return f"theta = {np.arccos(z):.3f}, phi = {np.arctan2(y, x) % (2.0 * np.pi):.3f}"


def _sum(weights: Floats, values: Floats) -> float:
    return float(weights @ values)


def _at(function: Callable[[Floats], Floats], u: Floats, name: str) -> Floats:
    values = np.asarray(function(u), dtype=np.float64)
    if values.shape != (len(u),):
        raise InvalidParameter(f"{name} at {len(u)} directions has the shape {values.shape}, not ({len(u)},)")
    return values
