"""Combinatorics of a convex polyhedron: corners, edges, faces, name, congruence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import pdist

from isoembed.alexandrov.polyhedron import ConvexPolyhedron
from isoembed.arrays import Floats
from isoembed.space import Space

PREFIXES = {4: "tetra", 5: "penta", 6: "hexa", 7: "hepta", 8: "octa", 12: "dodeca", 20: "icosa"}
SIDES = {3: "triangle", 4: "quadrilateral", 5: "pentagon", 6: "hexagon"}
SAME = 1e-6  # relative difference of equal lengths or deficits


@dataclass(frozen=True, eq=False)
class Solid:
    """Corners, edges and faces of a polyhedron, without its flat vertices.

    Attributes
    ----------
    vertices, edges, faces : int
        Numbers of corners, edges and faces; a doubly covered polygon has two faces.
    name : str
        Name such as ``"cube"`` or ``"pentahedron"``.
    distances : ndarray
        All distances between two corners, ascending: equal for congruent solids and mirror images.
    """

    vertices: int
    edges: int
    faces: int
    name: str
    distances: Floats

    @classmethod
    def of(cls, polyhedron: ConvexPolyhedron) -> Solid:
        """Create the solid of a polyhedron."""
        corner = np.ones(len(polyhedron.vertices), dtype=np.bool_)
        corner[polyhedron.flat_vertices] = False
        loops = [[v for v in polygon if corner[v]] for polygon in polyhedron.polygons]
        scaled, space = polyhedron.vertices / polyhedron.metric.unit, polyhedron.metric.normalized.space
        return cls(
            int(corner.sum()),
            sum(map(len, loops)) // 2,
            len(loops),
            _name(loops, scaled, space, polyhedron.given.deficits[corner]),
            np.sort(_distances(scaled[corner], space)) * polyhedron.metric.unit,
        )

    def __str__(self) -> str:
        return f"{self.name}: {self.vertices} vertices, {self.edges} edges, {self.faces} faces"

    def is_congruent(self, other: Solid) -> bool:
        """Whether two solids agree up to motions and reflections, as judged by their distances."""
        return len(self.distances) == len(other.distances) and np.allclose(
            self.distances, other.distances, rtol=0, atol=SAME * self.distances[-1]
        )


def _distances(points: Floats, space: Space) -> Floats:
    """All distances between two points, in the order of `scipy.spatial.distance.pdist`."""
    if space.is_euclidean:
        return pdist(points)
    depths = np.einsum("ij,ij->i", points, points) / (1 + space.heights(points))  # (1 - w) / k
    return space.arc(np.sqrt(pdist(points) ** 2 + space.curvature * pdist(depths[:, None]) ** 2))


def _name(loops: list[list[int]], vertices: Floats, space: Space, deficits: Floats) -> str:
    if len(loops) == 2:
        return f"doubly covered {SIDES.get(len(deficits), f'{len(deficits)}-gon')}"
    lengths = np.concatenate([space.distances(vertices[loop], vertices[np.roll(loop, 1)]) for loop in loops])
    name = f"{PREFIXES.get(len(loops), f'{len(loops)}-')}hedron"
    alike = np.ptp(lengths) < SAME * lengths.max() and np.ptp(deficits) < SAME
    if alike and len({len(loop) for loop in loops}) == 1:
        return "cube" if len(loops) == 6 else f"regular {name}"
    return name
