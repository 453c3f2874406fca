"""Multipole moments (l, m) of horizons without symmetry, in conformal coordinates.

A metric on the sphere is conformal to round metrics of unit radius.  One of them, unique up to rotations, has
no area dipole: ``int n dA = 0``, where n are its unit vectors [1]_.  In its harmonics the multipoles are
``I_lm = 1/2 int K Y_lm dA`` and ``L_lm = - int Im Psi_2 Y_lm dA``, by parts an integral of K(., n).  For an
axisymmetric horizon they differ from those of `isoembed.relativity.Multipoles`, whose harmonics are functions
of the area coordinate zeta; [2]_ compares both for Kerr.

With ``dA = exp(2 phi) dA_0``, dA_0 the area of a round metric, ``K + Laplacian phi = exp(-2 phi)``.  Newton's
method solves this for phi in harmonics, with three conditions that select one of the round metrics.  The unit
vectors are the eigenfunctions of its Laplacian with eigenvalue 2, and a boost removes the area dipole.

References
----------
.. [1] A. Ashtekar, N. Khera, M. Kolanowski and J. Lewandowski, "Non-expanding horizons: multipoles and the
   symmetry group", J. High Energy Phys. 01 (2022) 028, arXiv:2111.07873.
.. [2] E. Gourgoulhon, A. Le Tiec and M. Casals, "Horizon multipole moments of a Kerr black hole",
   arXiv:2602.05823.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import gauss_rule
from isoembed.meshing.surface_mesh import checked_count
from isoembed.relativity.horizons.multipoles import STEEPER, estimates
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.spectral_curvature import spectral_curvature
from isoembed.smooth.two_metric import (
    angle_frame,
    area_density,
    is_axisymmetric,
    is_symmetric_about_z,
    orthonormal_frame,
)
from isoembed.smooth.uncertain import UncertainFunction
from isoembed.surface.estimate import Estimate

Complexes = NDArray[np.complex128]

STEPS = 50  # of Newton's methods, at most


@short_repr
@dataclass(frozen=True, eq=False)
class ConformalMultipoles:
    """Multipoles (l, m) of a horizon, l = 0, ..., n, in the harmonics of its balanced conformal sphere.

    The sphere is rotated so that its unit vectors best fit the points in slice coordinates, or the directions
    u if these are not known.  The powers do not depend on the rotation.

    Attributes
    ----------
    shape : ndarray of complex, shape (n + 1, n + 1)
        I_lm at [l, m], for m = 0, ..., l; zero for m > l.  ``I_l,-m = (-1)^m conj(I_lm)``, with the
        Condon-Shortley phase of Y_lm.  I_00 = sqrt(pi).
    rotation : ndarray of complex, shape (n + 1, n + 1), or None
        L_lm; None if the data have no ``normal_momentum``: K(., n) vanishes or is not known.
    shape_errors, rotation_errors : ndarray, shape (n + 1,)
        Errors of the multipoles of each degree l.
    """

    shape: Complexes
    rotation: Complexes | None
    shape_errors: Floats
    rotation_errors: Floats

    @property
    def shape_power(self) -> tuple[Estimate, ...]:
        """``sum_m |I_lm|^2`` over m = -l, ..., l."""
        return _powers(self.shape, self.shape_errors)

    @property
    def rotation_power(self) -> tuple[Estimate, ...] | None:
        """``sum_m |L_lm|^2`` over m = -l, ..., l."""
        return None if self.rotation is None else _powers(self.rotation, self.rotation_errors)

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: real and imaginary parts for m = 0, ..., l in row l, errors and powers."""

        def rows(table: Complexes | None) -> list[list[list[float]]] | None:
            if table is None:
                return None
            return [[[z.real, z.imag] for z in table[l, : l + 1].tolist()] for l in range(len(table))]

        powers = {"I_power": self.shape_power, "L_power": self.rotation_power}
        return {
            "I": rows(self.shape),
            "L": rows(self.rotation),
            **{name: found and [e.value for e in found] for name, found in powers.items()},
            "errors": {
                "I": self.shape_errors.tolist(),
                "L": None if self.rotation is None else self.rotation_errors.tolist(),
                **{name: found and [e.error for e in found] for name, found in powers.items()},
            },
        }


def multipole_lines(report: dict[str, Any]) -> Iterator[str]:
    """Lines of text for a report of `ConformalMultipoles`: the powers, which are independent of the frame."""
    for name in ("I", "L"):
        if report[name] is not None:
            powers = zip(report[f"{name}_power"], report["errors"][f"{name}_power"], strict=True)
            shown = ", ".join(f"{l}: {Estimate(*pair)}" for l, pair in enumerate(powers) if l)
            yield f"sum over m of |{name}_lm|^2 for l = {shown}"


def checked_order(n: SupportsIndex) -> int:
    """Checked degree of the highest multipoles.  Raises `InvalidParameter`: it is out of range."""
    return checked_count("the highest degree of multipoles", n, 1, 20)


