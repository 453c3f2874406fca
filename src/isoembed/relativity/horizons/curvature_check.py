"""Check of the Gaussian curvature in a horizon file against its metric.

The Gaussian curvature in a file and that of the metric induced by a geometry on its points agree only if
mass, spin, time and units are those of the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of
from isoembed.reprs import short_repr
from isoembed.smooth.scattered_fit import fitted
from isoembed.smooth.spectral_curvature import spectral_curvature

CURVATURES = {"gaussian_curvature": 1.0, "RicciScalar": 0.5}
"""Fields proportional to the Gaussian curvature, and the factors that convert them to it."""
PSI_2 = "repsi2"
SPIN_COEFFICIENTS = ("nprho", "npmu", "npsigma", "nplambda")


@short_repr
@dataclass(frozen=True)
class CurvatureCheck:
    """Difference between the curvature in a file and that of the metric in use.

    Attributes
    ----------
    field : str
        Field of the file: ``gaussian_curvature``, ``RicciScalar`` (twice that), or ``repsi2``, which gives
        ``K = 2 Re(-Psi_2 + rho mu - sigma lambda)`` in vacuum with the spin coefficients.
    largest, rms : float
        Maximum and root mean square of the difference at the points of the file, in 1/length^2.
    size : float
        Root mean square of K of the metric in use; positive by the Gauss-Bonnet theorem.
    expected : float
        Expected difference: the error of K from uncertain lengths plus the noise of the field, which is the
        residual of a fit of smooth functions.
    """

    field: str
    largest: float
    rms: float
    size: float
    expected: float

    @classmethod
    def of(
        cls, data: SurfaceData, found: CoordinateShape | None = None, directions: Floats | None = None
    ) -> CurvatureCheck | None:
        """Check of a surface from a file.

        Parameters
        ----------
        data : SurfaceData
            Surface in its slice; its ``gaussian_curvature`` is used without ``found``.
        found : CoordinateShape, optional
            Points of the file, with its fields.
        directions : ndarray, shape (V, 3), optional
            Directions of the points; by default those from the center.

        Returns
        -------
        CurvatureCheck or None
            None if the file has no curvature.
        """
        if found is None:
            brought = data.gaussian_curvature
            u = fibonacci_directions(400)
            return brought and cls._between(
                "gaussian_curvature", brought(u), error_of(brought).pointwise, u, data
            )
        field, stored = brought_curvature(found.fields)
        if stored is None:
            return None
        finite = np.isfinite(stored)
        u = (found.points - found.center if directions is None else directions)[finite]
        u /= np.linalg.norm(u, axis=1)[:, None]
        if len(u) < 8:  # too few to compare
            return None
        noise = fitted(u, stored[finite], np.ones(len(u))).misfit
        return cls._between(field, stored[finite], noise, u, data)

    @classmethod
    def _between(
        cls, field: str, stored: Floats, noise: float, u: Floats, data: SurfaceData
    ) -> CurvatureCheck:
        K = spectral_curvature(data.metric, data.lengths_error.mean)
        own = K(u)
        difference = own - stored
        largest = float(np.abs(difference).max())
        return cls(field, largest, _rms(difference), _rms(own), K.error.pointwise + noise)

    @property
    def agrees(self) -> bool:
        """Whether the difference is small and explained by errors."""
        # At most five times the expected error, and at most 5 % of K itself.
        return self.rms <= min(5.0 * self.expected, 0.05 * self.size)

    @property
    def relative(self) -> float:
        """Largest difference relative to the size of K."""
        return self.largest / self.size

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON, with the text as ``message``."""
        return {**asdict(self), "relative": self.relative, "agrees": self.agrees, "message": str(self)}

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentence on a difference that errors do not explain, if there is one."""
        if self.agrees:
            return ()
        return (
            f"the curvature in the file, from {self.field}, is not that of the metric in use: they differ by "
            f"{self.rms:.1e} (root mean square), errors explain {self.expected:.1e}; is it another geometry, "
            "mass, spin, time or unit?",
        )

    def __str__(self) -> str:
        return (
            f"K from {self.field} in the file and of this metric differ by at most {self.largest:.1e} "
            f"(relative: {self.relative:.1e}), " + ("within" if self.agrees else "beyond") + " their errors"
        )


def brought_curvature(fields: Mapping[str, Any]) -> tuple[str, Floats | None]:
    """Name of the field of a file that determines the Gaussian curvature, and that curvature or None.

    Notes
    -----
    QuasiLocalMeasures has ``rho = -m^a mbar^b D_b l_a``, ``sigma = -m^a m^b D_b l_a``, ``mu = mbar^a m^b D_b
    n_a`` and ``lambda = mbar^a mbar^b D_b n_a`` in the signature -+++ with l . n = -1: the expansions are
    -2 Re rho and 2 Re mu, and in Schwarzschild's spacetime rho mu = (1 - 2 M / r) / 2 r^2, Psi_2 = -M / r^3.
    The Gauss equation is that of Newman and Penrose, J. Math. Phys. 3 (1962) 566.
    """
    for name, factor in CURVATURES.items():
        if name in fields:
            return name, factor * np.asarray(fields[name], dtype=np.float64)
    parts = [f"{part}{name}" for name in SPIN_COEFFICIENTS for part in ("re", "im")]
    if any(name not in fields for name in (PSI_2, *parts)):
        return "", None
    rho, mu, sigma, lambda_ = (fields[f"re{name}"] + 1j * fields[f"im{name}"] for name in SPIN_COEFFICIENTS)
    return PSI_2, 2.0 * (-fields[PSI_2] + np.real(rho * mu - sigma * lambda_))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
