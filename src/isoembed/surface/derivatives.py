"""Derivatives of the vertices with respect to the edge lengths: forward and adjoint.

To first order ``dl = J dx``, where J is the rigidity matrix of `isoembed.surface.rigidity`.  If the surface
is infinitesimally rigid, J has full row rank, and dl determines dx up to rigid motions: ``dx = J^+ dl`` is
the one without translation and rotation, and g . x changes by ``(J^+)^T g . dl``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.reprs import short_repr
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.measures import face_normals
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths
from isoembed.surface.swept_volumes import curved_volume_gradient


@dataclass(frozen=True, eq=False)
class LengthDerivatives:
    """Rigidity matrix J of a surface and its factorization, reused for all derivatives.

    Attributes
    ----------
    linear : LinearizedLengths
    surface : Projected
        In hyperbolic and spherical space J acts on z, with ``x' = w z``, and z has minimum norm.
    """

    linear: LinearizedLengths
    surface: Projected

    @classmethod
    def of(
        cls, triangulation: Triangulation, vertices: Floats, lengths: Floats, space: Space = EUCLIDEAN
    ) -> LengthDerivatives:
        """Factor ``J J^T`` of a surface.

        Raises
        ------
        SingularMatrix
            The surface is not infinitesimally rigid.
        OutOfMemory
            The factors exceed the available memory.
        """
        linear = LengthSystem(triangulation, space=space).linearized(vertices, lengths)
        return cls(linear, Projected.of(space, vertices))

    def jvp(self, changes: Floats) -> Floats:
        """``J^+ dl``, (V, 3), for dl, (E,); or (..., V, 3) for (..., E)."""
        if changes.ndim > 1:
            return np.array([self.jvp(each) for each in changes])
        J, r = self.linear.J, changes[self.linear.order]
        z = J.forces(self.linear.solve(r))
        return self.surface.motion(z + J.forces(self.linear.solve(r - J.rates(z))))

    def vjp(self, gradient: Floats) -> Floats:
        """``(J^+)^T g``, (E,), for g, (V, 3); or (..., E) for (..., V, 3)."""
        if gradient.ndim > 2:
            return np.array([self.vjp(each) for each in gradient])
        J, g = self.linear.J, self.surface.motion(gradient)
        y = self.linear.solve(J.rates(g))
        y = y + self.linear.solve(J.rates(g - J.forces(y)))
        by_length = np.empty_like(y)
        by_length[self.linear.order] = y
        return by_length


@short_repr
@dataclass(frozen=True, eq=False)
class Variation:
    """First and second t-derivatives, at t = 0, of a surface in R^3 with edge lengths ``l + t dl``.

    Attributes
    ----------
    velocity, acceleration : ndarray, shape (V, 3)
        Derivatives of the vertices, each of minimum norm: without translation and rotation.
    dihedral_rates : ndarray, shape (E,)
        First derivatives of the dihedral angles.
    area, volume, integrated_mean_curvature : tuple of float
        First and second derivatives of the area, the volume and int H dA = 1/2 sum l theta, where
        ``sum l dtheta`` vanishes (Schlaefli).
    """

    velocity: Floats
    acceleration: Floats
    dihedral_rates: Floats
    area: tuple[float, float]
    volume: tuple[float, float]
    integrated_mean_curvature: tuple[float, float]

    def scaled(self, unit: float) -> Variation:
        """Derivatives in another unit, in which every length and length change is scaled by this factor."""
        return Variation(
            velocity=unit * self.velocity,
            acceleration=unit * self.acceleration,
            dihedral_rates=self.dihedral_rates,
            area=_scaled(self.area, unit, 2),
            volume=_scaled(self.volume, unit, 3),
            integrated_mean_curvature=_scaled(self.integrated_mean_curvature, unit, 1),
        )

    @classmethod
    def of(
        cls,
        derivatives: LengthDerivatives,
        triangulation: Triangulation,
        vertices: Floats,
        lengths: Floats,
        changes: Floats,
    ) -> Variation:
        """Differentiate along changes dl, (E,), of the lengths.

        The second derivative of ``l^2 = |d|^2`` gives ``J x'' = (dl^2 - |d'|^2) / l``.
        """
        t = triangulation
        a, b = t.edges.T
        v = derivatives.jvp(changes)
        apart = v[a] - v[b]
        w = derivatives.jvp((changes**2 - np.einsum("ei,ei->e", apart, apart)) / lengths)
        theta, rates = dihedral_angles(t, vertices), dihedral_rates(t, vertices, v)
        return cls(
            velocity=v,
            acceleration=w,
            dihedral_rates=rates,
            area=_area(t, vertices, v, w),
            volume=_volume(t, vertices, v, w),
            integrated_mean_curvature=(float(theta @ changes) / 2, float(rates @ changes) / 2),
        )


def _scaled(values: tuple[float, float], unit: float, power: int) -> tuple[float, float]:
    first, second = values
    for _ in range(power):  # one after the other: their product may overflow where the value does not
        first, second = unit * first, unit * second
    return first, second


def volume_gradient(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Gradient of the volume with respect to the vertices, (V, 3)."""
    if not space.is_euclidean:
        return curved_volume_gradient(triangulation, vertices, space)
    thirds = np.repeat(face_normals(triangulation.faces, vertices) / 6, 3, axis=0)
    corners = triangulation.faces.ravel()
    return np.stack([np.bincount(corners, column) for column in thirds.T], axis=1)


def integral_gradients(triangulation: Triangulation, vertices: Floats) -> Floats:
    """Gradients of area, volume and int H dA = 1/2 sum l theta with respect to the vertices, (3, V, 3).

    The last one is that of closed surfaces, where ``sum l dtheta`` is zero (Schlaefli).
    """
    t, corners = triangulation, vertices[triangulation.faces]
    N = face_normals(t.faces, vertices)
    n = N / np.linalg.norm(N, axis=1)[:, None]
    grown = np.cross(n[:, None], np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)) / 2
    rates = grown.reshape(-1, 3).T
    area = np.stack([np.bincount(t.faces.ravel(), each) for each in rates], axis=1)
    along = vertices[t.edges[:, 0]] - vertices[t.edges[:, 1]]
    along *= (dihedral_angles(t, vertices) / np.linalg.norm(along, axis=1) / 2)[:, None]
    return np.stack([area, volume_gradient(t, vertices), t.incidence @ along])


