"""Conformal change of a polyhedral metric: logarithmic scale factors at the vertices scale the edges."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric


def rescaled(metric: PolyhedralMetric, u: Floats) -> PolyhedralMetric:
    """The metric with lengths ``l_ab (e^{u_a} + e^{u_b}) / 2`` (paper, Eq. (len)).

    Parameters
    ----------
    metric : PolyhedralMetric
        rho_0.
    u : ndarray, shape (V,)
        Conformal factors.

    Raises
    ------
    InvalidMetric
        The factors break a triangle inequality.
    """
    a, b = metric.edges.T
    w = np.exp(u)
    return metric.on(metric.triangulation, metric.lengths * (w[a] + w[b]) / 2, metric.space)


def equivalent(metric: GluedMetric, u: Floats) -> GluedMetric:
    """The discretely conformally equivalent metric with lengths ``l_ab e^{(u_a + u_b) / 2}``.

    On the sphere and in the hyperbolic plane it is the chords ``2 sn(l / 2)`` that are multiplied (Bobenko,
    Pinkall and Springborn, Discrete conformal maps and ideal hyperbolic polyhedra, Geom. Topol. 19, 2015).

    Parameters
    ----------
    metric : GluedMetric
    u : ndarray, shape (V,)

    Raises
    ------
    InvalidMetric
        The factors break a triangle inequality, or lead beyond the floats.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # lengths beyond the floats are refused
        w = np.exp(u / 2)[metric.faces]
        chords = metric.space.chord(metric.face_lengths) * w * np.roll(w, -1, axis=1)
        return metric.with_lengths(metric.space.arc(chords))
