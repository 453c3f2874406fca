"""Result of a Wang-Yau energy: value, time function, image in Minkowski space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from isoembed.evidence import Evidence
from isoembed.relativity.energies.time_function import TimeFunction
from isoembed.reprs import short_repr
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.surface.estimate import Estimate


@short_repr
@dataclass(frozen=True)
class WangYau:
    """Wang-Yau energy of a surface.

    Attributes
    ----------
    energy : Estimate
        E(tau), in the unit of length.
    tau : TimeFunction
    embedding : SmoothEmbedding
        Embedding X of ``q + d tau d tau``; (tau, X) is the surface in Minkowski space.
    admissible : float
        Least ``K + det D^2 tau / (1 + |grad tau|^2)``; tau is admissible if it is positive.
    gradient : float
        Norm of the gradient of E in the coefficients of tau, which are lengths; 0 at a critical tau.
    least_second_derivative : float or None
        Least eigenvalue of the second derivatives: positive at a minimum, 0 if E is constant to second order
        (boosts, in Minkowski space); None if tau was given.
    embeddings : int
        Number of embeddings computed.
    notes : tuple of str
        Remarks on the interpretation of the energy.
    """

    energy: Estimate
    tau: TimeFunction
    embedding: SmoothEmbedding
    admissible: float
    gradient: float
    least_second_derivative: float | None
    embeddings: int
    notes: tuple[str, ...] = ()

    def mesh(self, vertices: int) -> dict[str, NDArray[Any]]:
        """Triangulation of the surface in Minkowski space, nearly equilateral in its projection.

        Returns
        -------
        dict of str to ndarray
            ``vertices`` (V, 3), the projection X, and ``faces`` (F, 3); at the vertices (V,) ``tau`` and the
            ``mean_curvature`` H0 of the projection.
        """
        triangulation = self.embedding.triangulated(vertices)
        u = triangulation.directions
        return {
            "vertices": self.embedding.points(u),
            "faces": triangulation.faces,
            "tau": self.tau.values(u),
            "mean_curvature": self.embedding.mean_curvature(u),
        }

    @property
    def evidence(self) -> Evidence | None:
        """Evidence that no time function has less energy; None if tau was given."""
        if self.least_second_derivative is None:
            return None
        return Evidence(
            "searched",
            f"Newton's method from tau = 0 in harmonics up to degree {self.tau.harmonics.degree}, to a local "
            "minimum; that no other is lower is not proven",
        )

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        degrees, orders = self.tau.harmonics.labels
        return {
            "wang_yau": self.energy.value,
            "error": self.energy.error,
            "admissible": self.admissible,
            "gradient": self.gradient,
            "least_second_derivative": self.least_second_derivative,
            "embeddings": self.embeddings,
            "tau": [
                {"degree": int(l), "order": int(m), "coefficient": float(c)}
                for l, m, c in zip(degrees, orders, self.tau.coefficients, strict=True)
                if l > 0
            ],
            "notes": list(self.notes),
            **(self.evidence.report if self.evidence else {}),
        }


def inadmissible(value: float) -> str:
    """Note on a least ``K + det D^2 tau / W^2`` that is not positive."""
    return (
        f"tau is not admissible: K + det D^2 tau / W^2 is {value:.3g} somewhere. The number may be quoted as "
        "E(tau), not as the Wang-Yau energy, which is the least over admissible tau"
    )
