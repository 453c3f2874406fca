"""Axes of symmetry of a metric."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.geodesics import definite_tensor
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.two_metric import TwoMetric, angle_frame, area_density, is_axisymmetric

STEP = 1e-3  # step of finite differences for gradients, in radians


def axis_of_symmetry(metric: TwoMetric) -> Floats | None:
    """Rotation R (3, 3) that maps the z-axis to a symmetry axis of a metric; None if there is none.

    ``metric_in(metric, SphereMap.linear(R))`` then satisfies `is_axisymmetric`.  R is the unit matrix for a
    metric symmetric about z, such as that of a sphere.

    Raises
    ------
    InvalidMetric
        The metric is not positive definite at one of the sampled directions.

    Notes
    -----
    A function f symmetric about a satisfies ``a . (u x grad f) = 0`` for all u: the axis is the null vector
    of one equation per direction.  The area density and the trace are such functions.
    """
    if is_axisymmetric(metric):
        return np.eye(3)
    u = fibonacci_directions(150)
    _, sizes, axes = np.linalg.svd(_turning(metric, u))
    if sizes[2] > 1e-3 * sizes[1]:  # no null vector
        return None
    axis = _polished(metric, u, axes[2])
    R = _onto(axis if axis[2] >= 0.0 else -axis)
    return R if is_axisymmetric(metric_in(metric, SphereMap.linear(R))) else None


def _invariants(metric: TwoMetric, u: Floats) -> Floats:
    """Two frame-independent functions (n, 2): logarithm of the area density, and trace over density."""
    q = definite_tensor(metric, u)
    density = area_density(q)
    return np.stack([np.log(density), np.trace(q, axis1=1, axis2=2) / density], axis=1)


def _turning(metric: TwoMetric, u: Floats) -> Floats:
    """``u x grad f`` (2 n, 3) of both invariants f: their derivatives under rotations about x, y and z."""
    rows = []
    for e in angle_frame(u):
        slope = np.zeros((len(u), 2))
        for k, weight in ((1.0, 8.0), (2.0, -1.0)):
            for sign in (-1.0, 1.0):
                angle = sign * k * STEP
                moved = np.cos(angle) * u + np.sin(angle) * e
                slope += sign * weight / (12.0 * STEP) * _invariants(metric, moved)
        rows.append(np.cross(u, e)[:, None, :] * slope[:, :, None])
    return (rows[0] + rows[1]).reshape(-1, 3)


def _polished(metric: TwoMetric, u: Floats, axis: Floats) -> Floats:
    """Nearby axis about which the invariants change least."""

    def changes(axis: Floats) -> Floats:
        axis = axis / np.linalg.norm(axis)
        # Angles that are not simple fractions of a turn.
        values = [_invariants(metric, _turned(u, axis, angle)) for angle in (0.0, 1.1, 2.9)]
        return np.diff(values, axis=0).ravel()

    for _ in range(3):  # Newton's method
        tilts = 1e-4 * _onto(axis).T[:2]
        slopes = np.stack([changes(axis + t) - changes(axis - t) for t in tilts], axis=1) / 2.0
        axis = axis - np.linalg.lstsq(slopes, changes(axis), rcond=None)[0] @ tilts
        axis /= np.linalg.norm(axis)
    return axis


def _turned(u: Floats, axis: Floats, angle: float) -> Floats:
    """Rotation of u (n, 3) by Rodrigues' formula."""
    along = (u @ axis)[:, None] * axis
    return along + np.cos(angle) * (u - along) + np.sin(angle) * np.cross(axis, u)


def _onto(axis: Floats) -> Floats:
    """Smallest rotation (3, 3) that maps z to a unit vector; the half turn about x for -z."""
    x, y, z = axis
    if z < 0.0:
        return _onto(-axis) @ np.diag([1.0, -1.0, -1.0])
    c = 1.0 / (1.0 + z)
    return np.array([[1.0 - c * x * x, -c * x * y, x], [-c * x * y, 1.0 - c * y * y, y], [-x, -y, z]])
