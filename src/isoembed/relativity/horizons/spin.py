"""Spin of a surface: angular momentum and its axis.

``J = 1 / 8 pi int K(phi, n) dA`` for a rotation phi.  If the surface is axisymmetric, phi is the Killing
vector, and J about other axes vanishes.  If it is nearly round or tidally deformed, the rotation of least
shear is unrelated to the spin.  In both cases J is maximal about the spin axis among the combinations of the
three `approximate_killing.rotations`.  Therefore the rotation of maximal J is used; its shear measures the
departure from symmetry.  J is linear in the rotation, so that the maximum is the length of the vector of the
three J's, independent of coordinates.  Only the direction of the axis depends on coordinates: it is a moment
of the potential, robust against noise like the moment of the curl of j in [1]_.

References
----------
.. [1] R. Owen, A. S. Fox, J. A. Freiberg and T. P. Jacques, "Black hole spin axis in numerical relativity",
   Phys. Rev. D 99 (2019) 084031, arXiv:1708.07325.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.approximate_killing import Rotations, rotations
from isoembed.relativity.horizons.invariant_coordinate import InvariantCoordinate
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of, normal_momentum_of
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import is_axisymmetric
from isoembed.smooth.uncertain import UncertainFunction
from isoembed.surface.estimate import Estimate

LENGTHS = 2.0  # error of an axis, or relative error of J, per relative error of lengths


@short_repr
@dataclass(frozen=True)
class Spin:
    """Angular momentum of a surface.

    Attributes
    ----------
    J : Estimate
        Magnitude, in units of length^2.
    axis : three floats, or None
        Unit vector of the spin axis in slice coordinates, or in the space of the directions u if these are
        not known.  None if J is zero within its error.
    axis_error : float or None
        Error of the axis, in radians.
    vector : three floats
        J for the coordinate rotations about x, y and z, from ``torque`` of the data, or for rotations of the
        directions u.  Zero if K(., n) is not known.
    shear : float or None
        Shear of the rotation about the axis, 0 for a Killing vector; see
        `isoembed.relativity.horizons.approximate_killing.Rotations.shear`.
    method : str
        Description of how the axis was found.
    zeta : InvariantCoordinate or None
        Invariant coordinate of the rotation about the axis; None without an axis.
    """

    J: Estimate
    axis: tuple[float, float, float] | None
    axis_error: float | None
    vector: tuple[float, float, float]
    shear: float | None
    method: str
    zeta: InvariantCoordinate | None = field(default=None, repr=False, compare=False)

    def misses(self, about: float) -> bool:
        """Whether J about an axis, up to sign, differs from the magnitude by more than the errors."""
        tilt = 0.0 if self.axis_error is None else 1.0 - np.cos(self.axis_error)
        return bool(abs(self.J.value - abs(about)) > 2.0 * self.J.error + tilt * self.J.value)


def find_spin(data: SurfaceData) -> Spin | None:
    """Angular momentum of a surface and its axis.

    Parameters
    ----------
    data : SurfaceData
        Surface; only its metric and ``normal_momentum`` are used.

    Returns
    -------
    Spin or None
        None if neither K(., n) nor J is known.

    Notes
    -----
    The errors include the change between degrees and the effects of ``relative_error`` and of the error of
    K(., n).  For a surface without symmetry they also include twice the squared shear times J, and for the
    axis the shear; randomly deformed surfaces around a Kerr black hole have half and a quarter of these.
    """
    if data.normal_momentum is None:
        if data.angular_momentum is None:
            return None
        J = Estimate(abs(data.angular_momentum), 0.0)
        how = "J is given, and K(., n) is not" if J.value > 0.0 else "K(., n) vanishes"
        return Spin(J, None, None, (0.0, 0.0, 0.0), None, how)
    axisymmetric = is_axisymmetric(data.metric)
    # Degrees of the rotations' harmonics, in order of refinement.
    first, *others = (8, 16, 32, 64) if axisymmetric else (8, 12, 16, 22)
    trial = _Trial.of(data, rotations(data.metric, first, axisymmetric))
    for degree in others:
        before = trial
        trial = _Trial.of(data, rotations(data.metric, degree, axisymmetric))
        quiet = max(1e-11 * trial.J, trial.noise)  # tolerance for changes of J or its axis between degrees
        settled = max(abs(trial.J - before.J), trial.angle(before) * trial.J) <= quiet
        if settled and (
            # A small shear needs no more harmonics; a shear that they hardly reduce is real.
            trial.unexplained(before) <= max(1e-6, data.relative_error) or trial.shear > 0.5 * before.shear
        ):
            break
    return trial.spin(before, data.relative_error)


def spin_report(data: SurfaceData, spin: Spin | None) -> dict[str, Any] | None:
    """Plain numbers of the spin of a surface, for JSON, with J about the given axis if there is one."""
    if spin is None:
        return None
    found: dict[str, Any] = {
        "J": spin.J.value,
        "error": spin.J.error,
        "axis": spin.axis and list(spin.axis),
        "axis_error": spin.axis_error,
        "vector": list(spin.vector),
        "shear": spin.shear,
        "method": spin.method,
    }
    if data.charge:
        part = data.electromagnetic_angular_momentum
        found["electromagnetic"] = part
        found["total"] = None if part is None else spin.J.value + part
    if data.axis is not None:
        found["given_axis"] = {"axis": list(data.axis), "J": data.angular_momentum}
    return found


def torques(data: SurfaceData, u: Floats) -> Floats:
    """K(., n) for the rotations about x, y and z (n, 3): 8 pi times the angular momentum densities.

    These are rotations of the slice coordinates or, if those are not known, of the directions u.
    """
    if data.torque is not None:
        return data.torque(u)
    if data.normal_momentum is None:
        return np.zeros_like(u)
    return np.cross(u, normal_momentum_of(data, u))


@dataclass(frozen=True)
class _Trial:
    """Rotation of maximal J, in harmonics of a fixed degree.

    Attributes
    ----------
    J : float
    noise : float
        Error of J from the errors of the data.
    axis : ndarray, shape (3,)
    shear : float
    largest_shear : float
        Largest stationary shear.
    vector : ndarray, shape (3,)
    harmonics : Harmonics
    potential : ndarray, shape (harmonics.size,)
        Coefficients of the potential of the rotation, in units of A / 4 pi.
    """

    J: float
    noise: float
    axis: Floats
    shear: float
    largest_shear: float
    vector: Floats
    harmonics: Harmonics
    potential: Floats

    @classmethod
    def of(cls, data: SurfaceData, three: Rotations) -> _Trial:
        u, dA = three.u, three.dA / (8.0 * np.pi)
        j = normal_momentum_of(data, u)
        each = np.einsum("n,ni,nik->k", dA, j, three.fields)
        J = float(np.linalg.norm(each))
        along = each / J if J > 0.0 else np.array([1.0, 0.0, 0.0])
        phi = three.fields @ along
        noise = 1e-14  # rounding, in units of A / 4 pi
        if isinstance(data.torque, UncertainFunction):
            noise += 0.5 * data.torque.error.mean
        else:
            # The relative error of K(., n) is half that of lengths.
            error = 0.5 * data.relative_error + error_of(data.normal_momentum).mean
            noise += error * float(dA @ np.linalg.norm(phi, axis=1))
            density = dA * np.einsum("ni,ni->n", j, phi)
            noise += LENGTHS * data.relative_error * float(np.abs(density).sum())
        axis = (dA * (three.potentials @ along)) @ (u if data.shape is None else data.shape(u))
        vector = dA @ torques(data, u)
        unit = three.area / (4.0 * np.pi)
        return cls(
            *(unit * J, unit * noise, axis / np.linalg.norm(axis)),
            *(three.shear(along), float(three.shears[-1]), unit * vector),
            *(three.harmonics, three.coefficients @ along),
        )

    def angle(self, other: _Trial) -> float:
        """Angle between the axes of two trials."""
        return float(np.arctan2(np.linalg.norm(np.cross(self.axis, other.axis)), self.axis @ other.axis))

    def unexplained(self, before: _Trial) -> float:
        """Extrapolated shear in a higher degree, reduced by the same factor as in the last refinement."""
        return self.shear * min(1.0, self.shear / before.shear if before.shear > 0.0 else 1.0)

    def change(self, before: _Trial) -> float:
        """Change of the potential between degrees, at most the shear."""
        difference = (
            self.potential - resized(before.potential[:, None], before.harmonics, self.harmonics)[:, 0]
        )
        return min(float(np.linalg.norm(difference)), self.shear)

    def spin(self, before: _Trial, lengths: float) -> Spin:
        """Spin, with errors from truncation, noise, shear and the error of lengths."""
        J, left = self.J, self.unexplained(before)
        # The error of J is twice the square of the shear: see the notes of `find_spin`.
        error = abs(J - before.J) + self.noise + 2.0 * left**2 * J
        # A smaller shear counts as that of a symmetry.
        vector, small = _three(self.vector), max(1e-6, LENGTHS * lengths)
        if error >= J:
            how = "J is zero within its error, and has no axis"
            return Spin(Estimate(J, error), None, None, vector, self.shear, how)
        how = (
            "of the three rotations that shear the surface least, the one with the largest J; the surface is "
        )
        if self.largest_shear <= small:
            how += "round within its error, and only K(., n) determines the axis"
        elif self.shear <= small:
            how += "symmetric about this axis"
        else:
            how += f"not symmetric about this axis, shear {self.shear:.1e}"
        turn = self.angle(before) + self.noise / J + LENGTHS * lengths + left
        zeta = InvariantCoordinate.of_potential(self.potential, self.harmonics, self.change(before) + lengths)
        return Spin(Estimate(J, error), _three(self.axis), min(turn, np.pi), vector, self.shear, how, zeta)


def _three(vector: Sequence[float] | Floats) -> tuple[float, float, float]:
    x, y, z = map(float, vector)
    return x, y, z
