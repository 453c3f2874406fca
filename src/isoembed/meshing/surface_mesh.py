"""Triangulations of a closed-form surface, regular and irregular.

Regular meshes: distribute, connect and relax points, and keep the best mesh. Irregular: connected blue noise.
"""

from operator import index
from typing import SupportsIndex

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.meshing.blue_noise import CANDIDATES, blue_noise_directions, least_crowded
from isoembed.meshing.flips import corner_angles, flip_to_delaunay, twin_halfedges
from isoembed.meshing.lloyd import lloyd_step
from isoembed.meshing.sphere import fibonacci_lattice, hull_faces
from isoembed.meshing.spreading import Cells
from isoembed.meshing.surface import Surface, ZoneSurface, spread_directions, vertex_density
from isoembed.meshing.touch_up import touch_up
from isoembed.meshing.zone import ZoneLayout, even_points

MIN_VERTICES = 12  # of a triangulated surface
LARGE = 20_000  # vertices: in larger meshes only those near bad angles move
ANGLES = (38.0, 97.0)  # degrees: target range of the relaxation


def _inward_faces(vertices: Floats, normals: Floats, faces: Indices) -> int:
    """Number of triangles oriented opposite to the surface normals."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), normals[faces].sum(axis=1))
    return int(np.count_nonzero(outward <= 0.0))


def checked_count(name: str, value: SupportsIndex, minimum: int, maximum: float = np.inf) -> int:
    """Validate an integer between bounds.

    Raises
    ------
    InvalidParameter
        The value is not an integer, or out of bounds.
    """
    try:
        n = index(value)
    except TypeError:
        raise InvalidParameter(f"{name} must be an integer, not {value!r}") from None
    if n < minimum:
        raise InvalidParameter(f"{name} must be at least {minimum}, not {n}")
    if n > maximum:
        raise InvalidParameter(f"{name} must be at most {maximum}, not {n}")
    return n


def triangulate(
    surface: Surface | ZoneSurface, n_vertices: SupportsIndex, *, irregular: SupportsIndex | None = None
) -> tuple[Floats, Indices]:
    """Triangulate a surface, with vertices on it, by nearly equilateral or irregular triangles.

    Parameters
    ----------
    surface
        Surface, such as those of `isoembed.gallery`.
    n_vertices
        Exact number of vertices, at least 12.
    irregular
        None for nearly equilateral triangles; a nonnegative integer seed for irregular ones.

    Returns
    -------
    vertices : (V, 3)
        Points of the surface, on closed surfaces of genus 0 denser where it is more curved. Those on a
        boundary come first.
    faces : (F, 3)
        Triangles, oriented outward. The same input gives the same mesh.

    Raises
    ------
    InvalidParameter
        If ``n_vertices`` is not an integer of at least 12, or so small that all would be on the boundary, or
        ``irregular`` is not a nonnegative integer.

    Notes
    -----
    Regular meshes: a Fibonacci lattice with the prescribed density, connected by the convex hull of its
    directions and Delaunay flips, is relaxed by Lloyd steps alternating with flips, until all angles are in
    38-97 degrees or for 100 sweeps; the mesh with the best angles is returned. Beyond 20,000 vertices only
    those near angles outside of this range move. Irregular meshes: blue noise of the same density (random
    points with a minimal distance), connected in the same way but not relaxed; angles are in about 15-135
    degrees. Surfaces with boundary, and tori, are triangulated in the same way, by `isoembed.meshing.zone`,
    with uniform density and angles between 35 and 100 degrees.
    If the vertices are too few for the surface's sharpest features, either range may be missed.
    """
    n = checked_count("the number of vertices", n_vertices, MIN_VERTICES)
    seed = None if irregular is None else checked_count("the seed of an irregular mesh", irregular, 0)
    if isinstance(surface, ZoneSurface):
        return _zone_mesh(surface, n, seed)
    if seed is None:
        return _regular(surface, n)
    u = blue_noise_directions(surface, n, seed)
    faces = hull_faces(u)
    faces, _ = flip_to_delaunay(surface._points(u), surface._normals(u), faces, twin_halfedges(faces))
    return surface.point(u), faces


def _regular(surface: Surface, n: int) -> tuple[Floats, Indices]:
    u = spread_directions(surface, fibonacci_lattice(n))
    faces = hull_faces(u)
    twin = twin_halfedges(faces)
    if n > LARGE:
        faces, twin = flip_to_delaunay(surface._points(u), surface._normals(u), faces, twin)
        u, faces = touch_up(surface, u, faces, twin, np.radians(ANGLES))
    else:
        u, faces = _relaxed(surface, u, faces, twin)
    return surface.point(u), faces


def _relaxed(surface: Surface, u: Floats, faces: Indices, twin: Indices) -> tuple[Floats, Indices]:
    lower, upper = np.radians(ANGLES)
    best, best_score = (u, faces), (len(faces) + 1, np.inf)
    for _ in range(101):  # a hundred sweeps of all vertices
        x, normals = surface._points(u), surface._normals(u)
        faces, twin = flip_to_delaunay(x, normals, faces, twin)
        angles = corner_angles(x, faces)
        beyond = max(lower - angles.min(), angles.max() - upper)
        score = (_inward_faces(x, normals, faces), float(beyond))
        if score < best_score:
            best, best_score = (u, faces), score
        if score <= (0, 0.0):
            break
        u = surface._moved(u, lloyd_step(x, normals, faces, vertex_density(surface, u)))
    return best


def _zone_mesh(surface: ZoneSurface, n: int, seed: int | None) -> tuple[Floats, Indices]:
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
