"""What stands in the way of a smooth embedding, where it can be seen."""

from __future__ import annotations

import numpy as np

from isoembed.errors import InvalidMetric
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.harmonics import gauss_rule
from isoembed.smooth.two_metric import TwoMetric

SAMPLED = (48, 96)  # heights and angles at which the curvature is looked at


def obstruction(metric: TwoMetric) -> str:
    """Say why a metric may not embed in R^3, in one clause; nothing if K > 0 wherever it was looked at.

    Of a metric that is symmetric about z the surface of revolution is tried exactly.  Of others the sign of
    the Gaussian curvature is all that is known: with K > 0 they embed, with K < 0 they may or may not.
    """
    try:
        profile = AxisymmetricEmbedding.of(metric)
    except InvalidMetric:  # not symmetric about z
        u, _ = gauss_rule(*SAMPLED)
        K = gaussian_curvature(metric, u)
        k = int(np.argmin(K))
        if K[k] >= 0.0:
            return ""
        theta, phi = np.arccos(u[k, 2]), np.arctan2(u[k, 1], u[k, 0]) % (2.0 * np.pi)
        return (
            f"the Gaussian curvature is negative in places, least {K[k]:.4g} at theta = {theta:.3f}, "
            f"phi = {phi:.3f}: whether the metric embeds is not known"
        )
    return "" if profile.embeds else profile.explanation