def normal_rates(t: Triangulation, x: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Face normals N = (b - a) x (c - a), (F, 3), and their derivatives for vertex velocities v."""
    first, second, third = (x[t.faces[:, k]] for k in range(3))
    at_first, at_second, at_third = (v[t.faces[:, k]] for k in range(3))
    u, w = second - first, third - first
    du, dw = at_second - at_first, at_third - at_first
    return np.cross(u, w), np.cross(du, w) + np.cross(u, dw)


def dihedral_rates(t: Triangulation, x: Floats, v: Floats) -> Floats:
    """Derivatives of the dihedral angles, (E,): differences of the faces' rotation rates about the edge.

    They are 0 on a boundary.
    """
    N, rates = normal_rates(t, x, v)
    size = np.linalg.norm(N, axis=1, keepdims=True)
    n, dn = N / size, rates / size
    start, end = t.edges.T
    along = x[end] - x[start]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    left, right = t.edge_flanks.T // 3
    turns = [np.einsum("ei,ei->e", dn[f], np.cross(along, n[f])) for f in (left, right)]
    return np.asarray(turns[1] - turns[0])


def _area(t: Triangulation, x: Floats, v: Floats, w: Floats) -> tuple[float, float]:
    N, rates = normal_rates(t, x, v)
    corners = v[t.faces]
    bent = 2 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    bent += normal_rates(t, x, w)[1]
    size = np.linalg.norm(N, axis=1)
    n = N / size[:, None]
    along = np.einsum("fi,fi->f", n, rates)
    across = np.einsum("fi,fi->f", rates, rates) - along**2
    second = np.einsum("fi,fi->f", n, bent) + across / size
    return float(along.sum()) / 2, float(second.sum()) / 2


def _volume(t: Triangulation, x: Floats, v: Floats, w: Floats) -> tuple[float, float]:
    gradient = volume_gradient(t, x)
    bent = np.repeat(normal_rates(t, x, v)[1] / 6, 3, axis=0)
    second = np.einsum("fi,fi->", bent, v[t.faces.ravel()]) + np.sum(gradient * w)
    return float(np.sum(gradient * v)), float(second)
