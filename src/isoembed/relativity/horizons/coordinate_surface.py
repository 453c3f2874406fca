"""The smooth surface through the points of a file: star-shaped, or mapped where it has triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface


def coordinate_surface(found: CoordinateShape) -> StarSurface | MappedSurface:
    """The surface through the points of a file, with its notes.

    A file's triangles are used where the center does not see all of them from inside, and where a surface in
    mapped coordinates fits their corners much better.

    Raises
    ------
    InvalidParameter
        The points are not star-shaped about the center, and there are no triangles; or the triangles are too
        few for a smooth surface.
    """
    surface = _fitted(found)
    return replace(surface, notes=(*found.notes, *surface.notes)) if found.notes else surface


def _fitted(found: CoordinateShape) -> StarSurface | MappedSurface:
    if found.is_hull:
        star = StarSurface.from_points(found.points, found.center.tolist(), found.faces)
        # Points with a larger misfit are not star-shaped.
        if star.misfit > 0.1 * star.mean_radius:
            relative = 100.0 * star.misfit / star.mean_radius
            raise InvalidParameter(
                f"{found.source or 'the points'}: a surface r(u) about the center {written(found.center)} "
                f"misses the points by {star.misfit:.2g}, {relative:.2g} % of its radius: they are not "
                "star-shaped about it, and other shapes take triangles (faces) between the points"
            )
        return star
    if not _is_seen(found):
        return MappedSurface.from_mesh(found.points, found.faces)
    star = StarSurface.from_points(found.points, found.center.tolist())
    # Such a fit needs no comparison with a mapped surface.
    if star.misfit <= 1e-4 * star.mean_radius:
        return star
    try:
        mapped = MappedSurface.from_mesh(found.points, found.faces)
    except (InvalidMetric, InvalidParameter):  # degenerate triangles, or too few: the points are enough
        return star
    return mapped if mapped.misfit < 0.1 * star.misfit else star  # a mapped surface must fit ten times better


def _is_seen(found: CoordinateShape) -> bool:
    """Whether the center sees all triangles from inside."""
    arrows = found.points - found.center
    a, b, c = (arrows / np.abs(arrows).max())[found.faces].transpose(1, 0, 2)
    return bool((np.einsum("fi,fi->f", a, np.cross(b, c)) > 0.0).all())
