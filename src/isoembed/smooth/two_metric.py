"""Smooth 2-metrics on the sphere: tensors, frames, definiteness, symmetry about z, changes of coordinates.

It is kept as a symmetric 3x3 matrix q with q u = 0, so that the length of the velocity v of a path of unit
vectors is sqrt(v . q v).  No coordinate is singular anywhere; theta and phi appear only where data have them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import angles_of, fibonacci_directions
from isoembed.smooth.uncertain import EXACT, Uncertainty
from isoembed.smooth.user_functions import array_of, called, real_values

NEAR_POLE = 1e-3  # sin(theta) below which components are extrapolated over the pole
ROUNDING = 1e-12  # relative, of functions of directions
IN_ANGLES = ("q_tt", "q_tp", "q_pp"), ("theta", "phi")


class TwoMetric(Protocol):
    """A smooth Riemannian metric on the sphere of directions."""

    def tensor(self, u: Floats) -> Floats:
        """The metric (n, 3, 3) at unit vectors u (n, 3): symmetric, with q u = 0, in units of length^2."""
        ...


@dataclass(frozen=True)
class AngleMetric:
    """A metric whose components in theta and phi are given by a function.

    Attributes
    ----------
    components : callable
        Takes arrays theta and phi of one shape and returns q_tt, q_tp and q_pp, in units of length^2.  It is
        never called at the poles.
    """

    components: Callable[[Floats, Floats], tuple[ArrayLike, ArrayLike, ArrayLike]]

    def tensor(self, u: Floats) -> Floats:
        """See `TwoMetric`.

        Raises
        ------
        InvalidMetric
            The function returns values that are not finite or not positive; the message names theta and phi.
        """
        u = np.asarray(u, dtype=np.float64)
        near = np.hypot(u[:, 0], u[:, 1]) < NEAR_POLE
        q = np.empty((len(u), 3, 3))
        q[~near] = self._away(u[~near])
        if near.any():
            q[near] = self._over_pole(u[near])
        return q

    def _over_pole(self, u: Floats) -> Floats:
        """Even Richardson extrapolation over four points on a line through each point, along x."""
        # Of sixth order in the step.  Two steps away from here nothing is nearer to the pole than one step.
        total = np.zeros((len(u), 3, 3))
        for step, weight in ((2.0, 12.0 / 5.0), (3.0, -64.0 / 35.0), (4.0, 3.0 / 7.0)):
            for sign in (-1.0, 1.0):
                moved = u + np.array([sign * step * NEAR_POLE, 0.0, 0.0])
                total += 0.5 * weight * self._away(moved / np.linalg.norm(moved, axis=1, keepdims=True))
        return projected(total, u)

    def _away(self, u: Floats) -> Floats:
        theta, phi = angles_of(u)
        tt, tp, pp = q = components_at(self, theta, phi)
        _check_definite(q, IN_ANGLES, theta, phi)
        sin = np.hypot(u[:, 0], u[:, 1])
        return from_angles(u, tt, tp / sin, pp / sin**2)


def components_at(metric: AngleMetric, theta: Floats, phi: Floats) -> Floats:
    """The components (3, n) at angles (n,).

    Raises
    ------
    InvalidMetric
        They are not three, or one is not finite; the message names the first one, and its angles.
    InvalidParameter
        The function takes no arrays, or returns no real numbers.
    """
    return _evaluated(metric.components, IN_ANGLES, theta, phi)


def _evaluated(
    components: Callable[[Floats, Floats], Any],
    names: tuple[tuple[str, str, str], tuple[str, str]],
    first: Floats,
    second: Floats,
) -> Floats:
    """Values (3, n) of a function of two named coordinates (n,); raises as `components_at`."""
    of_components, coordinates = names
    subject = "the function for the metric"
    result = called(subject, components, first, second)
    if not isinstance(result, tuple | list | np.ndarray) or len(result) != 3:
        shape = f" of shape {result.shape}" if isinstance(result, np.ndarray) else ""
        count = f" of length {len(result)}" if isinstance(result, tuple | list) else shape
        raise InvalidMetric(
            f"{subject} returns a {type(result).__name__}{count}, not the three "
            f"{', '.join(of_components[:2])} and {of_components[2]}"
        )
    q = np.empty((3, *first.shape))
    for name, component, values in zip(of_components, result, q, strict=True):
        array = array_of(subject, component)
        if array.shape not in ((), (1,), first.shape):
            raise InvalidMetric(
                f"{name} has the shape {array.shape} for {' and '.join(coordinates)} of shape {first.shape}"
            )
        values[...] = array
        if not np.isfinite(values).all():
            i = int(np.argmin(np.isfinite(values)))
            raise InvalidMetric(
                f"{name} is {values[i]} at {coordinates[0]} = {first[i]:.6g}, {coordinates[1]} = "
                f"{second[i]:.6g}: it must be finite"
            )
    return q


def _check_definite(
    q: Floats, names: tuple[tuple[str, str, str], tuple[str, str]], first: Floats, second: Floats
) -> None:
    """Check that components (3, n) are positive definite; raises InvalidMetric at the first that are not."""
    good = are_definite(*q)
    if not good.all():
        i = int(np.argmin(good))
        of_components, (one, other) = names
        values = ", ".join(f"{x:.6g}" for x in q[:, i])
        raise InvalidMetric(
            f"{', '.join(of_components)} = {values} at {one} = {first[i]:.6g}, {other} = {second[i]:.6g}: "
            "that is not a positive definite metric"
        )


@dataclass(frozen=True)
class ChartMetric:
    """A metric on a disc or a band of the plane, whose components in x and y are given by a function.

    The point (x, y) is in the direction with theta = (x^2 + y^2)^(1/2), less than pi, and tan(phi) = y / x.

    Attributes
    ----------
    components : callable
        Takes arrays x and y of one shape and returns g_xx, g_xy and g_yy, in units of length^2 over those of
        x and y.
    """

    components: Callable[[Floats, Floats], tuple[ArrayLike, ArrayLike, ArrayLike]]

    @staticmethod
    def coordinates(u: ArrayLike) -> Floats:
        """The points (n, 2) that directions u (n, 3) stand for."""
        theta, phi = angles_of(np.asarray(u, dtype=np.float64))
        return theta[:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=1)

    def tensor(self, u: Floats) -> Floats:
        """See `TwoMetric`.

        Raises
        ------
        InvalidMetric
            The function returns values that are not finite or not positive; the message names x and y.
        """
        x, y = self.coordinates(u).T
        names = ("g_xx", "g_xy", "g_yy"), ("x", "y")
        xx, xy, yy = g = _evaluated(self.components, names, x, y)
        _check_definite(g, names, x, y)
        _, phi = angles_of(u)
        cos, sin, stretch = np.cos(phi), np.sin(phi), 1.0 / np.sinc(np.hypot(x, y) / np.pi)
        tt = xx * cos**2 + 2.0 * xy * cos * sin + yy * sin**2
        tp = stretch * ((yy - xx) * cos * sin + xy * (cos**2 - sin**2))
        pp = stretch**2 * (xx * sin**2 - 2.0 * xy * cos * sin + yy * cos**2)
        return from_angles(u, tt, tp, pp)


@dataclass(frozen=True)
class PulledBack:
    """The metric that a map X from the sphere into R^3 (or into a 3-geometry) induces.

    Attributes
    ----------
    differential : callable
        Takes unit vectors u (n, 3) and returns dX (n, 3, 3): ``dX @ v`` is the derivative of X along v.
    ambient : callable, optional
        Takes the same u and returns the 3-metric (n, 3, 3) at X(u); by default the Euclidean one.
    error : Uncertainty
        Of lengths, relative.
    """

    differential: Callable[[Floats], Floats]
    ambient: Callable[[Floats], Floats] | None = None
    error: Uncertainty = EXACT

    def tensor(self, u: Floats) -> Floats:
        """See `TwoMetric`."""
        dX = _matrices("the differential", self.differential, u)
        if self.ambient is None:
            q = np.einsum("nki,nkj->nij", dX, dX)
        else:
            ambient = _matrices("the ambient metric", self.ambient, u)
            q = np.einsum("nki,nkl,nlj->nij", dX, ambient, dX)
        return projected(q, u)


def _matrices(name: str, function: Callable[[Floats], Floats], u: Floats) -> Floats:
    """Values (n, 3, 3) of a function at unit vectors u (n, 3)."""
    values = real_values(name, function, u)
    if values.shape != (len(u), 3, 3):
        raise InvalidMetric(
            f"{name} has the shape {values.shape} for u of shape {u.shape}, not {(len(u), 3, 3)}"
        )
    return values


def check_two_metric(metric: object) -> None:
    """Raise `InvalidMetric` for an object that is not a metric, such as a function."""
    if not callable(getattr(metric, "tensor", None)):
        advice = (
            "AngleMetric makes one of a function of theta and phi" if callable(metric) else "see AngleMetric"
        )
        raise InvalidMetric(
            f"the metric is a {type(metric).__name__}, which has no method tensor(u): {advice}"
        )


def tensor_at(metric: TwoMetric, u: Floats) -> Floats:
    """Tensor (n, 3, 3) of a metric at unit vectors u (n, 3).

    Raises
    ------
    InvalidMetric
        The tensor has another shape.
    """
    q = metric.tensor(u)
    if np.shape(q) != (len(u), 3, 3):
        raise InvalidMetric(
            f"the metric's tensor(u) has the shape {np.shape(q)} for u of shape {u.shape}, not "
            f"{(len(u), 3, 3)}"
        )
    return q


def from_angles(u: Floats, Qtt: Floats, Qtp: Floats, Qpp: Floats) -> Floats:
    """The tensor (n, 3, 3) from components in the orthonormal frame (e_theta, e_phi), away from the poles."""
    e_theta, e_phi = angle_frame(u)
    along_theta = Qtt[:, None] * e_theta + Qtp[:, None] * e_phi
    along_phi = Qtp[:, None] * e_theta + Qpp[:, None] * e_phi
    q = np.empty((len(u), 3, 3))
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        q[:, i, j] = q[:, j, i] = e_theta[:, i] * along_theta[:, j] + e_phi[:, i] * along_phi[:, j]
    return q


def angle_frame(u: Floats) -> tuple[Floats, Floats]:
    """The unit vectors e_theta and e_phi (n, 3); at the poles those of phi = 0."""
    sin = np.hypot(u[:, 0], u[:, 1])
    pole = sin == 0.0
    cos_phi = np.where(pole, 1.0, u[:, 0]) / np.where(pole, 1.0, sin)
    sin_phi = np.where(pole, 0.0, u[:, 1]) / np.where(pole, 1.0, sin)
    e_theta = np.stack([u[:, 2] * cos_phi, u[:, 2] * sin_phi, -sin], axis=1)
    return e_theta, np.stack([-sin_phi, cos_phi, np.zeros(len(u))], axis=1)


def angle_components(u: Floats, q: Floats) -> Floats:
    """The components (n, 2, 2) of tensors (n, 3, 3) in the orthonormal frame (e_theta, e_phi) at u (n, 3)."""
    e = np.stack(angle_frame(u), axis=1)
    return np.asarray(np.einsum("nai,nij,nbj->nab", e, q, e))


def are_definite(tt: Floats, tp: Floats, pp: Floats) -> Mask:
    """Mask of components in an orthogonal frame, of one shape, that are finite and positive definite."""
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        finite = np.isfinite(tt) & np.isfinite(tp) & np.isfinite(pp)
        return finite & (tt > 0) & (pp > 0) & (np.abs(tp) / np.sqrt(tt) < np.sqrt(pp))


def is_axisymmetric(metric: TwoMetric) -> bool:
    """Whether the metric is symmetric about the z-axis, as far as it can be seen.

    Notes
    -----
    Integrals over the surface are not changed to first order by a deviation, if they are means over phi.
    """
    check_two_metric(metric)
    # Slopes of surfaces in harmonics of degree 64 magnify rounding.
    return is_symmetric_about_z(lambda u: angle_components(u, tensor_at(metric, u)), 1e-11)


def is_symmetric_about_z(function: Callable[[Floats], Floats], rounding: float = ROUNDING) -> bool:
    """Whether a function of directions (n, 3) does not change with phi, at sampled directions.

    It is compared with itself rotated by some angles, at scattered directions.  `rounding` is the change
    allowed, relative to its largest value.
    """
    x, y, z = fibonacci_directions(400).T
    values = []
    for angle in (0.0, 0.7, 1.9, 4.3):  # no fractions of a turn
        c, s = np.cos(angle), np.sin(angle)
        values.append(function(np.stack([c * x - s * y, s * x + c * y, z], axis=1)))
    return bool(np.ptp(values, axis=0).max() <= rounding * np.abs(values).max())


def projected(q: Floats, u: Floats) -> Floats:
    """The part of symmetric tensors (n, 3, 3) that is tangent to the sphere at u (n, 3)."""
    P = np.eye(3) - u[:, :, None] * u[:, None, :]
    tangent = P @ q @ P
    return 0.5 * (tangent + tangent.transpose(0, 2, 1))


def area_density(q: Floats) -> Floats:
    """The area (n,) of the metrics q (n, 3, 3) over that of the unit sphere: the root of the determinant."""
    trace = q[:, 0, 0] + q[:, 1, 1] + q[:, 2, 2]  # np.trace takes ten times as long
    shape = q / trace[:, None, None]  # squares of squared lengths would under- or overflow
    return trace * np.sqrt(np.maximum(0.5 * (1.0 - np.einsum("nij,nij->n", shape, shape)), 0.0))


def orthonormal_frame(u: Floats, q: Floats) -> Floats:
    """Two tangent vectors (n, 2, 3) at each u with e_a . q e_b = delta_ab; e_1 x e_2 points along u.

    Raises
    ------
    InvalidMetric
        A metric is not positive definite; the message says at which angles.
    """
    e_theta, e_phi = angle_frame(u)
    components = angle_components(u, q)
    good = are_definite(components[:, 0, 0], components[:, 0, 1], components[:, 1, 1])
    if not good.all():
        i = int(np.argmin(good))
        theta, phi = angles_of(u)
        raise InvalidMetric(
            f"the metric is not positive definite at theta = {theta[i]:.6g}, phi = {phi[i]:.6g}: "
            f"along and across the meridian it is {components[i].tolist()}"
        )
    first = np.einsum("ni,nij->nj", e_theta, q)
    first_length = np.sqrt(np.einsum("ni,ni->n", first, e_theta))[:, None]
    e_1 = e_theta / first_length
    along = np.einsum("ni,ni->n", first, e_phi)[:, None] / first_length
    rest = e_phi - along * e_1
    rest /= np.sqrt(np.einsum("ni,nij,nj->n", rest, q, rest))[:, None]
    return np.stack([e_1, rest], axis=1)
