"""Standard deviations, bounds and differences of a surface's quantities, as records."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from isoembed.arrays import Floats
from isoembed.reprs import short_repr

INTEGRALS = ("area", "volume", "integrated_mean_curvature")
LOCAL = ("vertices", "normals", "dihedral_angles", "mean_curvature")


def root_mean_square(values: Floats) -> float:
    """Root mean square of nonnegative numbers whose squares may overflow."""
    top = float(values.max())
    return top * float(np.sqrt(np.mean((values / top) ** 2))) if 0.0 < top < np.inf else top


@short_repr
@dataclass(frozen=True, eq=False)
class Changes:
    """One number for each quantity of a surface.

    Attributes
    ----------
    vertices : ndarray, shape (V,)
        Displacements.
    normals : ndarray, shape (F,)
        Rotation angles of the triangles' normals, in radians.
    dihedral_angles : ndarray, shape (E,)
    mean_curvature : ndarray, shape (V,)
    area, volume, integrated_mean_curvature : float
    """

    vertices: Floats
    normals: Floats
    dihedral_angles: Floats
    mean_curvature: Floats
    area: float
    volume: float
    integrated_mean_curvature: float

    def scaled(self, unit: float) -> Self:
        """Changes in another unit, in which every length and length error is scaled by this factor."""
        return replace(
            self,
            vertices=unit * self.vertices,
            mean_curvature=self.mean_curvature / unit,
            area=unit * (unit * self.area),
            volume=unit * (unit * (unit * self.volume)),
            integrated_mean_curvature=unit * self.integrated_mean_curvature,
        )

    @property
    def report(self) -> dict[str, Any]:
        """Area, volume and int H dA, and the root mean square and maximum of each array."""
        found: dict[str, Any] = {name: getattr(self, name) for name in INTEGRALS}
        for name in LOCAL:
            values = np.abs(getattr(self, name))
            found[f"{name}_rms"] = root_mean_square(values)
            found[f"{name}_max"] = float(values.max())
        return found
