"""Triangulations of the sphere that are nearly equilateral in a given smooth metric."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import index

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.meshing.flips import twin_halfedges
from isoembed.meshing.intrinsic_relaxation import corner_angles, end_lengths, flip_to_delaunay, relaxed
from isoembed.meshing.sphere import fibonacci_lattice, hull_faces
from isoembed.meshing.spreading import Cells, cell_centers
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.geodesics import definite_tensor, geodesic_lengths, in_own_unit
from isoembed.smooth.grid_metric import sampled_on_grid
from isoembed.smooth.two_metric import TwoMetric, area_density

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

MIN_VERTICES = 12

MAX_VERTICES = 10_000_000
"""More of them are a mistake in the unit of the size, and fit into no memory."""

ANGLE_WINDOW = np.radians([35.0, 100.0])
"""Angles at which the relaxation stops."""

GRADED = 0.1
"""Vertices that follow the curvature, against one that follows the area, in the meshes for embeddings."""

OPTIMAL_SWEEPS = 10
"""Sweeps towards optimal Delaunay triangulations, before those to centroidal Voronoi tessellations."""

SWEEPS = 30
"""Of all vertices."""

TOUCHES = 300
"""Sweeps of the vertices near angles outside the window."""

PATIENCE = 40
"""Such sweeps in a row after which there should be fewer bad triangles."""

RINGS = 2
"""How many edges from a bad triangle vertices are moved then; one more for each `STUCK` sweeps in vain."""

STUCK = 8

EQUILATERAL_EXCESS = 1.02
"""Mean edge length of the meshes made here, over that of equilateral triangles of their area."""

OVERRELAXATION = 1.5
"""Of centroidal steps, which creep."""

CURVATURE_CELLS = (256, 64)
"""In theta and phi, where the curvature is sampled, which costs much more than the metric."""

FLIP_ROUNDS = 5
"""Flips and new measurements in turn, as a measured edge may ask back what its unfolded length asked for."""


@dataclass(frozen=True, eq=False)
class SphereMesh:
    """A triangulation of the sphere of directions and the geodesic lengths of its edges in a metric.

    Attributes
    ----------
    directions : ndarray, shape (V, 3)
        Unit vectors; the triangles look outward.
    metric : PolyhedralMetric
        The triangles with the lengths of the geodesics between their corners.
    """

    directions: Floats
    metric: PolyhedralMetric

    @property
    def faces(self) -> Indices:
        """(F, 3): the triangles."""
        return self.metric.faces

    @cached_property
    def angles(self) -> tuple[float, float]:
        """The least and the largest angle of the triangles, in radians."""
        angles = corner_angles(self.metric.normalized.face_lengths.ravel())
        return float(angles.min()), float(angles.max())

    def measured(self, metric: TwoMetric) -> PolyhedralMetric:
        """The same triangles with the lengths of their edges in another metric.

        Raises
        ------
        InvalidMetric
            That metric is not positive definite on an edge, or breaks a triangle inequality.
        """
        i, j = self.metric.edges.T
        lengths = geodesic_lengths(metric, self.directions[i], self.directions[j])
        return self.metric.with_lengths(lengths)


def triangulate_metric(
    metric: TwoMetric, vertices: int | None = None, *, size: float | None = None, grading: float = 0.0
) -> SphereMesh:
    """Triangulate the sphere with triangles that are nearly equilateral in a smooth metric.

    Parameters
    ----------
    metric : TwoMetric
    vertices : int, optional
        Exact number of vertices, at least 12 and at most ten million.
    size : float, optional
        Instead of their number: the mean edge length, in the metric's unit, met within two or three percent.
    grading : float
        How many vertices follow the curvature, against one that follows the area, if K > 0 everywhere: their
        density is 1 + grading abs(K) A / 4 pi, and each sharp tip gets its share.  0.1 suits metrics with
        tips; 0 makes all triangles alike.

    Returns
    -------
    SphereMesh
        The same input gives the same mesh.

    Raises
    ------
    InvalidParameter
        Neither or both of `vertices` and `size` are given, there would be fewer than 12 vertices or more than
        ten million, or so few that triangles have no area, `size` is not positive, or `grading` is negative.
    InvalidMetric
        The metric is not positive definite somewhere; the message names theta, phi and the value.

    Notes
    -----
    A Fibonacci lattice with the wanted density, connected by the convex hull of its directions and Delaunay
    flips, is relaxed by its edge lengths: to optimal Delaunay triangulations, then to centroidal Voronoi
    tessellations, first everywhere, then with geodesic lengths about angles outside of 35-100 degrees, until
    there are none.  The best of all these meshes is returned; where the vertices are too few for the metric's
    sharpest features it misses the window.
    """
    if (vertices is None) == (size is None):
        given = "neither" if size is None else "both"
        raise InvalidParameter(f"either vertices or size must be given, not {given}")
    if not (np.isfinite(grading) and grading >= 0.0):
        raise InvalidParameter(f"grading must be a number of at least 0, not {grading!r}")
    if size is not None and not (np.isfinite(size) and size > 0.0):
        raise InvalidParameter(f"size must be a positive number, not {size!r}")
    n = None if vertices is None else _checked(vertices)
    unit, own = in_own_unit(metric)
    area, density = _densities(own, grading, n)
    if size is not None:
        n = _vertices_of_size(area, density, size, unit)
    assert n is not None
    mesh = _Mesh.of(Cells(area.values * density.values, area.axis).spread(fibonacci_lattice(n)), own)
    return _relax(mesh, density if grading else None).finished(unit)


def graded_mesh(metric: TwoMetric, vertices: int) -> SphereMesh:
    """The mesh that embeddings begin with: of the metric on a grid, with more vertices where it is curved."""
    return triangulate_metric(sampled_on_grid(metric), vertices, grading=GRADED)


def _checked(vertices: int) -> int:
    try:
        n = index(vertices)
    except TypeError:
        raise InvalidParameter(f"the number of vertices must be an integer, not {vertices!r}") from None
    if n < MIN_VERTICES:
        raise InvalidParameter(f"the number of vertices must be at least {MIN_VERTICES}, not {n}")
    if n > MAX_VERTICES:
        raise InvalidParameter(f"the number of vertices must be at most {MAX_VERTICES}, not {n}")
    return n


def _densities(metric: TwoMetric, grading: float, n: int | None) -> tuple[Cells, Cells]:
    """The area over that of the unit sphere, and the wanted vertices per area up to a factor, on cells."""
    rows = int(np.clip(4.0 * np.sqrt(n or 10_000), 256, 1024))
    axis = _roundest_axis(metric)
    area = Cells.of(lambda u: area_density(definite_tensor(metric, u)), (rows, rows // 2), axis)
    if not grading:
        return area, Cells(np.ones_like(area.values), axis)
    # The curvature costs much more to sample.
    K = Cells.of(lambda u: gaussian_curvature(metric, u), CURVATURE_CELLS, axis)
    density = 1.0 + grading * area.integral() / (4.0 * np.pi) * np.abs(
        K.at(cell_centers(area.values.shape, axis))
    )
    return area, Cells(density.reshape(area.values.shape), axis)


def _roundest_axis(metric: TwoMetric) -> int:
    """The Cartesian axis about which the metric is closest to round, z when in doubt.

    On a surface of revolution the great circles that meet at the axis are of one length.
    """
    a = 2.0 * np.pi / 64.0 * np.arange(64)
    length = np.empty(3)
    for k in range(3):
        e, f = np.roll(np.eye(3), -k - 1, axis=0)[:2]
        u, v = (
            np.outer(np.cos(a), e) + np.outer(np.sin(a), f),
            np.outer(np.cos(a), f) - np.outer(np.sin(a), e),
        )
        length[k] = np.log(np.sqrt(np.einsum("ni,nij,nj->n", v, definite_tensor(metric, u), v)).mean())
    spread = [abs(length[(k + 1) % 3] - length[(k + 2) % 3]) for k in (2, 1, 0)]
    return 2 - int(np.argmin(np.round(spread, 9)))


def _vertices_of_size(area: Cells, density: Cells, size: float, unit: float) -> int:
    """How many vertices have the mean distance `size`, the cells being those of the metric in `unit`.

    N vertices of the density w have N w / int w dA in a unit of area, each with the area 3^(1/2) l^2 / 2 if
    the triangles were equilateral.
    """
    root = Cells(area.values * np.sqrt(density.values), area.axis).integral()
    whole = Cells(area.values * density.values, area.axis).integral()
    with np.errstate(over="ignore"):
        n = 2.0 + 2.0 / np.sqrt(3.0) * (EQUILATERAL_EXCESS * root * np.divide(unit, size)) ** 2 / whole
    if not MIN_VERTICES - 0.5 <= n < MAX_VERTICES + 0.5:
        bound = f"least {MIN_VERTICES}" if n < MIN_VERTICES else f"most {MAX_VERTICES}"
        raise InvalidParameter(
            f"edges of the length {size:.6g} make {n:.3g} vertices, but there must be at {bound}"
        )
    return round(n)


@dataclass(eq=False)
class _Mesh:
    """A triangulation that is being improved, in tables over half-edges as in `unfolding`."""

    metric: TwoMetric
    u: Floats
    corners: Indices
    twins: Indices
    lengths: Floats

    @classmethod
    def of(cls, u: Floats, metric: TwoMetric) -> _Mesh:
        """The convex hull of directions (V, 3)."""
        faces = hull_faces(u)
        return cls(metric, u, faces.ravel().copy(), twin_halfedges(faces), np.empty(faces.size))

    def copy(self) -> _Mesh:
        return _Mesh(self.metric, self.u, self.corners.copy(), self.twins.copy(), self.lengths.copy())

    def flip_roughly(self) -> None:
        """Flip to Delaunay by lengths from the metric at the vertices alone."""
        q = definite_tensor(self.metric, self.u)
        end_lengths(self.u, q, self.corners, self.twins, self.lengths)
        for _ in range(FLIP_ROUNDS):
            if len(flip_to_delaunay(self.u, self.corners, self.twins, self.lengths)) == 0:
                break
            end_lengths(self.u, q, self.corners, self.twins, self.lengths)

    def measure(self, h: Indices) -> None:
        """Measure the edges of half-edges."""
        h = np.unique(np.minimum(h, self.twins[h]))
        start, end = self.u[self.corners[h]], self.u[self.corners[self.twins[h]]]
        self.lengths[h] = self.lengths[self.twins[h]] = geodesic_lengths(self.metric, start, end)

    def flip(self, moved: Mask) -> None:
        """Flip to Delaunay by geodesic lengths, those between vertices that have not moved being known."""
        h = np.flatnonzero(moved[self.corners])
        for _ in range(FLIP_ROUNDS):
            self.measure(h)
            h = flip_to_delaunay(self.u, self.corners, self.twins, self.lengths)
            if len(h) == 0:
                return
        self.measure(h)

    def beyond(self) -> Floats:
        """How far each triangle's angles reach beyond the window, (F,)."""
        angles = corner_angles(self.lengths)
        return np.maximum(ANGLE_WINDOW[0] - angles.min(axis=1), angles.max(axis=1) - ANGLE_WINDOW[1])

    def about(self, faces: Mask, rings: int) -> Mask:
        """The vertices within so many edges of triangles."""
        table = self.corners.reshape(-1, 3)
        near = np.zeros(len(self.u), dtype=bool)
        for _ in range(rings):
            near[table[faces]] = True
            faces = np.asarray(near[table].any(axis=1))
        return near

    def move(self, density: Cells | None, moving: Mask, optimal: bool) -> None:
        """Move vertices towards where the triangles about them are best."""
        wanted = np.ones(len(self.u)) if density is None else density.at(self.u)
        factor = 1.0 if optimal else OVERRELAXATION
        self.u = relaxed(self.u, self.corners, self.twins, self.lengths, wanted, moving, optimal, factor)

    def finished(self, unit: float) -> SphereMesh:
        """The mesh, once its lengths are geodesic."""
        triangulation = Triangulation(self.corners.reshape(-1, 3))
        along = triangulation.edge_halfedges[:, 0]
        try:
            metric = PolyhedralMetric.on(triangulation, unit * self.lengths[along])
        except InvalidMetric as error:
            raise InvalidParameter(f"{len(self.u)} vertices are too few for this metric: {error}") from None
        return SphereMesh(frozen(self.u), metric)


