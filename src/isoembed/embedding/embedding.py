"""Embeddings: metric, surface in space, residuals, and record of the computation.

Costly computations and slow imports are deferred until they are needed.
"""

from __future__ import annotations

import copy
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.embedding.mirrored import mirrored_dents
from isoembed.embedding.moved import moved
from isoembed.errors import InvalidParameter
from isoembed.evidence import Evidence
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.metric.curvature import dual_areas, gaussian_curvature
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Stage
from isoembed.space import Space
from isoembed.space.models import from_model
from isoembed.surface import alignment, measures
from isoembed.surface.checked import checked_errors
from isoembed.surface.surface import Surface, vertex_array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from isoembed.plot.coloring import Quantity
    from isoembed.proof.certificate import Certificate


def checked_embedding(embedding: Any) -> Embedding:
    """Return the argument if it is an embedding; raises InvalidParameter otherwise."""
    if not isinstance(embedding, Embedding):
        raise InvalidParameter(
            f"the embedding is a {type(embedding).__name__}: give a result of isoembed.embed, or "
            "isoembed.read of a surface"
        )
    return embedding


class _Message:
    """Descriptor of `Embedding.message`: by default a sentence on the surface, generated on access."""

    def __get__(self, embedding: Embedding | None, kind: type) -> str:
        if embedding is None:
            return ""
        known = embedding.__dict__
        if not known["message"]:
            known["message"] = embedding._sentence()
        return str(known["message"])

    def __set__(self, embedding: Embedding, message: str) -> None:
        embedding.__dict__["message"] = message


