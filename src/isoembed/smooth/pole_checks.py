"""Checks of metrics at the poles: error messages, with a diagnosis of the likely mistake."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.meshing.spreading import WHOLE, Zone
from isoembed.smooth.geodesics import definite_tensor
from isoembed.smooth.poles import RINGS, SCALES, PoleSight, ring_sights, series_sights
from isoembed.smooth.two_metric import (
    NEAR_POLE,
    AngleMetric,
    TwoMetric,
    angle_components,
    components_at,
    tensor_at,
)

CONFLICT = 5e-3  # largest relative conflict of components of a smooth tensor
VISIBLE = 1e-6  # least relative misfit attributed to a mistake
AROUND = 32  # directions on a ring


Repair = Callable[[Floats, Floats], Floats]


def _powers(tp: int, pp: int) -> Repair:
    """Q_tp and Q_pp times powers of sin theta."""
    return lambda Q, sin: np.stack([Q[..., 0], Q[..., 1] * sin**tp, Q[..., 2] * sin**pp], axis=-1)


def _left_out(Q: Floats, sin: Floats) -> Floats:
    """Components without the part explained by a missing Q_tp, if it is 0; phi is the last axis but one."""
    if np.max(np.abs(Q[..., 1])) > 1e-12 * np.max(np.abs(Q)):
        return Q
    half = 0.5 * (Q[..., 0] - Q[..., 2]).mean(axis=-1, keepdims=True)
    T = 0.5 * (Q[..., 0] + Q[..., 2])
    return np.stack([T + half, Q[..., 1], T - half], axis=-1)


EXCHANGED = "q_tt and q_pp look exchanged"
DEGREES = "they differ by (180 / pi)^2: angles are in radians, not in degrees"
LATITUDE = (
    "q_pp vanishes at the equator instead of the poles: "
    "theta counts from the north pole, not from the equator"
)
# Possible mistakes in the components: their repair, and the sentence for the error message.
MISTAKES: tuple[tuple[Repair, str], ...] = (
    (
        lambda Q, sin: Q * [1.0, -1.0, 1.0],
        "q_tp does not fit q_tt and q_pp: with the other sign it would",
    ),
    (_left_out, "q_tp is 0, and it does not fit q_tt and q_pp, which another q_tp would: it was left out"),
    (_powers(0, 2), "q_pp looks like a component in an orthonormal frame: multiply it by sin^2 theta"),
    (
        _powers(1, 2),
        "q_tp and q_pp look like components in an orthonormal frame: multiply them by sin theta and "
        "sin^2 theta",
    ),
    (_powers(1, 0), "q_tp looks like a component in an orthonormal frame: multiply it by sin theta"),
    (_powers(0, 1), "q_pp falls like sin theta, not like sin^2 theta: multiply it by sin theta"),
    (_powers(0, -2), "q_pp has the factor sin^2 theta twice"),
    (_powers(-1, -2), "q_tp and q_pp have the factors sin theta and sin^2 theta twice"),
    (_powers(-1, 0), "q_tp has the factor sin theta twice"),
    (
        lambda Q, sin: np.stack([Q[..., 2] * sin**2, Q[..., 1], Q[..., 0] / sin**2], axis=-1),
        EXCHANGED,
    ),
)


@dataclass(frozen=True)
class _Look:
    """Frame components of a metric, and values for the error message.

    Attributes
    ----------
    Q : ndarray, shape (..., m, 3)
        Components at points with m angles phi.
    sin : ndarray
        sin(theta) at these points, broadcast over Q_tt.
    near : ndarray, shape (2, 3)
        theta nearest to each pole, and the means of Q_tt and Q_pp over phi there.
    equator : tuple of float
        cos^2 theta and q_pp nearest to the equator.
    reservation : str
        Alternative explanation of an apparent cone.
    """

    Q: Floats
    sin: Floats
    near: Floats
    equator: tuple[float, float]
    reservation: str = ""

    @property
    def latitude(self) -> bool:
        """Whether q_pp decreases toward the equator as it should toward the poles."""
        square, q_pp = self.equator
        return bool(q_pp <= 3.0 * square * np.min(np.sin(self.near[:, 0]) ** 2 * self.near[:, 2]))


def check_series(theta: Floats, phi: Floats, Q: Floats) -> PoleSight:
    """Check the behavior at the poles from the Fourier series of frame components Q (n, m, 3) at nodes.

    Raises
    ------
    InvalidMetric
        The components are not those of a smooth tensor.
    """
    n, m, _ = Q.shape
    step = max(np.pi / n, 2.0 * np.pi / m if m > 1 else 0.0)
    near = np.array([[theta[k], *Q[k, :, ::2].mean(axis=0)] for k in (0, -1)])
    k = int(np.argmin(np.abs(theta - 0.5 * np.pi)))
    equator = np.cos(theta[k]) ** 2, np.sin(theta[k]) ** 2 * Q[k, :, 2].mean()
    return _checked(
        lambda Q: series_sights(theta, phi, Q),
        _Look(Q, np.sin(theta)[:, None], near, equator, ", or a tip too sharp for so few nodes"),
        max(CONFLICT, (1.0 / 3.0) * step**2),  # the latter for truncation on a coarse grid
    )


def check_rings(metric: TwoMetric) -> PoleSight:
    """Check the behavior of a metric at the poles from rings around them.

    Raises
    ------
    InvalidMetric
        The metric is not a smooth tensor.
    """
    if isinstance(metric, AngleMetric):
        _check_seam(metric, WHOLE)
    return _checked_rings(metric, WHOLE)


def check_disc(metric: TwoMetric, zone: Zone) -> None:
    """Check a metric in a zone, at a pole inside it and at the seam phi = 0.

    Raises
    ------
    InvalidMetric
        The metric is not a smooth tensor.
    """
    if isinstance(metric, AngleMetric):
        _check_seam(metric, zone)
    start, stop = zone
    widest = SCALES[0] * max(RINGS)
    if start == 0.0 and stop >= widest:
        _checked_rings(_Mirrored(metric, 1.0), zone)
    elif stop == np.pi and start <= np.pi - widest:
        _checked_rings(_Mirrored(metric, -1.0), zone)


@dataclass(frozen=True)
class _Mirrored:
    """Metric of a disc around the pole z = `pole`, with its mirror image around the other pole."""

    metric: TwoMetric
    pole: float

    def tensor(self, u: Floats) -> Floats:
        """See `TwoMetric`."""
        flip = np.ones((len(u), 3))
        flip[self.pole * u[:, 2] < 0.0, 2] = -1.0
        return flip[:, :, None] * tensor_at(self.metric, flip * u) * flip[:, None, :]


def _checked_rings(metric: TwoMetric, zone: Zone) -> PoleSight:
    # Angular components are extrapolated closer to a pole.
    by_angles = isinstance(metric.metric if isinstance(metric, _Mirrored) else metric, AngleMetric)
    near = NEAR_POLE if by_angles else 0.0
    scales = np.array([scale for scale in SCALES if scale >= near])
    radii = np.multiply.outer(scales, RINGS)
    phi = 0.1 + 2.0 * np.pi / AROUND * np.arange(AROUND)
    # Latitudes are detected near the equator, which a disc may not reach.
    last_theta = 0.5 * np.pi - radii[0, 0] if zone == WHOLE else radii[0, 0]
    theta = np.append(np.stack([radii, np.pi - radii]), last_theta)
    sin = np.append(np.stack([np.sin(radii)] * 2), np.sin(last_theta))  # not rounded, near pi
    flat = sin[:, None]
    u = np.stack(np.broadcast_arrays(flat * np.cos(phi), flat * np.sin(phi), np.cos(theta)[:, None]), axis=2)
    u = u.reshape(-1, 3)
    Q = angle_components(u, definite_tensor(metric, u)).reshape(len(theta), len(phi), 4)[..., [0, 1, 3]]
    means = Q.mean(axis=1)
    last = radii.size - len(RINGS)
    near_poles = np.array([[theta[k], *means[k, ::2]] for k in (last, radii.size + last)])
    look = _Look(
        Q[:-1].reshape(2, *radii.shape, len(phi), 3),
        np.sin(radii)[:, :, None],
        near_poles,
        (np.cos(theta[-1]) ** 2 if zone == WHOLE else 0.0, sin[-1] ** 2 * means[-1, 2]),
    )
    return _checked(ring_sights, look, CONFLICT)


def _check_seam(metric: AngleMetric, zone: Zone) -> None:
    """Check that components are periodic in phi."""
    theta: Floats = np.linspace(*zone, AROUND + 1)[1:-1]
    ends = [np.full_like(theta, phi) for phi in (1e-9, 2.0 * np.pi - 1e-9)]
    start, stop = (components_at(metric, theta, phi) for phi in ends)
    sin = np.sin(theta)
    size = max(np.max(np.abs(start[0])), np.max(np.abs(start[2]) / sin**2))
    for name, before, after, power in zip(("q_tt", "q_tp", "q_pp"), start, stop, range(3), strict=True):
        torn = ~(np.abs(np.subtract(after, before)) <= 1e-3 * size * sin**power)
        if torn.any():
            i = int(np.argmax(torn))
            raise InvalidMetric(
                f"{name} is {before[i]:.6g} at phi = 0 and {after[i]:.6g} at phi = 2 pi, for theta = "
                f"{theta[i]:.4g}: that is the same point (angles are in radians)"
            )


def _checked(sights: Callable[[Floats], list[PoleSight]], look: _Look, allowed: float) -> PoleSight:
    """Behavior of components at the poles; raises for too large a conflict or one explained by a mistake."""
    (limits,) = sights(look.Q[..., None, :])
    if np.max(limits.misfits) <= VISIBLE:
        return limits
    with np.errstate(all="ignore"):
        repaired = sights(np.stack([repair(look.Q, look.sin) for repair, _ in MISTAKES], axis=-2))
    cause = _cause(limits.misfits, np.array([sight.misfits for sight in repaired]))
    if look.latitude and cause != EXCHANGED:
        cause = LATITUDE
    if not cause and limits.conflict <= allowed:
        return limits
    if not cause and limits.is_cone:
        cause = DEGREES if _by_degrees(limits) else f"a cone{look.reservation}"
    raise InvalidMetric(f"the metric is not smooth at the poles: {_seen(limits, look)}; {cause}".rstrip("; "))


def _by_degrees(sight: PoleSight) -> bool:
    """Whether q_tt and q_pp differ at a pole by a factor of the squared degree in radians."""
    ratio = np.abs(sight.means[:, 1] / sight.means[:, 0])
    return bool(np.any(np.abs(np.abs(np.log(ratio)) / np.log(np.radians(1.0) ** -2) - 1.0) < 1e-3))


def _cause(misfits: Floats, repaired: Floats) -> str:
    """First of the mistakes whose repair reduces the misfits (orders,), from the lowest order on."""
    for order, misfit in enumerate(misfits):
        lowest = np.max(repaired[:, : order + 1], axis=1)
        # A mistake is the cause if its repair divides the misfit by 30.
        good = (misfit > VISIBLE) & (lowest * 30.0 < misfit)
        if good.any():
            # Without q_tp several repairs are equally good; the first is the simplest.
            best = np.min(lowest[good])
            return MISTAKES[int(np.argmax(good & (lowest <= max(2.0 * best, VISIBLE))))][1]
    return ""


def check_within(sight: PoleSight, tolerance: float) -> None:
    """Check that a smooth surface can have the lengths at the poles within an error, if these are resolved.

    Raises
    ------
    InvalidMetric
        No smooth surface can; the message describes the behavior at the poles.
    """
    if sight.jump > 8.0 * tolerance:  # no smooth surface within the tolerance
        raise InvalidMetric(
            f"the metric is not smooth at the poles: {_seen(sight)}; as far as these are resolved, every "
            f"smooth surface misses such lengths by more than {tolerance:.2g}"
        )


def _seen(sight: PoleSight, look: _Look | None = None) -> str:
    """Clause on the behavior at the poles that a smooth tensor does not have."""
    pole = sight.worst
    at, (tt, pp) = f"theta = {'pi' if pole else '0'}", sight.means[pole]
    jump, largest = sight.conflicts[pole, 0], np.max(sight.conflicts[pole])
    if not sight.is_cone:
        size = jump if jump > VISIBLE else largest
        return (
            f"at {at} the components vary with phi, by {size:.2g} of their size, in a way that those of a "
            "smooth tensor cannot"
        )
    doubtful = jump <= sight.doubts[pole, 0]
    if look and (doubtful or not 0.5 * abs(tt) < abs(pp) < 2.0 * abs(tt)):
        theta, tt, pp = look.near[pole]
        at = f"theta = {theta:.4g}"
    return (
        f"there q_tt and q_pp / sin^2 theta are equal in the mean over phi, but they are {tt:.6g} and "
        f"{pp:.6g} at {at}"
    )