def conformal_multipoles(data: SurfaceData, n: SupportsIndex = 8) -> ConformalMultipoles:
    """Shape and current multipoles (l, m) of a horizon, with or without symmetry.

    Parameters
    ----------
    data : SurfaceData
        Surface; only its metric, ``normal_momentum`` and ``shape`` are used.
    n : int
        Largest degree l, at most 20.

    Raises
    ------
    InvalidParameter
        n is not an integer from 1 to 20.
    InvalidMetric
        The metric is not positive definite, or too far from round for its conformal sphere to be found.

    Notes
    -----
    The errors include the change from a lower degree of phi, the effect of uncertain lengths, and that of a
    possible displacement of the surface from the horizon.

    Examples
    --------
    >>> from isoembed.relativity import KerrNewmanHorizon
    >>> found = conformal_multipoles(KerrNewmanHorizon(1.0, 0.6).data())
    >>> abs(found.shape[0, 0] - np.pi**0.5) < 1e-12, abs(found.shape[2, 1]) < 1e-12
    (True, True)
    """
    order = checked_order(n)
    symmetric = is_axisymmetric(data.metric) and _momentum_is_axisymmetric(data)
    # Degrees of the harmonics of phi, in order of refinement.
    allowed = (16, 24, 32, 48, 64, 96, 128) if symmetric else (12, 16, 24, 32)
    degrees = tuple(degree for degree in allowed if degree >= order)
    K = spectral_curvature(data.metric, data.relative_error)
    found = _moments(data, K, degrees[0], order, symmetric)
    for degree in degrees[1:]:
        before, found = found, _moments(data, K, degree, order, symmetric)
        change = np.abs(found - before).max(axis=2)
        if change.max() <= max(1e-12, data.relative_error):  # converged
            break
    l = np.arange(order + 1)
    steep = l * (l + 1) * (1.0 + STEEPER * l**2)
    rounding = 1e-13 * (1 + l) ** 2
    errors = change + rounding + steep * data.relative_error + l * (l + 1) * data.displacement
    if isinstance(data.normal_momentum, UncertainFunction):
        errors[1] += steep * np.pi * data.normal_momentum.error.mean
    rotation = None if data.normal_momentum is None else found[1]
    return ConformalMultipoles(found[0], rotation, errors[0], errors[1])


@dataclass(frozen=True, eq=False)
class _Sphere:
    """Round metric conformal to a given metric, at nodes u on the sphere of directions.

    Attributes
    ----------
    n : ndarray, shape (N, 3)
        Unit vectors of the round metric.
    slope : ndarray, shape (N, 3, 3)
        ``slope[:, i]`` is the gradient of n_i on the unit sphere of directions.
    """

    n: Floats
    slope: Floats

    def boosted(self, b: Floats) -> _Sphere:
        """Image under the conformal map of the ball that maps b, |b| < 1, to the center."""
        d = self.n - b
        rho = np.einsum("ni,ni->n", d, d)[:, None]
        scale = 1.0 - float(b @ b)
        rate = np.eye(3) / rho[:, :, None] - 2.0 * d[:, :, None] * d[:, None, :] / rho[:, :, None] ** 2
        return _Sphere(scale * d / rho - b, scale * rate @ self.slope)

    def balanced(self, dA: Floats) -> _Sphere:
        """Round metric without area dipole, for the areas dA (N,) at the nodes, which sum to 4 pi."""
        sphere = self
        for _ in range(STEPS):
            dipole: Floats = dA @ sphere.n / (4.0 * np.pi)
            if np.linalg.norm(dipole) <= 1e-15:
                break
            spread = sphere.n.T @ (dA[:, None] * sphere.n) / (4.0 * np.pi)
            b = np.asarray(np.linalg.solve(2.0 * (np.eye(3) - spread), dipole), dtype=np.float64)
            sphere = sphere.boosted(b * min(1.0, 0.9 / float(np.linalg.norm(b))))
        return sphere

    def nearest(self, x: Floats, dA: Floats) -> _Sphere:
        """Image under the rotation that best aligns it with vectors x (N, 3)."""
        R = Rotation.align_vectors(x, self.n, dA)[0].as_matrix()
        return _Sphere(self.n @ R.T, R @ self.slope)


