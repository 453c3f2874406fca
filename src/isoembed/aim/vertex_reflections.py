"""Vertex reflections in the planes of the neighbors (mirror images), relaxed with the patch around.

No small motion moves a vertex to the other side of its neighbors: at flat places lengths change to second
order only.  Vertices with the largest residuals are therefore reflected, and the patch around each is
relaxed, with the linear response of the rest (`isoembed.aim.schur_complement`).

Where J becomes singular, the remaining errors r are a stress in equilibrium, and spread out.  If the
reflection of a vertex changes the lengths by d, the remaining square is ``(|r|^2 + r . d)^2 / |r|^2``, to
first order.
Shallow vertices, those near the planes of their neighbors, are therefore tried if ``r . d`` is negative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np

from isoembed.aim.schur_complement import Condensation, CondensedPatch
from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.local_fit import sums_at_ends

PATCHES = ((4, 3), (4, 4), (12, 3), (4, 5))  # numbers of centers, and of rings of their patches, in turn
SIDE_RINGS = 2  # rings around a center with reflected vertices
SHALLOW = 24  # vertices tried individually
RINGS = 3  # rings of their patches
LARGEST = 400  # vertices of a patch, with a dense matrix
PROMISE = (0.03, 2.0)  # bounds on -r . d over |r|^2 of a shallow vertex
GAIN = 1e-3  # significant relative decrease of the energy


class ReflectionTrial(NamedTuple):
    """Outcome of a reflection.

    Attributes
    ----------
    growth : float
        Change of the energy.
    patch : CondensedPatch
    motion : ndarray, shape (n, 3)
        Motion of its vertices.
    """

    growth: float
    patch: CondensedPatch
    motion: Floats

    @property
    def displacement(self) -> Floats:
        """Displacements of all vertices, (V, 3)."""
        return self.patch.followed(self.motion)


class ReflectionTrials:
    """Vertex reflections of a surface at a minimum of its energy.

    Parameters
    ----------
    surface : Condensation
    is_done : callable
        Whether to end the search.
    """

    def __init__(self, surface: Condensation, is_done: Callable[[], bool]) -> None:
        self.surface, self.is_done = surface, is_done

    @cached_property
    def _reflected(self) -> Floats:
        return reflections(self.surface.energy.triangulation, self.surface.vertices)

    def singles(self, kinds: int) -> Iterator[list[ReflectionTrial]]:
        """Promising reflections of single vertices, the best first, for each kind of patch."""
        return self._in_patches(PATCHES[:kinds], 1)

    def pairs(self) -> Iterator[list[ReflectionTrial]]:
        """Promising reflections of pairs of vertices, the best first."""
        # Without the largest kind of patch.
        return self._in_patches(PATCHES[:3], 2)

    def _in_patches(self, patches: Sequence[tuple[int, int]], count: int) -> Iterator[list[ReflectionTrial]]:
        tried: set[tuple[int, int]] = set()
        for centers, rings in patches:
            changes: list[ReflectionTrial] = []
            for center in self._largest_residuals(centers):
                if (center, rings) in tried:
                    continue
                tried.add((center, rings))
                flipped = combinations(self._about(center, SIDE_RINGS).tolist(), count)
                changes += self._relaxed(center, rings, flipped)
            yield self._promising(changes)

    def shallow(self) -> list[ReflectionTrial]:
        """Promising reflections of shallow vertices in disjoint patches, the best first."""
        changes: list[ReflectionTrial] = []
        for v in self._shallow():
            changes += self._relaxed(v, RINGS, [(v,)])
        occupied = np.zeros(len(self.surface.vertices), dtype=bool)
        apart = []
        for change in self._promising(changes):
            if not occupied[change.patch.vertices].any():
                occupied[change.patch.vertices] = True
                apart.append(change)
        return apart

    def _promising(self, changes: Sequence[ReflectionTrial]) -> list[ReflectionTrial]:
        """Trials that lower the energy, without invalid predictions below 0."""
        value = self.surface.value
        promising = [change for change in changes if -value < change.growth < -GAIN * value]
        return sorted(promising, key=lambda change: change.growth)

    def _relaxed(
        self, center: int, rings: int, flipped: Iterable[tuple[int, ...]]
    ) -> Iterator[ReflectionTrial]:
        """Outcomes of reflections of some vertices in the patch about a center."""
        vertices = self._about(center, rings)
        if self.is_done() or len(vertices) > LARGEST:
            return
        try:
            patch = self.surface.patch(vertices)
        except SingularMatrix:
            return
        for chosen in flipped:
            if self.is_done():
                return
            motion = np.zeros((len(patch.vertices), 3))
            motion[np.searchsorted(patch.vertices, chosen)] = self._reflected[list(chosen)]
            relaxed, growth = patch.relaxed(motion)
            # Remaining share of the displacement.
            if np.abs(relaxed).max() > 1e-3 * np.abs(motion).max():  # otherwise all have fallen back
                yield ReflectionTrial(growth, patch, relaxed)

    def _about(self, center: int, rings: int) -> Indices:
        """The vertices within a number of rings around one."""
        found, adjacency = np.array([center]), self.surface.energy.triangulation.adjacency
        for _ in range(rings):
            found = np.union1d(found, adjacency[found].indices)
        return found

    def _largest_residuals(self, count: int) -> Iterator[int]:
        """The vertices with the largest residuals, none near another."""
        residual_sums = sums_at_ends(self.surface.energy.triangulation, self.surface.residuals**2)
        free = np.ones(len(residual_sums), dtype=bool)
        for center in np.argsort(-residual_sums, kind="stable").tolist():
            if free[center]:
                yield center
                free[self._about(center, SIDE_RINGS)] = False
                count -= 1
                if not count:
                    return

    def _shallow(self) -> list[int]:
        """Vertices whose reflections change the lengths slightly and reduce the residual."""
        surface = self.surface
        t, x, moves = surface.energy.triangulation, surface.vertices, self._reflected
        return shallow(t, x, surface.lengths, surface.residuals, moves)[:SHALLOW].tolist()


def reflections(triangulation: Triangulation, vertices: Floats) -> Floats:
    """Motions, (V, 3), that reflect each vertex in the best-fitting plane of its neighbors."""
    n, (a, b) = triangulation.n_vertices, triangulation.edges.T
    at, of = np.concatenate([a, b]), np.concatenate([b, a])

    def sums(values: Floats) -> Floats:
        return np.stack([np.bincount(at, column, minlength=n) for column in values.T], axis=1)

    middles = sums(vertices[of]) / triangulation.degrees[:, None]
    away = vertices[of] - middles[at]
    spread = sums(np.einsum("hi,hj->hij", away, away).reshape(-1, 9)).reshape(-1, 3, 3)
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    return -2 * np.einsum("vi,vi->v", vertices - middles, normals)[:, None] * normals


def shallow(
    triangulation: Triangulation, vertices: Floats, lengths: Floats, residuals: Floats, moves: Floats
) -> Indices:
    """Vertices whose reflections reduce the residual, in increasing order of the change of the lengths.

    Parameters
    ----------
    triangulation : Triangulation
    vertices, moves : ndarray, shape (V, 3)
        Vertices, and the motions of `reflections`.
    lengths, residuals : ndarray, shape (E,)
        `isoembed.surface.rigidity.length_residuals` at a minimum of their squares.
    """
    r, x, moved = residuals, vertices, vertices + moves
    removed, changed = np.zeros((2, len(x)))
    for a, b in (triangulation.edges.T, triangulation.edges.T[::-1]):
        apart = np.linalg.norm(moved[a] - x[b], axis=1)
        d = (apart - lengths) * (apart + lengths) / (2 * lengths) - r
        removed -= np.bincount(a, r * d, minlength=len(x))
        changed += np.bincount(a, d**2, minlength=len(x))
    lower, upper = PROMISE
    promised = np.flatnonzero((removed > lower * (r @ r)) & (removed < upper * (r @ r)))
    return promised[np.argsort(changed[promised], kind="stable")]
