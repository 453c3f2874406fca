"""Relaxation of a large mesh where it needs it: what the regular mesh of a large surface is made with."""

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.kernel import kernel
from isoembed.meshing.flips import corner_angles, flip_where_touched
from isoembed.meshing.lloyd import RINGS, lloyd_step
from isoembed.meshing.surface import Surface, vertex_density

GOOD, OUTSIDE, INWARD = 0, 1, 2


PATIENCE = 200  # sweeps after which fewer triangles should be bad


def touch_up(
    surface: Surface, u: Floats, faces: Indices, twin: Indices, window: Floats
) -> tuple[Floats, Indices]:
    """Directions (V, 3) and triangles (F, 3) after Lloyd steps and flips near angles outside a window.

    The steps begin with a Delaunay triangulation of the directions u and end when all angles are between
    those of the window (2,), in radians, or patience does; the mesh with the best angles is returned.
    """
    u, faces, twin = u.copy(), faces.copy(), twin.copy()
    x, normals = surface._points(u), surface._normals(u)
    angles, verdicts = corner_angles(x, faces), np.zeros(len(faces), dtype=np.int8)
    _judge(x, normals, faces, angles, window, np.arange(len(faces)), verdicts)
    best, best_score = (u, faces), (len(faces) + 1, np.inf)
    is_near, place = np.zeros(len(u), dtype=bool), np.empty(len(u), dtype=np.int64)
    fewest, stale = len(faces) + 1, 0
    while stale < PATIENCE:
        bad = np.flatnonzero(verdicts)
        if len(bad) == 0:
            return u, faces
        beyond = max(window[0] - angles[bad].min(), angles[bad].max() - window[1])
        score = (int(np.count_nonzero(verdicts == INWARD)), float(beyond))
        if score < best_score:
            best, best_score = (u.copy(), faces.copy()), score
        fewest, stale = (len(bad), 0) if len(bad) < fewest else (fewest, stale + 1)
        moving, touched = _surroundings(faces, twin, bad, len(u))
        is_near[:] = False
        is_near[faces[touched]] = True
        near = np.flatnonzero(is_near)
        place[near] = np.arange(len(near))
        with np.errstate(all="ignore"):  # triangles without area
            step = lloyd_step(
                x[near], normals[near], place[faces[touched]], vertex_density(surface, u[near])
            )[place[moving]]
        step[~np.isfinite(step).all(axis=1)] = 0.0
        u[moving] = surface._moved(u[moving], step)
        x[moving], normals[moving] = surface._points(u[moving]), surface._normals(u[moving])
        angles[touched] = corner_angles(x, faces[touched])
        flipped = flip_where_touched(x, normals, faces, twin, angles, touched)
        _judge(x, normals, faces, angles, window, np.concatenate([touched, flipped]), verdicts)
    return best


@kernel
def _judge(
    x: Floats,
    normals: Floats,
    faces: Indices,
    angles: Floats,
    window: Floats,
    which: Indices,
    verdicts: NDArray[np.int8],
) -> None:
    """Verdicts on some triangles, in place: good, an angle outside the window, or inward."""
    for f in which:
        a, b, c = faces[f]
        outward = 0.0
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            area = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j]) - (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
            outward += area * (normals[a, k] + normals[b, k] + normals[c, k])
        verdicts[f] = GOOD
        for angle in angles[f]:
            if not window[0] <= angle <= window[1]:
                verdicts[f] = OUTSIDE
        if not outward > 0.0:
            verdicts[f] = INWARD


@kernel
def _surroundings(faces: Indices, twin: Indices, seeds: Indices, n: int) -> tuple[Indices, Indices]:
    """The vertices within two edges of some triangles, and the triangles around them."""
    vertices, triangles = np.empty(n, dtype=np.int64), np.empty(len(faces), dtype=np.int64)
    seen_vertices, seen = np.zeros(n, dtype=np.bool_), np.zeros(len(faces), dtype=np.bool_)
    triangles[: len(seeds)] = seeds
    seen[seeds] = True
    n_vertices, begin, end = 0, 0, len(seeds)
    for _ in range(RINGS + 1):
        last = end
        for row in range(begin, last):
            for first in range(3 * triangles[row], 3 * triangles[row] + 3):
                v = faces[first // 3, first % 3]
                if seen_vertices[v]:
                    continue
                seen_vertices[v] = True
                vertices[n_vertices] = v
                n_vertices += 1
                h = first
                while True:
                    f = h // 3
                    if not seen[f]:
                        seen[f] = True
                        triangles[end] = f
                        end += 1
                    h = twin[3 * f + (h + 2) % 3]
                    if h == first:
                        break
        begin = last
    return vertices[:n_vertices].copy(), triangles[:end].copy()
