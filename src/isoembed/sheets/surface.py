"""Embeddings of surfaces with boundary or of higher genus."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.embedding.embedding import Embedding
from isoembed.mesh.triangulation import frozen
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.surface.measures import COPLANAR, above_boundary, cone_sum
from isoembed.surface.surface import Surface

if TYPE_CHECKING:
    from isoembed.proof.certificate import Certificate
    from isoembed.sheets.derivatives import SheetDerivatives
    from isoembed.sheets.fitted_curvature import FittedCurvatureRates

BALANCED = 1e-6  # largest imbalance of a minimum
FLAT = 1e-6  # int k1^2 + k2^2 of a flat sheet; about 1 for a radius of curvature equal to the width
ROUGH = 0.08  # fraction of rough edges: up to .05 on smooth sheets with K < 0, .1 to .25 on crumpled ones
MEASURED = 1e-9  # mean edge lengths: with a given curve, larger residuals are errors of the lengths


@dataclass(frozen=True, eq=False, repr=False)
class SheetSurface(Surface):
    """Surface with boundary, or of higher genus, with curvatures from the fits of its bending energy.

    Parameters
    ----------
    metric : PolyhedralMetric
        Normalized metric; its bending energy uses polynomials fitted to the neighbors of each vertex.
    """

    _: KW_ONLY
    metric: PolyhedralMetric

    @cached_property
    def _energy(self) -> BendingEnergy:
        return BendingEnergy(self.metric)

    @cached_property
    def bending_energy(self) -> float:
        """Integral of H^2 dA, from polynomials fitted to the neighbors of each vertex."""
        return self._energy.bending(self._normalized)

    @cached_property
    def second_form_energy(self) -> float:
        """Integral of k1^2 + k2^2 dA."""
        return self._energy.square_integral(self._normalized)

    @cached_property
    def mean_curvature(self) -> Floats:
        """Mean curvature H = (k1 + k2) / 2 at the vertices, shape (V,): positive where bent inward."""
        return frozen(self._normalized_mean_curvature / self.unit)

    @cached_property
    def _normalized_mean_curvature(self) -> Floats:
        return frozen(self._energy.mean_curvature(self._normalized))

    @cached_property
    def _above_boundary(self) -> Floats | None:
        return above_boundary(self.triangulation, self._normalized)

    @property
    def volume(self) -> float:
        """Enclosed volume, or that between a cap and the horizontal plane of its boundary.

        Raises
        ------
        InvalidMetric
            The boundary is not in a horizontal plane.
        """
        if self._above_boundary is None:
            return super().volume
        return abs(cone_sum(self.faces, self._above_boundary)) * self.unit * self.unit * self.unit

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA, in the unit of the lengths: 1/2 sum l theta if the surface is closed.

        With a boundary it is the sum of `mean_curvature` times thirds of triangles: on a smooth cap it is
        second-order accurate in the mesh size; 1/2 sum l theta, which omits the boundary, is first-order
        accurate.
        """
        if self.triangulation.is_closed:
            return super().integrated_mean_curvature
        return float(self._normalized_mean_curvature @ self._energy.areas) * self.unit


