"""Relaxation of a triangulation on the sphere until its triangles are nearly equilateral in a metric."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.delaunay_loops import flip_to_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.meshing.flips import twin_halfedges
from isoembed.meshing.lloyd import OVERRELAXATION, RINGS
from isoembed.meshing.loops import relaxed
from isoembed.meshing.sphere import hull_faces
from isoembed.meshing.spreading import Cells

OPTIMAL_SWEEPS = 10  # sweeps toward optimal Delaunay meshes, before centroidal ones
MAX_GEODESICS = 50.0  # measured per edge: more than needed for smooth metrics
FLIP_ROUNDS = 5  # alternating flips and measurements, which may reverse flips


@dataclass(eq=False)
class MetricMesh:
    """Triangulation of the sphere of directions during relaxation.

    A triangulation of a zone is closed by cones over the boundaries, with legs so long that no flip affects
    them.

    Attributes
    ----------
    tensor : callable
        Takes unit vectors (n, 3) and returns the metric (n, 3, 3) there.
    distances : callable
        Takes two arrays of unit vectors (n, 3) and returns the lengths (n,) of the geodesics between them.
    u : ndarray, shape (V, 3)
        Directions of the vertices.
    tables : HalfEdges
        Triangles with their lengths.
    boundary : int
        Number of vertices on the boundary: the first ones, which are fixed.
    apexes : int
        Number of cones: their apexes are the last vertices, which are fixed.
    """

    tensor: Callable[[Floats], Floats]
    distances: Callable[[Floats, Floats], Floats]
    u: Floats
    tables: HalfEdges
    boundary: int = 0
    apexes: int = 0

    @classmethod
    def hull(
        cls,
        u: Floats,
        tensor: Callable[[Floats], Floats],
        distances: Callable[[Floats, Floats], Floats],
        boundary: int = 0,
        apexes: int = 0,
    ) -> MetricMesh:
        """Convex hull of directions (V, 3), with lengths not yet computed."""
        faces = hull_faces(u)
        tables = HalfEdges.of(faces, twin_halfedges(faces), np.ones(faces.shape))
        return cls(tensor, distances, u, tables, boundary, apexes)

    def copy(self) -> MetricMesh:
        """Copy with independent tables."""
        return replace(self, tables=self.tables.copy())

    @property
    def is_cone(self) -> Mask:
        """Mask of the triangles that belong to cones over boundaries, shape (F,)."""
        return np.asarray((self.tables.faces >= self.n_vertices).any(axis=1))

    @property
    def n_vertices(self) -> int:
        """Number of vertices without apexes."""
        return len(self.u) - self.apexes

    def delaunay(self) -> MetricMesh:
        """Flip edges until the triangles are Delaunay; returns the mesh itself."""
        self._flip_roughly()
        self._flip(np.ones(len(self.u), dtype=bool))
        return self

    def relaxed(self, density: Cells | None) -> MetricMesh:
        """Best mesh of a relaxation toward angles within the window.

        Parameters
        ----------
        density : Cells, optional
            Prescribed number of vertices per area, up to a factor; by default uniform.
        """
        mesh, everywhere = self, np.ones(len(self.u), dtype=bool)
        everywhere[: self.boundary] = everywhere[self.n_vertices :] = False
        best, smallest = mesh, np.inf
        for sweep in range(31):  # thirty sweeps of all vertices
            mesh._flip_roughly()
            beyond = float(mesh._beyond().max())
            if beyond < smallest:
                best, smallest = mesh.copy(), beyond
            if smallest <= 0.0:
                break
            mesh._move(density, everywhere, sweep < OPTIMAL_SWEEPS)

        mesh, smallest, moved = best.copy(), np.inf, np.ones(len(self.u), dtype=bool)
        fewest, stale, spent = len(mesh.tables.corners), 0, 0
        for touch in range(301):  # of the vertices near bad angles
            spent += mesh._flip(moved)
            beyond_each = mesh._beyond()
            beyond, bad = float(beyond_each.max()), int(np.count_nonzero(beyond_each > 0.0))
            fewest, stale = (bad, 0) if bad < fewest else (fewest, stale + 1)
            if beyond < smallest:
                best, smallest = mesh.copy(), beyond
            much = spent > MAX_GEODESICS * len(mesh.tables.corners) / 2.0
            if bad == 0 or stale == 40 or much:  # sweeps without progress
                break
            # after every eight sweeps without progress, vertices one edge farther away move, too
            moved = mesh._about(beyond_each > 0.0, RINGS + stale // 8) & everywhere
            # Each kind of step escapes stationary states of the other.
            mesh._move(density, moved, touch % (2 * OPTIMAL_SWEEPS) < OPTIMAL_SWEEPS)
        return best

    def _flip_roughly(self) -> None:
        """Flip to Delaunay with lengths from the metric at the vertices only."""
        q = np.zeros((len(self.u), 3, 3))
        q[: self.n_vertices] = self.tensor(self.u[: self.n_vertices])
        self._measure_roughly(q)
        for _ in range(FLIP_ROUNDS):
            if len(flip_to_delaunay(self.u, self.tables.views)) == 0:
                break
            self._measure_roughly(q)

    def _measure_roughly(self, q: Floats) -> None:
        """Measure all edges by tensors (V, 3, 3) at the vertices, and set the legs of cones much longer."""
        end_lengths(self.u, q, self.tables)
        legs = self._legs
        self.tables.lengths[legs] = 1e4 * self.tables.lengths[~legs].max()

    @property
    def _legs(self) -> Mask:
        """Mask of the half-edges between vertices and apexes of cones, shape (3F,)."""
        begins = self.tables.corners >= self.n_vertices
        return np.asarray(begins | begins[self.tables.twins])

    def _measure(self, h: Indices) -> int:
        """Measure the edges of half-edges, and return their number."""
        corners, twins, lengths, _, _ = self.tables
        h = np.unique(np.minimum(h, twins[h]))
        h = h[~self._legs[h]]
        lengths[h] = lengths[twins[h]] = self.distances(self.u[corners[h]], self.u[corners[twins[h]]])
        return len(h)

    def _flip(self, moved: Mask) -> int:
        """Flip to Delaunay by geodesic lengths, reusing those between vertices that have not moved.

        Returns the number of measured edges.
        """
        h, measured = np.flatnonzero(moved[self.tables.corners]), 0
        for _ in range(FLIP_ROUNDS):
            measured += self._measure(h)
            h = flip_to_delaunay(self.u, self.tables.views)
            if len(h) == 0:
                return measured
        return measured + self._measure(h)

    def _beyond(self) -> Floats:
        """Excess (F,) of each triangle's angles beyond the window."""
        # degrees
        angles, (lower, upper) = angles_from_lengths(self.tables.lengths), np.radians((35.0, 100.0))
        beyond = np.maximum(lower - angles.min(axis=1), angles.max(axis=1) - upper)
        return np.where(self.is_cone, 0.0, beyond)

    def _about(self, faces: Mask, rings: int) -> Mask:
        """Mask of the vertices within a number of edges of triangles."""
        table = self.tables.corners.reshape(-1, 3)
        near = np.zeros(len(self.u), dtype=bool)
        for _ in range(rings):
            near[table[faces]] = True
            faces = np.asarray(near[table].any(axis=1))
        return near

    def _move(self, density: Cells | None, moving: Mask, optimal: bool) -> None:
        """Move vertices toward the optimal positions within the triangles around them."""
        wanted = np.ones(len(self.u)) if density is None else density.at(self.u)
        factor = 1.0 if optimal else OVERRELAXATION
        self.u = relaxed(self.u, self.tables.views, wanted, moving, optimal, factor)


