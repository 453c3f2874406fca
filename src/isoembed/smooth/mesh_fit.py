"""Spherical harmonic fit of a closed triangle mesh.

Where on the sphere a vertex belongs is not known and does not matter: only distances along the normal do.
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

DEGREES = (1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48)  # in turn
ROUNDING = 1e-13  # misfit over the mean radius


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
        Possible errors, drawn at random: coefficients in the harmonics of ``deviating(harmonics)``.
    directions : ndarray, shape (V, 3)
        Unit vectors at which the surface is nearest to the vertices.
    """

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    deviations: Floats
    directions: Floats


def fit_mesh(vertices: Floats, faces: Indices) -> MeshFit:
    """Harmonics fitted to a closed triangle mesh of genus 0.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray of int, shape (F, 3)
        Counterclockwise from outside.

    Raises
    ------
    InvalidMetric
        The faces are not a triangulated sphere, or a triangle is degenerate.

    Notes
    -----
    The triangulation is laid out on the sphere with little distortion.  Then, degree by degree, harmonics are
    fitted by least squares in which distances along the surface hardly count, and each vertex is moved on the
    sphere to where the surface is nearest to it, until its distances along the normal do not decrease any
    more [1].  The surface is left free to slide along itself, and does so until the harmonics suffice best.
    The degree is the one of least generalized cross-validation.

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
    if fit.misfit > 1e-4:  # a poor fit is begun again in higher degree
        # Shapes that low degrees cannot follow may be left with vertices in wrong places.
        later = tuple(degree for degree in DEGREES if degree >= 6)
        again = _best_degree(start, later, faces)
        if again is not None and again.chance * again.validation < fit.validation:
            fit = again
    coefficients = unit * fit.coefficients
    coefficients[0] += np.sqrt(4.0 * np.pi) * middle
    deviations = unit * _missed_elsewhere(fit, faces) * fit.deviations()
    return MeshFit(coefficients, fit.harmonics, unit * fit.misfit, deviations, fit.u)


def _laid_out(metric: PolyhedralMetric, x: Floats) -> tuple[Floats, Indices]:
    """Directions of the vertices x (V, 3), and triangles between them that look outward."""
    u = sphere_layout(metric)
    if are_outward(metric.faces, u):
        return u, metric.faces
    # Conformal layouts of long thin bodies are those of other triangles: these are Delaunay on the sphere.
    faces = hull_faces(u)
    return least_distorted(PolyhedralMetric.from_mesh(x, faces), u), faces


def _best_degree(fit: VertexFit, degrees: tuple[int, ...], faces: Indices) -> VertexFit | None:
    """The fit of the degree that generalized cross-validation chooses, each begun at the one before.

    None if the vertices are too few for the first degree, which is not 1.
    """
    fits: list[VertexFit] = []
    for degree in degrees:
        fit = fit.raised(degree)
        if degree > 1 and not fit.is_possible:
            break
        fit = _relaxed(fit.moved(fit.least(fit.missed)), faces)
        fits.append(fit)
        best = min(range(len(fits)), key=lambda i: fits[i].validation)
        if fit.misfit <= ROUNDING or best < len(fits) - 2:  # two degrees fit no better
            break
    if not fits:
        return None
    # As good as the best of all, but for chance.
    enough = fit.chance * min(fit.validation for fit in fits)
    return next(fit for fit in fits if fit.validation <= enough)


def _relaxed(fit: VertexFit, faces: Indices) -> VertexFit:
    """The fit, vertices having been moved on the sphere until it gets no better."""
    for _ in range(8):  # rounds in which vertices move on the sphere
        better = fit.nearer().corrected(faces)
        if not (better.misfit < fit.misfit and better.is_determined):
            break
        enough = better.misfit > 0.8 * fit.misfit
        fit = better
        if enough:
            break
    return fit


def _missed_elsewhere(fit: VertexFit, faces: Indices) -> float:
    """Misfit of vertices to a fit to the others, over their misfit to this one."""
    used = np.ones(len(fit.x))
    used[np.random.default_rng(0).random(len(fit.x)) < 0.1] = 0.0  # a tenth of the vertices is held out
    without = replace(fit, used=used)
    if not without.is_determined:
        return 1.0 / (1.0 - LEVERAGE)
    without = _relaxed(without.moved(without.least(without.missed)), faces)
    missed = np.average(without.distances**2, weights=fit.angles * (1.0 - used))
    # Errors are at least four times the misfit.
    return max(4.0, float(np.sqrt(missed)) / max(fit.misfit, ROUNDING))