@dataclass(frozen=True, eq=False, repr=False)
class Embedding:
    """Realization of a polyhedral metric, exact or attempted: in R^3, or in the space of its curvature.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric to be realized.
    vertices : array_like of float, shape (V, 3)
        Coordinates in the unit of the metric's lengths.  A closed surface with negative volume is mirrored.
        In hyperbolic and spherical space, the first three coordinates on the hyperboloid or sphere.
    method : str
        Name of the method that computed the vertices.
    tolerance : float
        Largest residual that counts as converged.
    stages : sequence of Stage
        Stages of the computation.
    message : str
        Message of the method; by default a sentence on the residual.
    others : sequence of Embedding
        Other realizations of the same lengths that were found.
    uniqueness : Evidence, optional
        Evidence that there are no other realizations than this one and `others`; None if none were sought.
    length_errors : ndarray, shape (E,), optional
        Standard deviations of the lengths, if known (`with_length_errors`).
    is_requested : bool, optional
        Whether it is of the kind requested; False if, for example, a convex surface was.

    Attributes
    ----------
    metric, vertices, method, tolerance, stages, others, uniqueness, length_errors, is_requested
        As given; `vertices` is read-only.

    Raises
    ------
    ValueError
        The vertices have another shape, are not finite, or on the sphere not in the open hemisphere about
        the origin.
    """

    metric: PolyhedralMetric
    vertices: Floats
    _: KW_ONLY
    method: str
    tolerance: float
    stages: Sequence[Stage] = ()
    message: _Message = _Message()
    others: Sequence[Embedding] = ()
    uniqueness: Evidence | None = None
    length_errors: Floats | None = None
    is_requested: bool = True

    def __post_init__(self) -> None:
        points, metric = vertex_array(self.metric.triangulation, self.vertices), self.metric
        # The sign is taken in the metric's own unit: the volume of tiny surfaces underflows.
        points = from_model(metric.space, points, "ambient") / metric.unit
        points = metric.unit * self._oriented(points)
        self._set(vertices=frozen(points), stages=tuple(self.stages), others=tuple(self.others))

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _oriented(self, points: Floats) -> Floats:
        """Normalized vertices, mirrored if the surface is closed and its volume negative."""
        if not self.triangulation.is_closed:
            return points
        return measures.outward(self.metric.faces, points, self.metric.normalized.space)

    def distance(self, other: Embedding | ArrayLike) -> float:
        """Largest distance of corresponding vertices, up to a rigid motion, in mean edge lengths.

        Parameters
        ----------
        other : Embedding, or array_like, shape (V, 3)
            Another realization, or vertices in the same order and unit.  Like the surface itself, closed
            ones are mirrored if their volume is negative.

        Raises
        ------
        ValueError
            The number of vertices is not V, or one is not finite.
        """
        normalized, unit = self.metric.normalized, self.metric.unit
        positions = other.vertices if isinstance(other, Embedding) else other
        x = self._oriented(vertex_array(self.triangulation, positions) / unit)
        return alignment.distance(self.vertices / unit, x, normalized.space) / normalized.mean_length

    def _with_message(self, message: str) -> Self:
        """Return the same embedding with another message."""
        return self._with(message=message)

    def _with_stages(self, stages: Sequence[Stage]) -> Self:
        """Return the same embedding with other stages."""
        return self._with(stages=tuple(stages))

    def _with_others(self, others: Sequence[Embedding], uniqueness: Evidence | None = None) -> Self:
        """Return the same embedding with other realizations, which the default message then mentions."""
        return self._with(others=tuple(others), uniqueness=uniqueness, message="")

    def with_length_errors(self, errors: ArrayLike) -> Self:
        """Return the same surface with length errors, from which the report computes error bars.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Standard deviations of the lengths, in their unit, as in `Sensitivity.deviation`.

        Raises
        ------
        InvalidParameter, InvalidMetric
            See `Sensitivity.integral_deviation`.
        """
        from isoembed.embedding.sensitivity import OF_A_NUMBER

        self.triangulation.check_sphere("error bars need", OF_A_NUMBER)
        return self._with(length_errors=frozen(checked_errors(self.metric, errors)))

    def _shaped(self, vertices: Floats, message: str) -> Embedding:
        """Return a surface with other vertices on the same triangles, for pictures; not a solution."""
        return Embedding(self.metric, vertices, method="", tolerance=1.0, message=message)

    def _in_unit_of(self, target: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same surface, computed for the `normalized` of a metric, in the unit of that metric.

        Cached measures are kept.  If the conversion rounds the vertices of tiny surfaces, everything is
        recomputed.
        """
        own = isinstance(target, PolyhedralMetric) and self.metric is target.normalized
        vertices = vertex_array(self.triangulation, target.unit * self.vertices)
        changes: dict[str, Any] = {
            "metric": target if own else self.metric.scaled(target.unit).in_space(target.space),
            "vertices": frozen(vertices),
            "others": tuple(other._in_unit_of(target) for other in self.others),
        }
        if self.length_errors is not None:
            changes["length_errors"] = frozen(target.unit * self.length_errors)
        if (vertices / target.unit != self.vertices).any():
            return replace(self, **changes, message="")
        changed = self._with(**changes)
        changed.__dict__.pop("gaussian_curvature", None)
        if "surface" in self.__dict__:
            changed.__dict__["surface"] = changed._made_surface()._measured_as(self.surface)
        return changed

    def _with(self, **changes: Any) -> Self:
        changed = copy.copy(self)
        changed._set(**changes)
        return changed

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.triangulation.n_vertices} vertices, method {self.method!r}, "
            f"{self.status}, residual {self.residual:.1e})"
        )

    @property
    def triangulation(self) -> Triangulation:
        """Triangulation of the metric."""
        return self.metric.triangulation

    @property
    def space(self) -> Space:
        """Ambient space, with the curvature of the metric's triangles."""
        return self.metric.space

    @property
    def faces(self) -> Indices:
        """Triangles, shape (F, 3)."""
        return self.metric.faces

    @property
    def edges(self) -> Indices:
        """Ends of the edges, shape (E, 2)."""
        return self.metric.edges

    @property
    def polygons(self) -> Indices | Sequence[Indices]:
        """Vertices around each face, counterclockwise as seen from outside.

        The faces are the triangles, except for a `ConvexPolyhedron`.
        """
        return self.surface.flat_faces.polygons

    @cached_property
    def surface(self) -> Surface:
        """Surface with its extrinsic measures."""
        return self._made_surface()

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        """Create a `Surface` of the given kind, with additional parameters for subclasses."""
        metric, precision = self.metric, self.metric.precision
        error = 0.0 if precision is None else precision.vertex_error * metric.normalized.mean_length
        return kind(
            metric.triangulation,
            self.vertices,
            metric.space,
            unit=metric.unit,
            vertex_error=error * metric.unit,
            **more,
        )

    @property
    def lengths(self) -> Floats:
        """Lengths of the edges on this surface, shape (E,); the given ones are those of `metric`."""
        return self.surface.lengths

    @cached_property
    def residuals(self) -> Floats:
        """Residuals ``| |x_a - x_b| - l_ab |`` of distances in space, in mean edge lengths, shape (E,)."""
        normalized = self.metric.normalized
        return frozen(np.abs(self.surface._lengths - normalized.lengths) / normalized.mean_length)

    @property
    def residual(self) -> float:
        """Maximum of `residuals`."""
        return float(self.residuals.max())

    @property
    def converged(self) -> bool:
        """Whether the largest residual, computed from these vertices, is within the tolerance."""
        return self.residual <= self.tolerance

    @property
    def is_answer(self) -> bool:
        """Whether `embed` returns it rather than raising NotEmbedded.

        It has converged and is of the kind requested, or is a best fit.
        """
        return self.converged and self.is_requested

    @property
    def status(self) -> str:
        """``"converged"``, ``"not converged"``, or ``"not found"`` if it is not of the kind requested."""
        if not self.is_requested:
            return "not found"
        return "converged" if self.converged else "not converged"

    @property
    def dihedral_angles(self) -> Floats:
        """Exterior dihedral angles in radians, shape (E,): 0 where flat, positive where convex.

        On a boundary they are 0.
        """
        return self.surface.dihedral_angles

    @property
    def normals(self) -> Floats:
        """Unit normals of the triangles, shape (F, 3), outward if the surface is closed.

        Raises
        ------
        InvalidParameter
            The surface is in hyperbolic or spherical space, where directions at different points differ.
        """
        return self.surface.normals

    @cached_property
    def gaussian_curvature(self) -> Floats:
        """Gaussian curvature at the vertices, shape (V,): a property of the metric.

        Deficit over circumcentric dual area, plus the curvature of the triangles in hyperbolic and spherical
        space; NaN where the dual area is not positive, and on a boundary.
        """
        valid = dual_areas(self.metric.normalized) > 0
        values = np.full(len(valid), np.nan)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            curvature = gaussian_curvature(self.metric)
            valid &= np.abs(curvature) < 1e300  # sums of larger values overflow
        values[valid] = curvature[valid]
        return frozen(values)

    @property
    def mean_curvature(self) -> Floats:
        """Mean curvature H = (k1 + k2) / 2 at the vertices, shape (V,)."""
        return self.surface.mean_curvature

    @property
    def area(self) -> float:
        """Area, in the unit of the lengths squared."""
        return self.surface.area

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the lengths cubed; raises InvalidMetric if there is a boundary."""
        return self.surface.volume

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA = 1/2 sum l theta, in the unit of the lengths.

        For surfaces with boundary, that of the fitted `mean_curvature`.
        """
        return self.surface.integrated_mean_curvature

    def save(self, path: str | os.PathLike[str], *, color: str | Quantity | ArrayLike | None = None) -> None:
        """Write the surface as a mesh, a picture or an HTML page, depending on the file name extension.

        Parameters
        ----------
        path : path
            ``.ply``, ``.obj``, ``.stl``, ``.off``, ``.npz``, ``.json``, ``.fold``, ``.vtk``, ``.vtu``,
            or ``.vtp`` for the surface, as written by `isoembed.io.write_surface`;
            ``.png``, ``.svg`` or ``.pdf`` for a picture; ``.html`` for a page.
        color : str, Quantity, or array_like, shape (V,), optional
            Quantity shown by the colors of a picture, as in `plot`.

        Raises
        ------
        FileError
            The extension is unknown, the file cannot be written, or matplotlib is not installed (for a
            picture): ``pip install matplotlib``.
        InvalidParameter
            The quantity is unknown, or the file format has no colors.
        """
        from isoembed.plot.saving import save_surface

        save_surface(self, path, color=color)

    def plot(
        self,
        *,
        color: str | Quantity | ArrayLike = "mean curvature",
        caption: str = "",
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the surface; a notebook shows the picture with or without pyplot.

        Parameters
        ----------
        color : str, Quantity, or array_like, shape (V,)
            Quantity shown by the colors: ``"mean curvature"``, ``"Gaussian curvature"``, ``"residual"``,
            ``"concave edges"``, ``"conformal factor"``, ``"sides"``, a user-defined quantity, or a number at
            each vertex.
        caption : str
            By default the number of vertices, int H dA and the residual.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, with a color bar beside them and the caption, if given, as the title.

        Returns
        -------
        matplotlib.figure.Figure
            Figure of `ax`, or a new one.  To save: ``surface.save("surface.pdf")``, or its ``savefig``.

        Raises
        ------
        FileError
            matplotlib is not installed: ``pip install matplotlib``.
        InvalidParameter
            The quantity is unknown.
        """
        from isoembed.plot.picture import figure

        return figure(self, color=color, caption=caption, ax=ax)

    def _repr_html_(self) -> str | None:
        """Representation in notebooks: see `isoembed.plot.notebook`."""
        from isoembed.plot.notebook import notebook_html

        return notebook_html(self)

    @cached_property
    def _certificate(self) -> Certificate:
        """Certificate as returned by `isoembed.certify`."""
        from isoembed.proof.certificate import Certificate, certify

        if not self.converged:
            return Certificate(False, "not certified, because the lengths miss the tolerance")
        return certify(self.metric, self.vertices)

    def _length_derivatives(self) -> Any:
        """Derivatives with respect to the lengths (`jvp`, `vjp`); raises InvalidMetric if not a sphere."""
        from isoembed.surface.derivatives import LengthDerivatives

        t, normalized = self.triangulation, self.metric.normalized
        t.check_sphere()  # otherwise J is not square, even without rigid motions
        return LengthDerivatives.of(t, self.vertices / self.metric.unit, normalized.lengths, normalized.space)

    @property
    def _curvature_rates(self) -> Any:
        """Derivatives of a fitted mean curvature; None if it is that of the dihedral angles."""
        return None

    @cached_property
    def _smallest_singular_value(self) -> float:
        """See `Sensitivity.smallest_singular_value`; raises InvalidMetric."""
        from isoembed.surface.rigidity import LengthSystem

        t, normalized = self.triangulation, self.metric.normalized
        # For other surfaces J is not square, even without rigid motions.
        t.check_sphere("the smallest singular value is that of")
        system = LengthSystem(t, space=normalized.space)
        try:
            x = self.vertices / self.metric.unit
            return float(system.smallest_singular_values(x, normalized.lengths, 1)[0][0])
        except SingularMatrix:
            return 0.0

    @property
    def _smoothed_parts(self) -> Floats:
        """Normalized lengths minus those of the surface, (E,), if it is a fit; else zeros."""
        return np.zeros(len(self.edges))

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Entries that a subclass adds to the report or replaces."""
        return {}

    def _given_derivatives(self) -> Any:
        """Derivatives with respect to given lengths (`jvp`, `vjp`); None if they are the triangles' own."""
        return None

    @property
    def _on_residual(self) -> str:
        """Clause on the largest residual."""
        e = int(np.argmax(self.residuals))
        return (
            f"the lengths {'are within' if self.converged else 'miss'} the tolerance {self.tolerance:.0e}: "
            f"the largest residual is {self.residual:.1e} of the mean edge length, "
            f"at edge {e} {self.metric.edges[e].tolist()}"
        )

    def _sentence(self) -> str:
        """Sentence on the residual, possible crumpling, and other realizations."""
        sentence, surface = self._on_residual, self.surface
        inverted = int(surface.inverted_vertices.sum())
        partially = int(surface.partially_inverted_vertices.sum())
        if (inverted or partially) and surface.rough_edges.any():
            sentence += (
                f"; {inverted} inverted and {partially} partially inverted vertices: the surface may be "
                "crumpled"
            )
        if len(self.others) < 3:
            return sentence + "".join(self._beside(other) for other in self.others)
        distances = [self.distance(other) for other in self.others]
        kinds = ", ".join(f"{n} {kind}" for kind, n in Counter(map(self._kind, self.others)).items())
        return (
            f"{sentence}; these lengths have {len(distances)} other realizations too, {min(distances):.1g} "
            f"to {max(distances):.1g} mean edge lengths from this one: {kinds}"
        )

    @property
    def _takes_length_errors(self) -> bool:
        """Whether error bars are available for such surfaces."""
        return self.triangulation.is_sphere and self.space.is_euclidean

    def _noting_rounded_lengths(self) -> Self:
        """Return the same surface, with a hint at error bars if it is smooth and its lengths look rounded."""
        rounding = self.metric.rounding
        if rounding is None or not (self.converged and self._takes_length_errors):
            return self
        if self.surface.rough_edges.any():
            return self
        error = rounding * self.metric.mean_length
        return self._with_message(
            f"{self.message}; the lengths look rounded: length_errors={error:.2g} gives error bars"
        )

    def _kind(self, other: Embedding) -> str:
        """Shape of another realization compared with this one."""
        first, second = self.surface, other.surface
        if second.concave_edges.any() and not first.concave_edges.any():
            return "not convex"
        return "smoother" if second.fine_roughness < first.fine_roughness else "rougher"

    def _beside(self, other: Embedding) -> str:
        """Clause on the distance and the shape of another realization."""
        sentence = (
            f"; these lengths have another realization too, {self.distance(other):.1g} mean edge lengths "
            f"from this one and {self._kind(other)}"
        )
        mirrored = mirrored_dents(self.metric, self.mean_curvature, other.mean_curvature)
        if mirrored:
            these = "one dent of one is a bump" if mirrored == 1 else f"{mirrored} dents of one are bumps"
            sentence += f", a mirror choice: {these} of the other"
        return sentence

    if not TYPE_CHECKING:  # checkers refuse the old names

        def __getattr__(self, name):
            """Deprecated names, with a `DeprecationWarning` that gives the replacement."""
            return moved(self, name)
