"""What the curvature of a metric says of its embedding."""

from __future__ import annotations

import numpy as np

from isoembed.meshing.sphere import gauss_rule
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.two_metric import TwoMetric

SAMPLED = (48, 96)  # heights and angles at which the curvature is looked at


def by_curvature(metric: TwoMetric) -> str:
    """Say what the sign of the Gaussian curvature means for the embedding of a metric, in one clause."""
    u, _ = gauss_rule(*SAMPLED)
    K = gaussian_curvature(metric, u)
    k = int(np.argmin(K))
    if K[k] > 0.0:
        return "where it was looked at the Gaussian curvature is positive, so that an embedding should exist"
    theta, phi = np.arccos(u[k, 2]), np.arctan2(u[k, 1], u[k, 0]) % (2.0 * np.pi)
    return (
        f"the Gaussian curvature is negative in places, least {K[k]:.4g} at theta = {theta:.3f}, "
        f"phi = {phi:.3f}: whether the metric embeds is not known"
    )
