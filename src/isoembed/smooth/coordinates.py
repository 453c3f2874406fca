"""Directions in which a surface needs few spherical harmonics, from its triangulation.

How many harmonics a surface X(u) needs is as much a matter of the directions u as of its shape: the ellipsoid
with the axes 3, 2 and 1 is of degree 1 if the sphere is mapped to it linearly, and of degree 80 as r(u).
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

MAPS = ((1, 2.0), (4, 4.0))  # degree of a map, and the factor by which it must lower the energy


def fitting_coordinates(u: Floats, faces: Indices, points: Floats) -> SphereMap | None:
    """A map u = F(v) in whose directions v a surface needs much fewer harmonics, if there is one.

    Parameters
    ----------
    u : ndarray, shape (V, 3)
        Directions of the vertices of a triangulation.
    faces : ndarray of int, shape (F, 3)
    points : ndarray, shape (V, 3)
        The vertices in space, right to a percent or so.

    Returns
    -------
    SphereMap or None
        None where the directions u are nearly as good: the map is not worth it.

    Notes
    -----
    The energy ``sum (l (l + 1) / 2)^3 |X_lm|^2`` is made least among maps of low degree, by the Gauss-Newton
    method; X_lm smooth the vertices, as seen in the directions v.  Reparametrization by such energies is due
    to S. K. Veerapaneni, A. Rahimian, G. Biros, D. Zorin, J. Comput. Phys. 230 (2011) 5610.
    """
    vertices = _Vertices.of(u, faces, points)
    best = given = vertices.smoothed(SphereMap.linear(np.eye(3)))
    for degree, gain in MAPS:
        # No surface has less energy than the round sphere.
        if best.energy > gain * 4.0 * np.pi:
            found = vertices.lowered(best, Harmonics(degree, degree))
            if found.energy * gain <= best.energy:
                best = found
    return None if best is given else best.coordinates


@dataclass(frozen=True)
class _Smoothed:
    """Vertices smoothed in the directions v of a map: coefficients (size, 3), and their energy."""

    coordinates: SphereMap
    coefficients: Floats
    energy: float


@dataclass(frozen=True)
class _Vertices:
    """Vertices of a triangulated surface, about their centroid, in the unit of their mean square radius.

    Attributes
    ----------
    u, x : ndarray, shape (V, 3)
    areas : ndarray, shape (V,)
        Their shares in the area.
    harmonics : Harmonics
        In which they are smoothed.
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
        most = int(np.sqrt(len(u) / 3.0)) - 1  # three vertices for each harmonic
        degree = min(14, most)  # highest degree of the harmonics that smooth the vertices
        return cls(u, x, areas, Harmonics(degree, degree))

    def smoothed(self, coordinates: SphereMap) -> _Smoothed:
        """Least energy of coefficients and misses."""
        Y = self.harmonics.values(coordinates.inverse(self.u))
        noise = 1e-3**2  # a miss of 1e-3 radii costs as much as degree 1
        weighted = (Y * self.areas[:, None]).T
        normal = weighted @ Y + noise * np.diag(self._penalty)
        found = np.asarray(np.linalg.solve(normal, weighted @ self.x), dtype=np.float64)
        missed = self.areas @ np.einsum("ni,ni->n", Y @ found - self.x, Y @ found - self.x)
        energy = self._penalty @ np.einsum("ni,ni->n", found, found) + missed / noise
        return _Smoothed(coordinates, found, float(energy))

    def lowered(self, start: _Smoothed, harmonics: Harmonics) -> _Smoothed:
        """The map in some harmonics for which the energy is least, near a given one."""
        C = resized(start.coordinates.coefficients, start.coordinates.harmonics, harmonics)
        root = np.sqrt(self._penalty)[:, None]

        def step(at: _Smoothed) -> Curve[_Smoothed]:
            J = self._jacobian(at, harmonics)
            normal, gradient = J.T @ J, J.T @ (root * at.coefficients).ravel()
            # Alike for x, y and z.
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
        """Derivatives (3 size, 3 m) of the weighted coefficients by those of a map in m harmonics."""
        n = int(OVERSAMPLING * (self.harmonics.degree + 1))  # nodes over coefficients, each way
        v, weights = gauss_rule(n, 2 * n)
        u, slope = at.coordinates.forward(v), at.coordinates.differential(v)
        dX = np.einsum("niv,vc->nci", self.harmonics.gradients(v)[1], at.coefficients)
        Y = harmonics.values(v)
        length = np.linalg.norm(Y @ at.coordinates.coefficients, axis=1)[:, None, None]
        tangent = np.eye(3) - u[:, :, None] * u[:, None, :]
        # X(F^-1(.)) moves along dX dF^-1 dG / |G|.
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
