"""Triangulations of closed-form surfaces parametrized by a spherical zone."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.meshing.blue_noise import CANDIDATES, least_crowded
from isoembed.meshing.spreading import Cells
from isoembed.meshing.surface import ZoneSurface
from isoembed.meshing.zone import ZoneLayout, even_points


def zone_mesh(surface: ZoneSurface, n: int, seed: int | None) -> tuple[Floats, Indices]:
    """Vertices (n, 3) on a surface and triangles (F, 3): nearly equilateral, or irregular with a seed."""

    def distances(start: Floats, end: Floats) -> Floats:
        return np.asarray(np.linalg.norm(surface._points(end) - surface._points(start), axis=1))

    def random_points(cells: Cells, k: int) -> Floats:
        u = cells.spread(np.random.default_rng(seed).random((CANDIDATES * k, 2)))
        return u[least_crowded(surface._points(u), np.ones(len(u)), cells.integral(), k)]

    layout = ZoneLayout(
        surface.zone, surface._tensor, surface._area_density, lambda u: np.ones(len(u)), surface.is_ring
    )
    if seed is None:
        mesh = layout.mesh(n, distances, even_points).relaxed(None)
    else:
        mesh = layout.mesh(n, distances, random_points).delaunay()
    u, faces = mesh.u[: mesh.n_vertices], mesh.tables.faces[~mesh.is_cone]
    if surface.is_ring:
        around = mesh.boundary // 2
        u = np.delete(u, np.s_[around : 2 * around], axis=0)
        faces = np.where(faces < around, faces, faces - around)
    return surface.point(u), faces