def _relax(mesh: _Mesh, density: Cells | None) -> _Mesh:
    """The best of all meshes on the way to angles within the window."""
    everywhere = np.ones(len(mesh.u), dtype=bool)
    best, least = mesh, np.inf
    for sweep in range(SWEEPS + 1):
        mesh.flip_roughly()
        beyond = float(mesh.beyond().max())
        if beyond < least:
            best, least = mesh.copy(), beyond
        if least <= 0.0:
            break
        mesh.move(density, everywhere, sweep < OPTIMAL_SWEEPS)

    mesh, least, moved = best.copy(), np.inf, everywhere
    fewest, stale = len(mesh.corners), 0
    for touch in range(TOUCHES + 1):
        mesh.flip(moved)
        beyond_each = mesh.beyond()
        beyond, bad = float(beyond_each.max()), int(np.count_nonzero(beyond_each > 0.0))
        fewest, stale = (bad, 0) if bad < fewest else (fewest, stale + 1)
        if beyond < least:
            best, least = mesh.copy(), beyond
        if bad == 0 or stale == PATIENCE:
            break
        moved = mesh.about(beyond_each > 0.0, RINGS + stale // STUCK)
        # Each kind of step frees what the other is stuck in.
        mesh.move(density, moved, touch % (2 * OPTIMAL_SWEEPS) < OPTIMAL_SWEEPS)
    return best