@dataclass(frozen=True, eq=False, repr=False)
class SheetEmbedding(Embedding):
    """Realization of a surface with boundary, or of higher genus.

    The volume of a cap is that between it and the plane of its boundary; for other surfaces with boundary, it
    raises `InvalidMetric`.  Surfaces with boundary have no outside: they are not mirrored, and the sign of
    the mean curvature depends on the side from which triangles are counterclockwise.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages, uniqueness
        See `Embedding`.
    condition : str
        Boundary condition.
    heights : ndarray, shape (B,), optional
        Heights of the boundary's vertices, in the order of `Triangulation.boundaries` and up to a constant,
        if prescribed; zeros for a boundary in a plane.
    tensions : ndarray, shape (E,), optional
        Tensions of the edges that balance the bending forces of a flexible surface of least bending, in units
        of the bending modulus over length.
    imbalance : float, optional
        Largest net force on a vertex of a flexible surface of least bending, over a typical force.
    """

    _: KW_ONLY
    condition: str
    heights: Floats | None = None
    tensions: Floats | None = None
    imbalance: float | None = None

    def _shaped(self, vertices: Floats, message: str) -> SheetEmbedding:
        """Return a surface with other vertices, not a solution, with the curvature fits of this one."""
        found = SheetEmbedding(
            self.metric, vertices, method="", tolerance=1.0, message=message, condition=self.condition
        )
        found.surface.__dict__["_energy"] = self._sheet._energy
        return found

    def _in_unit_of(self, target: Any) -> SheetEmbedding:
        """Return the same surface, computed for the `normalized` of a metric, in that metric's unit."""
        found = super()._in_unit_of(target)
        if self.tensions is not None:
            found._set(tensions=frozen(self.tensions / target.unit))
        if self.heights is not None:
            found._set(heights=frozen(self.heights * target.unit))
        return found

    def _sentence(self) -> str:
        return f"{self._on_residual}{self._trust()}{self._sides()}"

    @property
    def _takes_length_errors(self) -> bool:
        """Whether error bars are available for such surfaces, as for caps."""
        return self.condition == "plane"

    def _sides(self) -> str:
        """Clause on vertices inside a given curve whose side is doubtful or not unique."""
        t = self.triangulation
        if self.condition != "curve" or not self.converged:
            return ""
        rough = int(self.surface.rough_edges.sum())
        if rough and self.residual > MEASURED:
            return (
                f"; {rough} edge{'s are' if rough > 1 else ' is'} rough: a vertex may be on the wrong side "
                "of its neighbors"
            )
        x, unit = self.vertices / self.metric.unit, self.metric.normalized.mean_length
        free, heights = ~t.boundary_vertices, np.abs(_heights(x, t.boundary_vertices)) / unit
        is_flat = heights.max() ** 2 <= 2 * self.tolerance  # effect of a height on a length
        if heights[~free].max() <= COPLANAR and not is_flat and (t.degrees[free] > 3).any():
            return "; the boundary is planar: the mirror image in its plane has the same lengths"
        chosen = np.flatnonzero(free & (t.degrees == 3))
        if not len(chosen):
            return ""
        from isoembed.aim.vertex_reflections import reflections  # avoids imports needed for searches only

        apart = np.linalg.norm(reflections(t, x)[chosen], axis=1) / unit
        nearest = int(np.argmin(apart))
        return (
            f"; vertex {chosen[nearest]}, which has three neighbors, has a mirror image in their plane "
            f"with the same lengths, {apart[nearest]:.1g} mean edge lengths away: the smoother side was "
            "taken"
        )

    def _trust(self) -> str:
        """Clauses on the reliability of a surface of least bending."""
        if self.imbalance is None or self.second_form_energy <= FLAT:
            return ""
        clauses = []
        if self.imbalance > BALANCED:
            clauses.append(
                "the bending energy is not at a minimum, and the shape may be wrong: the forces are "
                f"balanced only to {self.imbalance:.0e}"
            )
        # Smooth surfaces have at least twice the curvature, and good meshes of them nearly so.
        if self.second_form_energy < 0.95 * 2 * self.total_absolute_curvature:
            clauses.append(
                "the mesh is too coarse to determine the bending energy: int k1^2 + k2^2 dA is "
                f"computed as {self.second_form_energy:.3g}, and no smooth surface has less than 2 int "
                f"|K| dA, which is estimated as {2 * self.total_absolute_curvature:.3g}"
            )
        inside, rough = ~self.triangulation.boundary_edges, self.surface.rough_edges
        if rough.sum() > ROUGH * inside.sum():
            clauses.append(
                f"{rough.sum()} of {inside.sum()} edges inside are rough: the sheet is creased, and its "
                "energy depends on the mesh; compare it with that of a finer one"
            )
        if self.uniqueness is not None:
            clauses.append(self.uniqueness.basis)
        for other in self.others:
            assert isinstance(other, SheetEmbedding)
            assert other.imbalance is not None
            stalled = f", but its search stalled (imbalance {other.imbalance:.0e})"
            clauses.append(
                f"another surface was found, whose vertices are up to {self.distance(other):.1g} mean edge "
                f"lengths away and whose int k1^2 + k2^2 dA is {other.second_form_energy:.6g} instead of "
                f"{self.second_form_energy:.6g}{stalled if other.imbalance > BALANCED else ''}"
            )
        return "".join(f"; {each}" for each in clauses)

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        return super()._made_surface(SheetSurface, metric=self.metric.normalized, **more)

    @property
    def _sheet(self) -> SheetSurface:
        assert isinstance(self.surface, SheetSurface)
        return self.surface

    @property
    def second_form_energy(self) -> float:
        """Integral of k1^2 + k2^2 dA."""
        return self._sheet.second_form_energy

    @cached_property
    def total_absolute_curvature(self) -> float:
        """Estimate of the integral of abs(K) dA.

        The `second_form_energy` of a smooth surface is at least twice this integral.  The estimate uses
        the deficits at inner vertices; at the boundary, K is that of inner neighbors.  It converges to the
        integral under refinement, like the energy to its own limit: for a given mesh, the energy may be less
        than twice the estimate.
        """
        t, areas = self.triangulation, self._sheet._energy.areas
        inside = (~t.boundary_vertices).astype(np.float64)
        curvature = inside * np.abs(deficits(self.metric.normalized)) / areas
        beside = t.adjacency @ curvature / np.maximum(t.adjacency @ inside, 1.0)
        return float(areas @ np.where(t.boundary_vertices, beside, curvature))

    @cached_property
    def _certificate(self) -> Certificate:
        """Certificate as returned by `isoembed.certify`."""
        from isoembed.proof.boundary_heights import certify
        from isoembed.proof.certificate import overdetermined

        more = int(self.triangulation.boundary_vertices.sum()) - 3
        if self.condition == "curve" and more > 0:
            return overdetermined(more, self.residual)
        if self.heights is None or not self.converged:
            found = super()._certificate
            if not found.certified or self.tensions is None:
                return found
            return replace(
                found, reason=f"{found.reason}; that it is the surface of least bending is not proven"
            )
        return certify(self.metric, self.vertices, self.heights)

    def _length_derivatives(self) -> SheetDerivatives:
        """Derivatives with respect to the lengths and boundary data."""
        from isoembed.sheets.derivatives import SheetDerivatives

        return SheetDerivatives.of(self)

    @cached_property
    def _curvature_rates(self) -> FittedCurvatureRates:
        """Derivatives of the fitted mean curvature."""
        from isoembed.sheets.fitted_curvature import FittedCurvatureRates

        return FittedCurvatureRates(self.triangulation, self._sheet._normalized, self._sheet._energy)

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Entries of the report on the boundary condition and bending, under ``sheet``."""
        t = self.triangulation
        found = {
            "condition": self.condition,
            "boundaries": [len(loop) for loop in t.boundaries],
            "genus": t.genus,
            "second_form_energy": self.second_form_energy,
            "total_absolute_curvature": self.total_absolute_curvature,
            "imbalance": self.imbalance,
        }
        has_volume = self._sheet._above_boundary is not None
        return {"sheet": found, "volume": self.volume} if has_volume else {"sheet": found}


def _heights(x: Floats, boundary: Mask) -> Floats:
    """Heights over the least-squares plane of the boundary, (V,)."""
    center = x[boundary].mean(axis=0)
    return (x - center) @ np.linalg.svd(x[boundary] - center, full_matrices=False)[2][2]
