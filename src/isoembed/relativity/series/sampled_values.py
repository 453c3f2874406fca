"""Content digest of horizons and slices in memory, from their values at sample points."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.horizons.horizon import GivenHorizon
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

SAMPLES = 64  # number of directions, or points of a surface
DIGITS = 8  # digits of values relative to the largest, as rounding of sums may vary between runs
FUNCTIONS = (
    "mean_curvature",
    "momentum",
    "normal_momentum",
    "shape",
    "gaussian_curvature",
    "torque",
)
"""Functions of the direction in `SurfaceData`."""


def values_digest(found: GivenHorizon, geometry: ThreeGeometry | None) -> str:
    """Hash of values at fixed directions, of the data or of the surface and the slice on it.

    Parameters
    ----------
    found : CoordinateShape, SurfaceData, Surface or FoundHorizon
    geometry : ThreeGeometry, optional
        Slice; by default that of a found horizon.
    """
    sha = hashlib.sha256()
    for values in _values(found, geometry):
        values = np.asarray(values, dtype=np.float64)
        largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0
        sha.update(f"{values.shape} {largest:.{DIGITS}e} ".encode())
        sha.update((np.round(values / largest, DIGITS) + 0.0).tobytes())  # + 0.0: no negative zeros
    return sha.hexdigest()


def _values(found: GivenHorizon, geometry: ThreeGeometry | None) -> Iterator[Floats]:
    u = fibonacci_directions(SAMPLES)
    if isinstance(found, SurfaceData):
        yield found.metric.tensor(u)
        for function in (getattr(found, name) for name in FUNCTIONS):
            if function is not None:
                yield function(u)
        return
    if isinstance(found, FoundHorizon):
        x, geometry = found.surface.points(u), geometry or found.geometry
    elif isinstance(found, CoordinateShape):
        x = found.points[:: len(found.points) // SAMPLES + 1]
    else:
        x = found.points(u)
    yield x
    if geometry is not None:
        yield geometry.metric(x)
        yield geometry.gradient(x)
        yield geometry.extrinsic_curvature(x)
        yield geometry.error(lambda other: other.metric(x).reshape(len(x), 9).T)
