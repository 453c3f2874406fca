"""What a convex polyhedron is called, and whether two are the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from isoembed.alexandrov.polyhedron import ConvexPolyhedron
from isoembed.cli.summary import summary
from isoembed.surface.embedding import Embedding

SAME = 1e-6  # relative: lengths of solids that are told apart by eye

FACES = {
    4: "tetrahedron",
    5: "pentahedron",
    6: "hexahedron",
    7: "heptahedron",
    8: "octahedron",
    12: "dodecahedron",
    20: "icosahedron",
}
SIDES = {3: "triangle", 4: "quadrilateral", 5: "pentagon", 6: "hexagon"}

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """The corners, edges and faces that a polyhedron really has.

    Attributes
    ----------
    vertices, edges, faces : int
        Of a doubly covered polygon those of both sides: two faces.
    name : str
    distances : ndarray
        All distances between two corners, in order: the same for congruent solids and mirror images.
    """

    vertices: int
    edges: int
    faces: int
    name: str
    distances: Floats

    @classmethod
    def of(cls, polyhedron: ConvexPolyhedron) -> Solid:
        """Look at a polyhedron without its flat vertices."""
        corner = np.ones(len(polyhedron.vertices), dtype=np.bool_)
        corner[polyhedron.flat_vertices] = False
        loops = [[v for v in polygon if corner[v]] for polygon in polyhedron.polygons]
        scaled = polyhedron.vertices / polyhedron.metric.unit
        return cls(
            int(corner.sum()),
            sum(map(len, loops)) // 2,
            len(loops),
            _name(loops, scaled, polyhedron.given.deficits[corner]),
            np.sort(pdist(scaled[corner])) * polyhedron.metric.unit,
        )

    def __str__(self) -> str:
        return f"{self.name}: {self.vertices} vertices, {self.edges} edges, {self.faces} faces"

    def is_congruent(self, other: Solid) -> bool:
        """Whether the two are the same up to motions and mirror images, as far as distances tell."""
        return len(self.distances) == len(other.distances) and np.allclose(
            self.distances, other.distances, rtol=0, atol=SAME * self.distances[-1]
        )


def _name(loops: list[list[int]], vertices: Floats, deficits: Floats) -> str:
    if len(loops) == 2:
        return f"doubly covered {SIDES.get(len(deficits), f'{len(deficits)}-gon')}"
    lengths = np.concatenate(
        [np.linalg.norm(vertices[loop] - vertices[np.roll(loop, 1)], axis=1) for loop in loops]
    )
    name = FACES.get(len(loops), f"{len(loops)}-hedron")
    alike = np.ptp(lengths) < SAME * lengths.max() and np.ptp(deficits) < SAME
    if alike and len({len(loop) for loop in loops}) == 1:
        return "cube" if len(loops) == 6 else f"regular {name}"
    return name


def described(embedding: Embedding) -> str:
    """Return the summary that ``isoembed glue`` prints where no output file is asked for."""
    if isinstance(embedding, ConvexPolyhedron):
        return f"{Solid.of(embedding)}\n\n{summary(embedding)}"
    return summary(embedding)
