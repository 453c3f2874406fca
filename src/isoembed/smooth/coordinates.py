"""Parametrizations in which a surface needs few spherical harmonics, from its triangulation.

The number of harmonics of a surface X(u) depends on the directions u as much as on its shape: the ellipsoid
with axes 3, 2 and 1 has degree 1 as a linear image of the sphere, and needs degree 80 as r(u).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.meshing.sphere import gauss_rule
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.stopping import settled
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import OVERSAMPLING
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.transforms import resized


def fitting_coordinates(u: Floats, faces: Indices, points: Floats) -> SphereMap | None:
    """Map u = F(v) to directions u from directions v in which a surface needs far fewer harmonics.

    Parameters
    ----------
    u : ndarray, shape (V, 3)
        Directions of the vertices of a triangulation.
    faces : ndarray of int, shape (F, 3)
    points : ndarray, shape (V, 3)
        Vertices in space, accurate to about a percent.

    Returns
    -------
    SphereMap or None
        None if the directions u are nearly as good.

    Notes
    -----
    The Gauss-Newton method minimizes the energy ``sum (l (l + 1) / 2)^3 |X_lm|^2`` among maps of low degree;
    X_lm are coefficients of a smoothing fit to the vertices in the directions v.  Reparametrization by such
    energies is due to S. K. Veerapaneni, A. Rahimian, G. Biros, D. Zorin, J. Comput. Phys. 230 (2011) 5610.
    """
    vertices = _Vertices.of(u, faces, points)
    best = initial = vertices.smoothed(SphereMap.linear(np.eye(3)))
    # A map of this degree must reduce the energy by at least this factor.
    for degree, gain in ((1, 2.0), (4, 4.0)):
        # The round sphere has the least energy, 4 pi.
        if best.energy > gain * 4.0 * np.pi:
            found = vertices.lowered(best, Harmonics(degree, degree))
            if found.energy * gain <= best.energy:
                best = found
    return None if best is initial else best.coordinates


@dataclass(frozen=True)
class _Smoothed:
    """Smoothing fit to vertices in the directions v of a map: coefficients (size, 3) and energy."""

    coordinates: SphereMap
    coefficients: Floats
    energy: float


@dataclass(frozen=True)
class _Vertices:
    """Vertices of a triangulated surface, about their centroid, in units of their root-mean-square radius.

    Attributes
    ----------
    u, x : ndarray, shape (V, 3)
        Directions and positions.
    areas : ndarray, shape (V,)
        Fractions of the area.
    harmonics : Harmonics
        Harmonics of the smoothing fit.
    """

    u: Floats
    x: Floats
    areas: Floats
    harmonics: Harmonics

    @classmethod
    def of(cls, u: Floats, faces: Indices, points: Floats) -> _Vertices:
        a, b, c = (points[faces[:, k]] for k in range(3))
        of_faces = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        areas = np.zeros(len(points))
        np.add.at(areas, faces.ravel(), np.repeat(of_faces, 3))
        areas /= areas.sum()
        x = points - areas @ points
        x = x / np.sqrt(areas @ np.einsum("ni,ni->n", x, x))
        max_degree = int(np.sqrt(len(u) / 3.0)) - 1  # three vertices per harmonic
        degree = min(14, max_degree)  # degree of the smoothing fit
        return cls(u, x, areas, Harmonics(degree, degree))

    def smoothed(self, coordinates: SphereMap) -> _Smoothed:
        """Smoothing fit of least energy, the sum of those of the coefficients and the residuals."""
        Y = self.harmonics.values(coordinates.inverse(self.u))
        noise = 1e-3**2  # a residual of 1e-3 radii costs as much as degree 1
        weighted = (Y * self.areas[:, None]).T
        normal = weighted @ Y + noise * np.diag(self._penalty)
        found = np.asarray(np.linalg.solve(normal, weighted @ self.x), dtype=np.float64)
        misfit = self.areas @ np.einsum("ni,ni->n", Y @ found - self.x, Y @ found - self.x)
        energy = self._penalty @ np.einsum("ni,ni->n", found, found) + misfit / noise
        return _Smoothed(coordinates, found, float(energy))

    def lowered(self, start: _Smoothed, harmonics: Harmonics) -> _Smoothed:
        """Smoothing fit of least energy among maps in given harmonics, near an initial one."""
        C = resized(start.coordinates.coefficients, start.coordinates.harmonics, harmonics)
        root = np.sqrt(self._penalty)[:, None]

        def step(at: _Smoothed) -> Curve[_Smoothed]:
            J = self._jacobian(at, harmonics)
            normal, gradient = J.T @ J, J.T @ (root * at.coefficients).ravel()
            # The same scale for x, y and z.
            scale = np.repeat(np.diag(normal).reshape(-1, 3).max(axis=1), 3)

            def damped(damping: float) -> _Smoothed:
                step = np.linalg.solve(normal + damping * np.diag(scale), -gradient).reshape(-1, 3)
                # Maps that fold raise InvalidParameter.
                return self.smoothed(SphereMap(harmonics, at.coordinates.coefficients + step))

            return damped

        return descend(
            self.smoothed(SphereMap(harmonics, C)),
            step,
            Damping(1e-3, softer=1 / 8, largest=1e6),
            value=lambda at: at.energy,
            converged=settled(0.01),
            max_iterations=25,
        ).point

    def _jacobian(self, at: _Smoothed, harmonics: Harmonics) -> Floats:
        """Derivatives (3 size, 3 m) of the weighted coefficients with respect to those of a map."""
        n = int(OVERSAMPLING * (self.harmonics.degree + 1))  # number of circles of nodes
        v, weights = gauss_rule(n, 2 * n)
        u, slope = at.coordinates.forward(v), at.coordinates.differential(v)
        dX = np.einsum("niv,vc->nci", self.harmonics.gradients(v)[1], at.coefficients)
        Y = harmonics.values(v)
        length = np.linalg.norm(Y @ at.coordinates.coefficients, axis=1)[:, None, None]
        tangent = np.eye(3) - u[:, :, None] * u[:, None, :]
        # Velocity of X(F^-1(.)): dX dF^-1 dG / |G|.
        along = dX @ np.linalg.solve(slope + u[:, :, None] * v[:, None, :], tangent) / length
        analysis = (self.harmonics.values(v) * weights[:, None] * np.sqrt(self._penalty)).T
        J = np.empty((self.harmonics.size, 3, harmonics.size, 3))
        for i in range(3):
            for j in range(3):
                J[:, i, :, j] = (analysis * along[:, i, j]) @ Y
        return J.reshape(3 * self.harmonics.size, -1)

    @property
    def _penalty(self) -> Floats:
        l = self.harmonics.labels[0]
        return (0.5 * l * (l + 1.0)) ** 3
