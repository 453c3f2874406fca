"""Embedding as a differentiable function of the lengths: values, derivative and adjoint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.method import solve
from isoembed.methods import configured
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.stopping import below
from isoembed.surface.alignment import aligned
from isoembed.surface.checked import checked
from isoembed.surface.derivatives import LengthDerivatives
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem


@dataclass(frozen=True, eq=False)
class Linearized:
    """A surface at some lengths, with what its derivatives need.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    derivatives : LengthDerivatives
    gauge : ndarray, shape (3 V, 6)
        Of the motions dx, those with ``gauge^T dx = 0`` leave the vertices aligned to the reference.
    rigid : ndarray, shape (3 V, 6)
        Rigid motions, of which ``gauge^T rigid = 1``.
    """

    vertices: Floats
    derivatives: LengthDerivatives
    gauge: Floats
    rigid: Floats

    def jvp(self, changes: Floats) -> Floats:
        """How the vertices move, (V, 3), when the lengths change by dl, (E,)."""
        dx = self.derivatives.jvp(changes).ravel()
        return (dx - self.rigid @ (self.gauge.T @ dx)).reshape(-1, 3)

    def vjp(self, gradient: Floats) -> Floats:
        """Derivatives by the lengths, (E,), from those by the vertices, (V, 3)."""
        g = gradient.ravel()
        return self.derivatives.vjp((g - self.gauge @ (self.rigid.T @ g)).reshape(-1, 3))


@dataclass(frozen=True, eq=False)
class Realization:
    """The surface near a given one with other lengths, turned and moved onto it as near as may be.

    Its triangles are kept.  The vertices depend smoothly on the lengths, so that they can be differentiated.

    Parameters
    ----------
    surface : Embedding
        In R^3.

    Raises
    ------
    InvalidParameter
        The surface is not in R^3, or did not converge.
    """

    surface: Embedding

    def __post_init__(self) -> None:
        if not self.surface.space.is_euclidean:
            raise InvalidParameter(f"the surface is in {self.surface.space!r}, not in R^3")
        if not self.surface.converged:
            raise InvalidParameter(f"the surface is none to begin from: {self.surface.message}")

    def __call__(self, lengths: ArrayLike) -> Floats:
        """The vertices, (V, 3), with these lengths, (E,), in the order of the metric's edges.

        Raises
        ------
        InvalidMetric
            They are not lengths of a metric.
        NotEmbedded
            No surface with these lengths was found.
        """
        given, t = self.surface, self.surface.triangulation
        metric = given.metric.with_lengths(checked(lengths, (t.n_edges,), "lengths"))
        unit = metric.unit
        goal = metric.lengths / unit
        # From lengths nearby a few steps suffice; otherwise they are embedded anew.  In mean edge lengths.
        found = length_newton(
            LengthSystem(t),
            given.vertices / unit,
            goal,
            contraction(0.5),
            converged=below(1e-13 * goal.mean()),  # rounding
            max_iterations=20,
        )
        near = found.value <= 1e-10 * goal.mean()
        vertices = unit * found.point.x if near else solve(metric, configured("aim")).vertices
        return aligned(vertices, given.vertices)

    def linearized(self, lengths: ArrayLike) -> Linearized:
        """The surface with these lengths, and its derivatives by them.

        Raises
        ------
        InvalidMetric, NotEmbedded
            As the call.
        SingularMatrix
            It is not infinitesimally rigid.
        """
        x = self(lengths)
        unit = self.surface.metric.unit
        goal = np.asarray(lengths, dtype=np.float64) / unit
        derivatives = LengthDerivatives.of(self.surface.triangulation, x / unit, goal)
        # Aligned means: the same centroid, and sum y x dx = 0 about it, y being the reference.
        y = (self.surface.vertices - self.surface.vertices.mean(axis=0)) / unit
        constraints, rigid = _rigid_fields(y), _rigid_fields((x - x.mean(axis=0)) / unit)
        return Linearized(x, derivatives, constraints, rigid @ np.linalg.inv(constraints.T @ rigid))


def _rigid_fields(x: Floats) -> Floats:
    """Translations and rotations of points (V, 3) about the origin, as columns (3 V, 6)."""
    translations = [np.broadcast_to(axis, x.shape) for axis in np.eye(3)]
    rotations = [np.cross(axis, x) for axis in np.eye(3)]
    return np.stack([field.ravel() for field in translations + rotations], axis=1)