def _moments(
    data: SurfaceData, curvature: Callable[[Floats], Floats], degree: int, order: int, symmetric: bool
) -> Complexes:
    """I_lm and L_lm (2, order + 1, order + 1), with phi in harmonics of a given degree."""
    heights = 3 * degree // 2 + 2
    # With symmetry, 16 angles phi are enough for the unit vectors, which have order 1.
    u, weights = gauss_rule(heights, max(16, 2 * order + 2) if symmetric else 2 * heights)
    q = data.metric.tensor(u)
    density = area_density(q)
    unit = float(weights @ density) / (4.0 * np.pi)
    dA, K = weights * density / unit, curvature(u) * unit
    K += 1.0 - dA @ K / (4.0 * np.pi)  # exact mean by the Gauss-Bonnet theorem
    harmonics = Harmonics(degree, 1 if symmetric else degree)
    Y, first = harmonics.along(u, orthonormal_frame(u, q / unit))
    start = harmonics.values(u).T @ (weights * 0.5 * np.log(density / unit))
    sphere = _conformal(harmonics, u, dA, K, Y, first, start).balanced(dA)
    x = u if data.shape is None else data.shape(u)
    sphere = sphere.nearest(x - dA @ x / (4.0 * np.pi), dA)
    values, gradients = Harmonics(order, order).gradients(sphere.n)
    shape = 0.5 * ((dA * K) @ values)
    rotation = np.zeros_like(shape)
    if data.normal_momentum is not None:
        # j_a eps^ab D_b Y dA is j . (grad Y x u) on the unit sphere of directions, whatever the metric.
        turned = np.cross(u, data.normal_momentum(u)) * weights[:, None]
        along = np.einsum("nk,nik->ni", turned, sphere.slope)
        rotation = 0.5 * np.einsum("ni,nis->s", along, gradients, optimize=True)
    return np.stack([_complex(part, order) for part in (shape, rotation)])


def _conformal(
    harmonics: Harmonics, u: Floats, dA: Floats, K: Floats, Y: Floats, first: Floats, start: Floats
) -> _Sphere:
    """Round metric conformal to the metric with areas dA and Gaussian curvatures K at the nodes u."""
    flat = first.reshape(-1, Y.shape[1])
    S = _gram(flat, np.repeat(dA, 2))
    sources, phi = Y.T @ (dA * K), start

    def left(phi: Floats) -> tuple[Floats, Floats]:
        w = dA * np.exp(-2.0 * (Y @ phi))
        return w, np.concatenate([sources - S @ phi - Y.T @ w, -(w @ u)])

    (w, residual), size = left(phi), np.inf
    for _ in range(STEPS):
        before, size = size, float(np.linalg.norm(residual))
        if size <= 1e-13 or (size <= 1e-8 and size > 0.5 * before):
            break  # the rest is rounding
        # Bordered by three conditions: the round metric is balanced in u.  The multipliers are rounding.
        border = 2.0 * Y.T @ (w[:, None] * u)
        matrix = np.block([[2.0 * _gram(Y, w) - S, border], [border.T, np.zeros((3, 3))]])
        step, part = -np.linalg.solve(matrix, residual)[:-3], 1.0
        while part >= 2.0**-20 and np.linalg.norm(left(phi + part * step)[1]) >= size:
            part *= 0.5
        phi = phi + part * step
        w, residual = left(phi)
    if not size <= 1e-6:
        raise InvalidMetric(f"no round metric conformal to this one was found: the residual is {size:.1e}")
    _, found = eigh(S, _gram(Y, w), subset_by_index=[1, 3])
    found *= np.sqrt(4.0 * np.pi / 3.0)
    n, slope, _ = harmonics.derivatives(u, found)
    along = slope @ np.stack(angle_frame(u), axis=2)
    # Orientation as for u.
    sign = np.sign(np.sum(w * np.einsum("ni,ni->n", n, np.cross(along[:, :, 0], along[:, :, 1]))))
    return _Sphere(sign * n, sign * slope)


def _gram(table: Floats, weights: Floats) -> Floats:
    """Gram matrix of the columns; of one factor with itself, BLAS computes half of the entries."""
    scaled = np.sqrt(weights)[:, None] * table
    return scaled.T @ scaled


def _complex(real: Floats, order: int) -> Complexes:
    """Moments with complex harmonics at [l, m], m >= 0, from those with real harmonics."""
    table = np.zeros((order + 1, order + 1), dtype=np.complex128)
    for value, l, m in zip(real, *Harmonics(order, order).labels, strict=True):
        phase = 1.0 if m == 0 else (-1.0) ** m / np.sqrt(2.0)
        table[l, abs(m)] += phase * (1j if m < 0 else 1.0) * value
    return table


def _powers(table: Complexes, errors: Floats) -> tuple[Estimate, ...]:
    squares = np.abs(table) ** 2
    powers = squares[:, 0] + 2.0 * squares[:, 1:].sum(axis=1)
    l = np.arange(len(table))
    spread = errors * np.sqrt(2 * l + 1)
    return estimates(powers, 2.0 * np.sqrt(powers) * spread + spread**2)


def _momentum_is_axisymmetric(data: SurfaceData) -> bool:
    """Whether the components of K(., n) are independent of phi."""
    momentum = data.normal_momentum
    if momentum is None:
        return True
    return is_symmetric_about_z(
        lambda u: np.stack([np.einsum("ni,ni->n", momentum(u), e) for e in angle_frame(u)])
    )
