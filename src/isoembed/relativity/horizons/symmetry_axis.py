"""Axis of rotational symmetry of a slice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.horizons.radial_image import HIGHEST_DEGREES, is_symmetric
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.relativity.spacetimes.transformed import RotatedFrame
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized


def horizon_in_slice(found: FoundHorizon, frame: RotatedFrame) -> FoundHorizon:
    """Transform a horizon from a frame with the symmetry axis as its z-axis to the slice."""
    return replace(found, surface=_surface_in_slice(found.surface, frame), geometry=frame.geometry)


def averaged(surface: StarSurface, frame: RotatedFrame) -> StarSurface:
    """Surface of revolution in a frame, by the mean of the radius of a surface about the axis."""
    rotation, origin = frame.rotation, frame.origin
    degree = surface.harmonics.degree
    T = SphereTransform(Harmonics(degree, 0), degree + 1, 1)
    u, _ = gauss_rule(degree + 1, 2 * degree + 2)
    r = surface.radius(u @ rotation.T).reshape(degree + 1, -1).mean(axis=1)
    center = rotation.T @ (np.array(surface.center) - origin)
    return StarSurface((0.0, 0.0, float(center[2])), T.harmonics, T.analysis(r[:, None])[:, 0])


def _surface_in_slice(found: StarSurface | MappedSurface, frame: RotatedFrame) -> StarSurface | MappedSurface:
    """Transform a surface of revolution from a frame to the coordinates of the slice.

    The result is star-shaped, by the addition theorem of harmonics, unless the degree is too high; otherwise
    it is a map from the directions of the frame.
    """
    rotation, origin = frame.rotation, frame.origin
    if isinstance(found, StarSurface) and found.harmonics.degree <= HIGHEST_DEGREES[0]:
        center = (origin + rotation @ np.array(found.center)).tolist()
        harmonics = Harmonics(found.harmonics.degree, found.harmonics.degree)
        fit = deviating(found.harmonics)
        drawn = None
        if found.deviations is not None:
            zonal = resized(found.deviations.T, fit, Harmonics(fit.degree, 0)).T
            drawn = np.stack([_turned(each, fit, rotation[:, 2]) for each in zonal])
        f = _turned(found.coefficients, harmonics, rotation[:, 2])
        return StarSurface(center, harmonics, f, found.misfit, drawn, found.notes)
    mapped = _mapped(found) if isinstance(found, StarSurface) else found
    coefficients = mapped.coefficients @ rotation.T
    coefficients[0] += np.sqrt(4.0 * np.pi) * origin
    drawn = None if mapped.deviations is None else mapped.deviations @ rotation.T
    return MappedSurface(
        mapped.harmonics, coefficients, misfit=mapped.misfit, deviations=drawn, notes=mapped.notes
    )


def _turned(zonal: Floats, harmonics: Harmonics, axis: Floats) -> Floats:
    """Coefficients of a function of the angle from an axis, by the addition theorem of harmonics."""
    degrees, _ = harmonics.labels
    Y = harmonics.values(axis[None])[0]
    return np.asarray(np.sqrt(4.0 * np.pi / (2.0 * degrees + 1.0)) * zonal[degrees] * Y)


def symmetry_axis(geometry: ThreeGeometry, sphere: StarSurface) -> RotatedFrame | None:
    """Frame with a symmetry axis of a slice through the center of a sphere as its z-axis.

    Candidates are the dipole and the principal axes of the expansion on the sphere; an axis is accepted if
    the expansion of several surfaces is symmetric about it.  The result is None if no candidate is accepted,
    which may also happen to a slice with an axis if the dipole vanishes and the quadrupole is degenerate.
    Raises `InvalidMetric` or `InvalidParameter`: the sphere leaves the domain of the slice.
    """
    center = np.array(sphere.center)
    u, weights = gauss_rule(128, 256)  # resolves the expansion around fast holes to rounding
    theta = sphere.expansion(geometry, u) * weights
    quadrupole = np.einsum("n,ni,nj->ij", theta, u, u)
    dipole = theta @ u
    scale = np.abs(theta).sum()
    candidates = list(np.linalg.eigh(quadrupole)[1].T)
    if np.linalg.norm(dipole) > 1e-9 * scale:
        candidates.insert(0, dipole / np.linalg.norm(dipole))
    for axis in candidates:
        frame = RotatedFrame(geometry, center, _upright(axis))
        if is_symmetric(frame, StarSurface.sphere((0.0, 0.0, 0.0), sphere.mean_radius)):
            return frame
    return None


def _upright(axis: Floats) -> Floats:
    """Rotation (3, 3) that maps z to an axis."""
    first = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis], axis=1)


def _mapped(star: StarSurface) -> MappedSurface:
    """Exact representation of a surface of revolution as a map, in harmonics of one degree more."""
    assert star.harmonics.order == 0
    harmonics = Harmonics(star.harmonics.degree + 1, 1)
    T = SphereTransform(harmonics, harmonics.degree + 1, 4)
    x = star.points(T.u)
    return MappedSurface(harmonics, T.analysis(x), misfit=star.misfit)