def angles_from_lengths(lengths: Floats) -> Floats:
    """Angles (F, 3) in radians, 0 and pi if the lengths form no triangle: `angle_between` for arrays."""
    sides = lengths.reshape(-1, 3)
    third, s = np.roll(sides, 1, axis=1), np.roll(sides, -1, axis=1)
    a, b = np.maximum(sides, third), np.minimum(sides, third)
    mu = np.where(b >= s, s - (a - b), b - (a - s))
    sine, cosine = (a - b + s) * mu, (a + (b + s)) * np.maximum(a - s + b, 0.0)
    return np.asarray(2 * np.arctan2(np.sqrt(np.maximum(sine, 0.0)), np.sqrt(cosine)))


def end_lengths(u: Floats, q: Floats, mesh: HalfEdges) -> None:
    """Measure all half-edges by the mean of the metric tensors q (V, 3, 3) at their ends, in place.

    The lengths are second-order accurate, and exact on round spheres.
    """
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    lower = np.flatnonzero(np.arange(twins.size) < twins)
    upper = twins[lower]
    i, j = corners[lower], corners[upper]
    chords = u[j] - u[i]
    half = 0.5 * np.sqrt((chords**2).sum(axis=1))
    squares = 0.5 * np.einsum("ha,hab,hb->h", chords, q[i] + q[j], chords)
    # The tangential component of the chord is the sine of the arc.
    with np.errstate(divide="ignore", invalid="ignore"):  # coincident or antipodal vertices
        lengths[lower] = np.sqrt(squares) * np.arcsin(half) / (half * np.sqrt(1.0 - half**2))
    lengths[upper] = lengths[lower]
