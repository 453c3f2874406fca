"""Surfaces of arbitrary shape in a slice, with coordinates in spherical harmonics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.mesh.triangulation import Triangulation
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.relativity.spacetimes.checks import vector, written
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.point_cloud import checked_points
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.mesh_fit import fit_mesh
from isoembed.smooth.projection import DIRECTIONS, project
from isoembed.smooth.scattered_fit import deviating, white
from isoembed.smooth.user_functions import real_values
from isoembed.surface.estimate import percent
from isoembed.surface.intersection import self_intersections
from isoembed.surface.measures import volume

FEWEST_HEIGHTS = 24  # least number of circles of nodes for the check of the immersion


@short_repr
@dataclass(frozen=True, eq=False)
class MappedSurface(Surface):
    """Surface X(u) over unit vectors u, with coordinates X in spherical harmonics.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Coefficients of X, lengths.
    center : three floats, optional
        Center for torques; by default the centroid of the area in the coordinates.
    misfit : float
        Root-mean-square distance of X from the given map at independent directions, or from the vertices of a
        mesh.
    deviations : ndarray, shape (N, size, 3), optional
        Random samples of the error of the coefficients of a mesh fit, in the harmonics of
        `isoembed.smooth.scattered_fit.deviating`; by default noise of the size of the misfit.
    notes : tuple of str
        Notes for reports.
    directions : ndarray, shape (V, 3), optional
        For meshes, unit vectors of the points of the surface nearest to the vertices.

    Raises
    ------
    InvalidParameter
        The map is not an immersion, or reverses the orientation; the message names a direction.
    """

    harmonics: Harmonics
    coefficients: Floats
    center: Sequence[float] = None  # type: ignore[assignment] # three floats once the surface is made
    misfit: float = 0.0
    deviations: Floats | None = None
    notes: tuple[str, ...] = ()
    directions: Floats | None = None

    def __post_init__(self) -> None:
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if coefficients.shape != (self.harmonics.size, 3):
            raise InvalidParameter(
                f"{self.harmonics.size} harmonics take coefficients ({self.harmonics.size}, 3), "
                f"not {coefficients.shape}"
            )
        coefficients.setflags(write=False)
        object.__setattr__(self, "coefficients", coefficients)
        _check_immersion(self._nodes)
        center = self._nodes.centroid if self.center is None else self.center
        object.__setattr__(self, "center", vector("the center", center))

    @classmethod
    def from_map(
        cls, function: Callable[[Floats], ArrayLike], center: Sequence[float] | None = None
    ) -> MappedSurface:
        """Projection of a map onto harmonics, up to the degree where only rounding or noise is left.

        Parameters
        ----------
        function : callable
            Smooth, orientation-preserving map that takes unit vectors u (n, 3) and returns points X (n, 3).
        center : three floats, optional
            Center for torques; by default the centroid of the area in the coordinates.

        Raises
        ------
        InvalidParameter
            Points are not finite, the relative error exceeds 1e-6 with harmonics up to degree 128, or the map
            is not an immersion; the message says which.

        Notes
        -----
        The truncation error, if larger than rounding, is the ``misfit``.
        """
        if not callable(function):
            raise InvalidParameter(
                f"the map is a {type(function).__name__}, not a function of unit vectors u (n, 3); the "
                "vertices and faces of a mesh are for from_mesh"
            )
        middle = _mapped(function, fibonacci_directions(DIRECTIONS)).mean(axis=0)
        fit = project(lambda u: _mapped(function, u) - middle, "the map")
        coefficients = fit.coefficients.copy()
        coefficients[0] += np.sqrt(4.0 * np.pi) * middle
        return cls(fit.harmonics, coefficients, center, fit.misfit)  # type: ignore[arg-type] # see above

    @classmethod
    def from_mesh(
        cls, vertices: ArrayLike, faces: ArrayLike, center: Sequence[float] | None = None
    ) -> MappedSurface:
        """Least-squares fit of harmonics to a closed triangle mesh with vertices on a smooth surface.

        The degree, at most 48, is chosen by generalized cross-validation; see
        `isoembed.smooth.mesh_fit.fit_mesh`.

        Parameters
        ----------
        vertices : array_like, shape (V, 3)
        faces : array_like of int, shape (F, 3)
            Consistently oriented triangles of genus 0.
        center : three floats, optional
            Center for torques; by default the centroid of the area in the coordinates.

        Raises
        ------
        InvalidParameter
            A vertex is not finite, or the fitted surface is not an immersion because the mesh is too coarse.
        InvalidMetric
            The faces are not a triangulated sphere, or a triangle is degenerate; the message names it.
        """
        x, triangles = checked_points(vertices), Triangulation(faces)
        triangles.check_sphere()
        if triangles.n_vertices != len(x):
            raise InvalidMetric(f"there are {len(x)} vertices, but {triangles.n_vertices} in faces")
        inward = volume(triangles.faces, x / np.abs(x).max()) < 0.0
        fit = fit_mesh(x, triangles.faces[:, ::-1].copy() if inward else triangles.faces)
        crossing = self_intersections(triangles.faces, x)
        notes = tuple(
            f"the mesh intersects itself, for instance in faces {i} and {j}" for i, j in crossing[:1]
        )
        about = None if center is None else vector("the center", center)
        scattered = f"{len(x)} vertices are too few or too scattered for a smooth surface through them"
        try:
            surface = cls(
                fit.harmonics,
                fit.coefficients,
                about,  # type: ignore[arg-type] # see above
                fit.misfit,
                fit.deviations,
                notes,
                fit.directions,
            )
        except InvalidParameter as error:
            raise InvalidParameter(f"{scattered}: {error}") from None
        relative = surface.misfit / surface.mean_radius
        if relative > 0.05:  # vertices with a larger misfit are not on a smooth surface
            raise InvalidParameter(f"{scattered}: it misses them by {percent(relative)} of its radius")
        return surface

    @property
    def mean_radius(self) -> float:
        """Radius of the sphere with the same coordinate area."""
        return float(np.sqrt(self._nodes.area / (4.0 * np.pi)))

    def jet(self, u: Floats) -> Jet:
        """See `Surface`."""
        return HarmonicMap(self.harmonics, self.coefficients).jet(u)

    def deviating(self, u: Floats) -> Iterator[Jet]:
        """See `Surface`."""
        jet, harmonics = self.jet(u), deviating(self.harmonics)
        drawn = white(self.harmonics, self.misfit, 3) if self.deviations is None else self.deviations
        for deviation in drawn:
            change = HarmonicMap(harmonics, deviation).jet(u)
            yield Jet(u, jet.x + change.x, jet.first + change.first, jet.second + change.second)

    @cached_property
    def _nodes(self) -> _Nodes:
        """Nodes dense enough for the normals at neighbors to have positive products, if possible."""
        n = max(FEWEST_HEIGHTS, 2 * self.harmonics.degree)
        while True:
            around = 2 * n * self.harmonics.order // max(1, self.harmonics.degree)
            nodes = _Nodes.of(self.jet, n, max(2 * FEWEST_HEIGHTS, around))
            if 2 * n > 400 or nodes.turned is None:
                return nodes
            n *= 2


@dataclass(frozen=True)
class _Nodes:
    """Map at the nodes of a product rule: points x, and normals whose length is the area density."""

    n: int
    u: Floats
    weights: Floats
    x: Floats
    normals: Floats

    @classmethod
    def of(cls, jet: Callable[[Floats], Jet], n: int, around: int) -> _Nodes:
        """Nodes on n circles of latitude with `around` nodes each."""
        u, weights = gauss_rule(n, around)
        there = jet(u)
        return cls(n, u, weights, there.x, np.cross(there.first[:, 0], there.first[:, 1]))

    @cached_property
    def singular(self) -> Floats | None:
        """Direction in which the differential is singular, if there is one."""
        singular = ~(self.densities > 1e-9 * self.densities.mean())  # no area
        return self.u[int(np.argmax(singular))] if singular.any() else None

    @cached_property
    def turned(self) -> Floats | None:
        """Direction at which the normal reverses toward the next node, if there is one."""
        normals = self.normals.reshape(self.n, -1, 3)
        around = np.einsum("abi,abi->ab", normals, np.roll(normals, -1, axis=1))
        across = np.einsum("abi,abi->ab", normals[:-1], normals[1:])
        for products in (around, across):
            if products.min() < 0.0:
                return self.u[int(np.argmin(products))]
        return None

    @cached_property
    def densities(self) -> Floats:
        """Area densities relative to the unit sphere."""
        return np.linalg.norm(self.normals, axis=1)

    @property
    def area(self) -> float:
        """Area in the coordinates."""
        return float(self.weights @ self.densities)

    @property
    def centroid(self) -> Floats:
        """Centroid of the area."""
        return np.asarray((self.weights * self.densities) @ self.x / self.area)

    @property
    def volume(self) -> float:
        """Enclosed volume, negative for reversed orientation."""
        heights = np.einsum("ni,ni->n", self.x - self.x.mean(axis=0), self.normals)
        return float(self.weights @ heights) / 3.0


def _check_immersion(nodes: _Nodes) -> None:
    """Check that a map is not singular, folded or orientation-reversing."""
    if nodes.singular is not None:
        raise InvalidParameter(
            "the map is not an immersion: its differential is singular in the direction "
            + written(nodes.singular)
        )
    if nodes.turned is not None:
        raise InvalidParameter(
            f"the map is not an immersion: its normal reverses near the direction "
            f"{written(nodes.turned)}, where it is folded or has an edge"
        )
    if nodes.volume <= 0.0:
        raise InvalidParameter(
            f"the map turns the sphere inside out: it encloses the volume {nodes.volume:.6g}; "
            "composed with a reflection of the sphere it does not"
        )


def _mapped(function: Callable[[Floats], ArrayLike], u: Floats) -> Floats:
    x = real_values("the map", function, u)
    if x.shape != (len(u), 3):
        raise InvalidParameter(f"the map has the shape {x.shape} for {len(u)} directions, not ({len(u)}, 3)")
    good = np.isfinite(x).all(axis=1)
    if not good.all():
        i = int(np.argmin(good))
        raise InvalidParameter(
            f"the map is {written(x[i])} in the direction {written(u[i])}: that is not finite"
        )
    return x
