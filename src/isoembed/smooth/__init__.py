"""Smooth metrics on the sphere: curvature, geodesics, triangulation, and spectral embedding."""

from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.band import Band
from isoembed.smooth.coordinates import fitting_coordinates
from isoembed.smooth.derivatives import MetricDerivatives
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.geodesics import geodesic_lengths
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.least_hyperbolic import LeastHyperbolic, least_hyperbolic
from isoembed.smooth.solve import embed_smooth
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.start import Start
from isoembed.smooth.symmetry import axis_of_symmetry
from isoembed.smooth.triangulation import SphereMesh, triangulate_metric
from isoembed.smooth.two_metric import AngleMetric, ChartMetric, PulledBack, TwoMetric
from isoembed.smooth.uncertain import UncertainFunction, Uncertainty

__all__ = [
    "AngleMetric",
    "AxisymmetricEmbedding",
    "Band",
    "ChartMetric",
    "GridMetric",
    "Harmonics",
    "LeastHyperbolic",
    "MetricDerivatives",
    "PulledBack",
    "SmoothEmbedding",
    "SphereMap",
    "SphereMesh",
    "Start",
    "TwoMetric",
    "UncertainFunction",
    "Uncertainty",
    "axis_of_symmetry",
    "embed_smooth",
    "fitting_coordinates",
    "gaussian_curvature",
    "geodesic_lengths",
    "least_hyperbolic",
    "metric_in",
    "triangulate_metric",
]
