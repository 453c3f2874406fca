"""Initial surfaces of smooth embeddings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import frozen
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized

SURFACE, COORDINATES = "surface", "coordinates"


@dataclass(frozen=True, eq=False)
class Start:
    """Initial map X from the sphere into R^3 for an embedding.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Coefficients of X.
    coordinates : SphereMap, optional
        Map u = F(v) to the metric's directions u from the directions v of the harmonics; by default the
        identity.
    """

    harmonics: Harmonics
    coefficients: Floats
    coordinates: SphereMap | None = None

    def __post_init__(self) -> None:
        # Fixed memory layout, on which sums may depend, for bitwise reproducible results after restoring.
        coefficients = np.array(self.coefficients, dtype=np.float64, order="C")
        object.__setattr__(self, "coefficients", frozen(coefficients))

    @classmethod
    def of(cls, surface: SmoothEmbedding | Start) -> Start:
        """Start from a surface."""
        return cls(surface.harmonics, surface.coefficients, surface.coordinates)

    @classmethod
    def restored(cls, arrays: Mapping[str, NDArray]) -> Start:
        """Start restored from its `arrays`, bit by bit."""
        coordinates = f"{COORDINATES}/degrees" in arrays
        return cls(
            *_restored(SURFACE, arrays), SphereMap(*_restored(COORDINATES, arrays)) if coordinates else None
        )

    @property
    def arrays(self) -> dict[str, NDArray]:
        """Named arrays: ``coefficients`` and ``degrees`` of the surface and of its coordinates, if any."""
        arrays = _arrays_of(SURFACE, self.harmonics, self.coefficients)
        if self.coordinates is not None:
            arrays |= _arrays_of(COORDINATES, self.coordinates.harmonics, self.coordinates.coefficients)
        return arrays

    def in_directions_of(self, coordinates: SphereMap | None, harmonics: Harmonics) -> Floats:
        """Coefficients (size, 3) in harmonics of the directions of other coordinates."""
        if self.coordinates is coordinates:
            return resized(self.coefficients, self.harmonics, harmonics)
        transform = SphereTransform(harmonics, 2 * harmonics.degree, 4 * harmonics.degree)
        u = transform.u if coordinates is None else coordinates.forward(transform.u)
        v = u if self.coordinates is None else self.coordinates.inverse(u)
        return transform.analysis(self.harmonics.derivatives(v, self.coefficients)[0])


def _arrays_of(name: str, harmonics: Harmonics, coefficients: Floats) -> dict[str, NDArray]:
    degrees = np.array([harmonics.degree, harmonics.order])
    return {f"{name}/coefficients": coefficients, f"{name}/degrees": degrees}


def _restored(name: str, arrays: Mapping[str, NDArray]) -> tuple[Harmonics, Floats]:
    degree, order = map(int, arrays[f"{name}/degrees"])
    return Harmonics(degree, order), arrays[f"{name}/coefficients"]
