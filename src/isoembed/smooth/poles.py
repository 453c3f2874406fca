"""Regularity of a metric at the poles: misfit of its Fourier modes to those of a smooth tensor.

In the orthonormal frame (e_theta, e_phi) the mean T = (Q_tt + Q_pp) / 2 of a smooth tensor is a function, and
S = (Q_tt - Q_pp) / 2 +- i Q_tp has spin weights +-2: near a pole its component with exp(i m phi) decays like
sin^|m - s| theta [1]_.  A slower decay is a conflict.

References
----------
.. [1] J. N. Goldberg et al., "Spin-s spherical harmonics and eth", J. Math. Phys. 8 (1967), 2155-2161.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.smooth.double_fourier import DoubleFourier

Modes = NDArray[np.complex128]

ORDERS = 5  # orders 0 to 4 in the distance from a pole
REACH = 0.1  # distance from a pole at which orders are compared, in radians
RINGS = (2.0, 3.0, 4.0)  # distances of rings from a pole, relative to a scale
SCALES = (0.03, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)  # radians; angular components use the first three


@dataclass(frozen=True)
class PoleSight:
    """Behavior of the frame components of a metric at the poles theta = 0 and pi.

    Attributes
    ----------
    conflicts, doubts : ndarray, shape (2, orders)
        Parts of each order in the distance from a pole that a smooth tensor does not have, at a tenth of a
        radian, relative to the tensor at the pole; and bounds on the effect of truncation on them.
    means : ndarray, shape (2, 2)
        Means of Q_tt and Q_pp over phi at the poles.
    """

    conflicts: Floats
    doubts: Floats
    means: Floats

    @property
    def _certain(self) -> Floats:
        """Conflicts above their doubts; 0 for others."""
        return np.where(self.conflicts > self.doubts, self.conflicts, 0.0)

    @property
    def conflict(self) -> float:
        """Largest conflict above its doubt."""
        return float(np.max(self._certain))

    @property
    def jump(self) -> float:
        """Largest conflict of order 0 above its doubt: lengths at a pole disagree by at least half of it."""
        return float(np.max(self._certain[:, 0]))

    @property
    def misfits(self) -> Floats:
        """Sum of conflict and doubt of each order, at most 1: deviation from a smooth tensor."""
        return np.minimum(np.max(self.conflicts + self.doubts, axis=0), 1.0)

    @property
    def worst(self) -> int:
        """Pole with the larger conflict: 0 for theta = 0, 1 for pi."""
        return int(np.argmax(np.max(self.conflicts, axis=1)))

    @property
    def is_cone(self) -> bool:
        """Whether the conflict at the worst pole is a difference of the means of Q_tt and Q_pp."""
        conflicts, (tt, pp) = self.conflicts[self.worst], self.means[self.worst]
        return bool(4.0 * abs(tt - pp) > np.max(conflicts) * abs(tt + pp))


def series_sights(theta: Floats, phi: Floats, Q: Floats) -> list[PoleSight]:
    """Behavior at the poles from Fourier series, for h alternatives of components Q (n, m, h, 3) at nodes."""
    n, m, h, _ = Q.shape
    a = DoubleFourier(theta, phi, Q.reshape(n, m, 3 * h)).coefficients
    sizes, orders = np.abs(a), a.shape[1]
    high = np.max(sizes[n - max(2, n // 10) :], axis=(0, 1))
    if orders > 2:
        high = np.maximum(high, np.max(sizes[:, orders - max(2, orders // 10) :], axis=(0, 1)))
    j = np.arange(ORDERS)
    doubts = 3.0 * n * np.max(high.reshape(h, 3), axis=1)[:, None] * (n * REACH) ** j
    a = a[:, : (m + 1) // 2]  # without the order m / 2, whose phase is undetermined
    taylor = np.zeros((2, ORDERS, *a.shape[1:]), dtype=np.complex128)
    for order in j:
        parity = order % 2
        k = np.arange(n) + parity  # cosines for even orders, sines for odd orders
        slopes = (-1.0) ** (order // 2) * (k * REACH) ** order / factorial(order)
        for pole, sign in enumerate((1.0, -1.0)):
            taylor[pole, order, parity::2] = np.tensordot(slopes * sign**k, a[:, parity::2], axes=1)
    parts = np.moveaxis(taylor.reshape(*taylor.shape[:3], h, 3), 3, 0)
    floors = 1e-9 * np.max(np.abs(Q), axis=(0, 1, 3))  # a tensor may vanish at a pole
    return [_seen(parts[i], doubts[i], float(floors[i])) for i in range(h)]


def _seen(taylor: Modes, doubts: Floats, floor: float) -> PoleSight:
    """Behavior from the terms (2, orders, modes, 3) of the Taylor series in the distance from each pole."""
    means = taylor[:, 0, 0, ::2].real
    size = np.maximum(np.abs(means.mean(axis=1)), floor)[:, None]
    conflicts = np.array([[_forbidden(part, j, p) for j, part in enumerate(taylor[p])] for p in range(2)])
    return PoleSight(conflicts / size, doubts / size, means)


def ring_sights(Q: Floats) -> list[PoleSight]:
    """Behavior at the poles from rings, for h alternatives of components Q (2, s, r, m, h, 3) on them.

    The r rings are `RINGS` times each of the first s `SCALES`.  A conflict is the minimum over all scales,
    because sharp tips are smooth at small scales.
    """
    m = Q.shape[3]
    modes = np.fft.rfft(Q, axis=3)[:, :, :, : (m + 1) // 2] / m
    modes[:, :, :, 1:] *= 2.0
    rings = np.array(RINGS)
    # Extrapolation of even functions of the distance to 0.
    weights = np.linalg.solve(np.vander(rings**2, increasing=True).T, np.eye(len(rings))[0])
    plain = np.linalg.solve(np.vander(rings, increasing=True).T, np.eye(len(rings))[0])
    sights = []
    for i in range(Q.shape[4]):
        conflicts, means = np.full((2, ORDERS), np.inf), np.empty((2, 2))
        for p, k in np.ndindex(modes.shape[:2]):
            parts = modes[p, k, ..., i, :]
            means[p] = (weights @ parts[:, 0]).real[::2]
            shrink = REACH / (SCALES[k] * rings)
            orders = [np.tensordot(weights * shrink**j, parts, axes=1) for j in range(ORDERS)]
            orders[0][1::2] = np.tensordot(plain, parts[:, 1::2], axes=1)  # odd parts that do not vanish
            found = np.array([_forbidden(part, j, p) for j, part in enumerate(orders)])
            conflicts[p] = np.minimum(conflicts[p], found / np.abs(means[p].mean()))
        sights.append(PoleSight(conflicts, np.zeros_like(conflicts), means))
    return sights


def _forbidden(modes: Modes, order: int, pole: int) -> float:
    """Largest part of components (modes, 3) of an order in the distance from a pole that should decay faster.

    The parity of the order is that of m; parts of order 0 without this parity are forbidden, too.  The result
    is twice the amplitude: 1 % if q_tt and q_pp / sin^2 theta differ by 1 %.
    """
    m = np.arange(order % 2, len(modes), 2 if order else 1)
    tt, tp, pp = modes[m].T
    T, D, turned = 0.5 * (tt + pp), 0.5 * (tt - pp), (1j if pole == 0 else -1j) * tp
    parts = ((T, m), (D - turned, np.abs(m - 2)), (D + turned, m + 2))
    return 2.0 * max(np.max(np.abs(part[falls > order]), initial=0.0) for part, falls in parts)
