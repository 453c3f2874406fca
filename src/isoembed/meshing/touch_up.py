"""Local relaxation of a large mesh."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.meshing.flips import corner_angles, flip_where_touched
from isoembed.meshing.lloyd import RINGS, lloyd_step
from isoembed.meshing.loops import judge, surroundings
from isoembed.meshing.surface import Surface, vertex_density

GOOD, OUTSIDE, INWARD = 0, 1, 2
PATIENCE = 200  # sweeps without progress after which the relaxation ends


def touch_up(
    surface: Surface, u: Floats, faces: Indices, twin: Indices, window: Floats
) -> tuple[Floats, Indices]:
    """Directions (V, 3) and triangles (F, 3) after Lloyd steps and flips near angles outside a window.

    The iteration starts with a Delaunay triangulation of the directions u and ends when all angles are within
    the window (2,), in radians, or after `PATIENCE` sweeps; the mesh with the best angles is returned.
    """
    u, faces, twin = u.copy(), faces.copy(), twin.copy()
    x, normals = surface._points(u), surface._normals(u)
    angles, verdicts = corner_angles(x, faces), np.zeros(len(faces), dtype=np.int8)
    judge(x, normals, faces, angles, window, np.arange(len(faces)), verdicts)
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
        moving, touched = surroundings(faces, twin, bad, len(u), RINGS)
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
        judge(x, normals, faces, angles, window, np.concatenate([touched, flipped]), verdicts)
    return best
