"""Spherical harmonic fit of a closed triangle mesh: directions of its vertices, and degree.

The directions of the vertices on the sphere are unknown; the distances along the normal are minimized.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.meshing.sphere import hull_faces, solid_angles
from isoembed.meshing.sphere_layout import are_outward, least_distorted, sphere_layout
from isoembed.metric.curvature import area
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import LEVERAGE
from isoembed.smooth.vertex_fit import VertexFit

DEGREES = (1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48)  # in order of refinement
ROUNDING = 1e-13  # misfit attributed to rounding, in mean radii


@dataclass(frozen=True)
class MeshFit:
    """Harmonics fitted to the vertices of a mesh.

    Attributes
    ----------
    coefficients : ndarray, shape (size, 3)
    harmonics : Harmonics
    misfit : float
        Root mean square of the distances of the vertices.
    deviations : ndarray, shape (N, size of the harmonics of two degrees more, 3)
        Random samples of the error: coefficients in the harmonics of ``deviating(harmonics)``.
    directions : ndarray, shape (V, 3)
        Unit vectors of the points of the surface nearest to the vertices.
    """

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    deviations: Floats
    directions: Floats


def fit_mesh(vertices: Floats, faces: Indices) -> MeshFit:
    """Fit harmonics to a closed triangle mesh of genus 0.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray of int, shape (F, 3)
        Triangles, counterclockwise as seen from outside.

    Raises
    ------
    InvalidMetric
        The faces are not a triangulated sphere, or a triangle is degenerate.

    Notes
    -----
    The triangulation is mapped to the sphere with little distortion.  Then, for each degree, harmonics are
    fitted by least squares with a small weight of tangential distances, and the direction of each vertex is
    moved to that of the nearest point of the surface, until the normal distances cease to decrease [1].  The
    parametrization thus adapts to the harmonics.  The degree is chosen by generalized cross-validation.

    References
    ----------
    [1] J. Hoschek, Comput. Aided Geom. Des. 5 (1988) 27; W. Wang, H. Pottmann and Y. Liu, ACM TOG 25 (2006).
    """
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    unit = float(np.sqrt(area(metric) / (4.0 * np.pi)))
    middle = vertices.mean(axis=0)
    x = (vertices - middle) / unit
    u, faces = _laid_out(metric, x)
    start = VertexFit(x, u, solid_angles(u, faces), np.ones(len(x)), Harmonics(0, 0), np.zeros((1, 3)))
    fit = _best_degree(start, DEGREES, faces)
    assert fit is not None
    if fit.misfit > 1e-4:  # a poor fit is restarted in higher degree
        # Low degrees may move vertices of complicated shapes to wrong directions.
        later = tuple(degree for degree in DEGREES if degree >= 6)
        again = _best_degree(start, later, faces)
        if again is not None and again.chance * again.validation < fit.validation:
            fit = again
    coefficients = unit * fit.coefficients
    coefficients[0] += np.sqrt(4.0 * np.pi) * middle
    deviations = unit * _held_out_misfit(fit, faces) * fit.deviations()
    return MeshFit(coefficients, fit.harmonics, unit * fit.misfit, deviations, fit.u)


def _laid_out(metric: PolyhedralMetric, x: Floats) -> tuple[Floats, Indices]:
    """Directions of the vertices x (V, 3), and outward triangles between them."""
    u = sphere_layout(metric)
    if are_outward(metric.faces, u):
        return u, metric.faces
    # Triangles of long thin bodies may be inverted: use the Delaunay triangulation on the sphere.
    faces = hull_faces(u)
    return least_distorted(PolyhedralMetric.from_mesh(x, faces), u), faces


def _best_degree(fit: VertexFit, degrees: tuple[int, ...], faces: Indices) -> VertexFit | None:
    """Fit of the degree chosen by generalized cross-validation, each started from the previous one.

    None if the first degree exceeds 1 and the vertices are too few for it.
    """
    fits: list[VertexFit] = []
    for degree in degrees:
        fit = fit.raised(degree)
        if degree > 1 and not fit.is_possible:
            break
        fit = _relaxed(fit.moved(fit.least_squares(fit.residuals)), faces)
        fits.append(fit)
        best = min(range(len(fits)), key=lambda i: fits[i].validation)
        if fit.misfit <= ROUNDING or best < len(fits) - 2:  # two degrees fit no better
            break
    if not fits:
        return None
    # The lowest degree that is as good as the best within chance.
    enough = fit.chance * min(fit.validation for fit in fits)
    return next(fit for fit in fits if fit.validation <= enough)


def _relaxed(fit: VertexFit, faces: Indices) -> VertexFit:
    """Fit after updates of the directions of the vertices, until it ceases to improve."""
    for _ in range(8):  # largest number of updates
        better = fit.nearer().corrected(faces)
        if not (better.misfit < fit.misfit and better.is_determined):
            break
        enough = better.misfit > 0.8 * fit.misfit
        fit = better
        if enough:
            break
    return fit


def _held_out_misfit(fit: VertexFit, faces: Indices) -> float:
    """Ratio of the cross-validated misfit of a tenth of the vertices to the misfit of the fit."""
    used = np.ones(len(fit.x))
    used[np.random.default_rng(0).random(len(fit.x)) < 0.1] = 0.0  # a tenth of the vertices is held out
    without = replace(fit, used=used)
    if not without.is_determined:
        return 1.0 / (1.0 - LEVERAGE)
    without = _relaxed(without.moved(without.least_squares(without.residuals)), faces)
    misfit = np.average(without.distances**2, weights=fit.angles * (1.0 - used))
    # Errors are at least four times the misfit.
    return max(4.0, float(np.sqrt(misfit)) / max(fit.misfit, ROUNDING))
