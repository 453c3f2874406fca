"""Embeddings: the metric, the surface in space, the residuals, and how it was found.

What is costly to compute, or slow to import, is computed and imported when it is asked for.
"""

from __future__ import annotations

import copy
import os
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


def checked_embedding(given: Any) -> Embedding:
    """Return the argument if it is an embedding; raises InvalidParameter otherwise."""
    if not isinstance(given, Embedding):
        raise InvalidParameter(
            f"the embedding is a {type(given).__name__}: give what isoembed.embed returns, or "
            "isoembed.read of a surface"
        )
    return given


class _Message:
    """The field `Embedding.message`: by default a sentence on the surface, made when it is read."""

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
        What was to be realized.
    vertices : array_like of float, shape (V, 3)
        In the unit of the metric's lengths.  A closed surface with negative volume is mirrored.  In
        hyperbolic and spherical space, the first three coordinates on hyperboloid or sphere.
    method : str
        The name of the method that found them.
    tolerance : float
        Largest residual that counts as converged.
    stages : sequence of Stage
        How they were found.
    message : str
        What the method has to say; by default a sentence on the residual.
    others : sequence of Embedding
        Other realizations of the same lengths that were met: the metric has more than one.
    uniqueness : Evidence, optional
        Evidence that there are no realizations but this one and `others`; None if none were sought.
    length_errors : ndarray, shape (E,), optional
        Standard deviations of the lengths, if they are known (`with_length_errors`).

    Attributes
    ----------
    metric, vertices, method, tolerance, stages, others, uniqueness, length_errors
        As given; `vertices` is read-only.

    Raises
    ------
    ValueError
        The vertices have another shape, are not finite, or on the sphere not in the open half about the
        origin.
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
        """Normalized vertices or their mirror image: that with positive volume, if the surface is closed."""
        if not self.triangulation.is_closed:
            return points
        return measures.outward(self.metric.faces, points, self.metric.normalized.space)

    def distance(self, other: Embedding | ArrayLike) -> float:
        """Largest distance of a vertex from another surface's, rigid motions aside, in mean edge lengths.

        Parameters
        ----------
        other : Embedding, or array_like, shape (V, 3)
            Another realization, or vertices in the same order and unit.

        Raises
        ------
        ValueError
            There are other than V vertices, or one is not finite.
        """
        normalized, unit = self.metric.normalized, self.metric.unit
        given = other.vertices if isinstance(other, Embedding) else other
        x = vertex_array(self.triangulation, given)
        return alignment.distance(self.vertices / unit, x / unit, normalized.space) / normalized.mean_length

    def _with_message(self, message: str) -> Self:
        """Return the same embedding with another message."""
        return self._with(message=message)

    def _with_stages(self, stages: Sequence[Stage]) -> Self:
        """Return the same embedding with other stages."""
        return self._with(stages=tuple(stages))

    def _with_others(self, others: Sequence[Embedding], uniqueness: Evidence | None = None) -> Self:
        """Return the same embedding with other realizations beside it, which the message then names."""
        return self._with(others=tuple(others), uniqueness=uniqueness, message="")

    def with_length_errors(self, errors: ArrayLike) -> Self:
        """Return the same surface with errors of its lengths, of which the report makes error bars.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Standard deviations of the lengths, in their unit, as of `Sensitivity.deviation`.

        Raises
        ------
        InvalidParameter, InvalidMetric
            As `Sensitivity.integral_deviation`.
        """
        from isoembed.embedding.sensitivity import OF_A_NUMBER

        self.triangulation.check_sphere("error bars need", OF_A_NUMBER)
        return self._with(length_errors=frozen(checked_errors(self.metric, errors)))

    def _shaped(self, vertices: Floats, message: str) -> Embedding:
        """Return a surface that was not solved for, on the same triangles, for pictures."""
        return Embedding(self.metric, vertices, method="", tolerance=1.0, message=message)

    def _in_unit_of(self, given: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same surface, found for the `normalized` of a metric, in the unit of that metric.

        What was measured is not measured again.  Where floats cannot hold so small a surface, the unit moves
        its vertices, and all is measured anew.
        """
        own = isinstance(given, PolyhedralMetric) and self.metric is given.normalized
        vertices = vertex_array(self.triangulation, given.unit * self.vertices)
        changes: dict[str, Any] = {
            "metric": given if own else self.metric.scaled(given.unit).in_space(given.space),
            "vertices": frozen(vertices),
            "others": tuple(other._in_unit_of(given) for other in self.others),
        }
        if self.length_errors is not None:
            changes["length_errors"] = frozen(given.unit * self.length_errors)
        if (vertices / given.unit != self.vertices).any():
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
        """The triangles that the lengths belong to."""
        return self.metric.triangulation

    @property
    def space(self) -> Space:
        """Space that contains the surface, of the curvature of the metric's triangles."""
        return self.metric.space

    @property
    def faces(self) -> Indices:
        """(F, 3): the triangles."""
        return self.metric.faces

    @property
    def edges(self) -> Indices:
        """(E, 2): the ends of the edges."""
        return self.metric.edges

    @property
    def polygons(self) -> Indices | Sequence[Indices]:
        """The faces: the vertices around each, counterclockwise seen from outside.

        They are the triangles, unless the surface is a `ConvexPolyhedron`.
        """
        return self.surface.flat_faces.polygons

    @cached_property
    def surface(self) -> Surface:
        """The surface with all that can be measured on it."""
        return self._made_surface()

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        """A new `Surface`, with more parameters of derived ones."""
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
        """Lengths of the edges on this surface, shape (E,): `metric` has those that were asked for."""
        return self.surface.lengths

    @cached_property
    def residuals(self) -> Floats:
        """``| |x_a - x_b| - l_ab |`` over the mean edge length, shape (E,): of distances in the space."""
        normalized = self.metric.normalized
        return frozen(np.abs(self.surface._lengths - normalized.lengths) / normalized.mean_length)

    @property
    def residual(self) -> float:
        """The largest of `residuals`."""
        return float(self.residuals.max())

    @property
    def converged(self) -> bool:
        """Whether the largest residual, measured on these vertices, is within the tolerance."""
        return self.residual <= self.tolerance

    @property
    def is_answer(self) -> bool:
        """Whether `embed` returns it, and does not raise NotEmbedded: it has converged, or is a best fit."""
        return self.converged

    @property
    def status(self) -> str:
        """``"converged"`` or ``"not converged"``."""
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

        The deficit over the circumcentric dual area, and in hyperbolic and spherical space the curvature of
        the triangles more; NaN where the dual area is not positive, and on a boundary.
        """
        known = dual_areas(self.metric.normalized) > 0
        values = np.full(len(known), np.nan)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            curvature = gaussian_curvature(self.metric)
            known &= np.abs(curvature) < 1e300  # beyond, sums overflow
        values[known] = curvature[known]
        return frozen(values)

    @property
    def mean_curvature(self) -> Floats:
        """Mean curvature H = (k1 + k2) / 2 at the vertices, shape (V,)."""
        return self.surface.mean_curvature

    @property
    def area(self) -> float:
        """Area, in the unit of the lengths, squared."""
        return self.surface.area

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the lengths, cubed; raises InvalidMetric if there is a boundary."""
        return self.surface.volume

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA = 1/2 sum l theta, in the unit of the lengths.

        Of surfaces from ``embed(metric, boundary=...)``, it is that of the fitted `mean_curvature`.
        """
        return self.surface.integrated_mean_curvature

    def save(self, path: str | os.PathLike[str], *, color: str | Quantity | ArrayLike | None = None) -> None:
        """Write the surface, by the ending of the file: as a mesh, a picture or a page for the browser.

        Parameters
        ----------
        path : path
            ``.ply``, ``.obj``, ``.stl``, ``.off``, ``.npz``, ``.json``, ``.fold``, ``.vtk``, ``.vtu``,
            or ``.vtp`` for the surface, as `isoembed.io.write_surface` writes it;
            ``.png``, ``.svg`` or ``.pdf`` for a picture; ``.html`` for a page.
        color : str, Quantity, or array_like, shape (V,), optional
            Of a picture: what the colors show, as of `plot`.

        Raises
        ------
        FileError
            The ending is not known, the file cannot be written, or for a picture matplotlib is not installed:
            ``pip install matplotlib``.
        InvalidParameter
            There is no such quantity, or the file has no colors.
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
        """Draw the surface; a notebook shows the picture, with pyplot and without.

        Parameters
        ----------
        color : str, Quantity, or array_like, shape (V,)
            What the colors show: ``"mean curvature"``, ``"Gaussian curvature"``, ``"residual"``,
            ``"concave edges"``, ``"conformal factor"``, ``"sides"``, a quantity of one's own, or a number at
            each vertex.
        caption : str
            By default the number of vertices, int H dA and the residual.
        ax : matplotlib.axes.Axes, optional
            Where to draw, with a color bar beside it and the caption, if there is one, as the title.

        Returns
        -------
        matplotlib.figure.Figure
            That of `ax`, or a new one.  To save: ``surface.save("surface.pdf")``, or its ``savefig``.

        Raises
        ------
        FileError
            matplotlib is not installed: ``pip install matplotlib``.
        InvalidParameter
            There is no such quantity to color it by.
        """
        from isoembed.plot.picture import figure

        return figure(self, color=color, caption=caption, ax=ax)

    def _repr_html_(self) -> str | None:
        """Representation in notebooks: see `isoembed.plot.notebook`."""
        from isoembed.plot.notebook import notebook_html

        return notebook_html(self)

    @cached_property
    def _certificate(self) -> Certificate:
        """Certificate as `isoembed.certify` returns it."""
        from isoembed.proof.certificate import Certificate, certify

        if not self.converged:
            return Certificate(False, "not certified, because the lengths miss the tolerance")
        return certify(self.metric, self.vertices)

    def _length_derivatives(self) -> Any:
        """Derivatives by the lengths (`jvp`, `vjp`); raises InvalidMetric unless the surface is a sphere."""
        from isoembed.surface.derivatives import LengthDerivatives

        t, normalized = self.triangulation, self.metric.normalized
        t.check_sphere()  # elsewhere J is not square, rigid motions apart
        return LengthDerivatives.of(t, self.vertices / self.metric.unit, normalized.lengths, normalized.space)

    @cached_property
    def _smallest_singular_value(self) -> float:
        """See `Sensitivity.smallest_singular_value`; raises InvalidMetric."""
        from isoembed.surface.rigidity import LengthSystem

        t, normalized = self.triangulation, self.metric.normalized
        # Of others J is not square, rigid motions apart.
        t.check_sphere("the smallest singular value is that of")
        system = LengthSystem(t, space=normalized.space)
        try:
            x = self.vertices / self.metric.unit
            return float(system.smallest_singular_values(x, normalized.lengths, 1)[0][0])
        except SingularMatrix:
            return 0.0

    @property
    def _missed(self) -> Floats:
        """The normalized lengths less those on a surface that is fitted to them, (E,); else zeros."""
        return np.zeros(len(self.edges))

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Entries that a subclass adds to the report or replaces."""
        return {}

    def _given_derivatives(self) -> Any:
        """Derivatives by the given lengths (`jvp`, `vjp`); None where these are those of the triangles."""
        return None

    def _sentence(self) -> str:
        """Whether the lengths are met, whether the surface may be crumpled, and which others there are."""
        e, surface = int(np.argmax(self.residuals)), self.surface
        said = (
            f"the lengths {'are within' if self.converged else 'miss'} the tolerance {self.tolerance:.0e}: "
            f"the largest residual is {self.residual:.1e} of the mean edge length, "
            f"at edge {e} {self.metric.edges[e].tolist()}"
        )
        inverted = int(surface.inverted_vertices.sum())
        partially = int(surface.partially_inverted_vertices.sum())
        if (inverted or partially) and surface.rough_edges.any():
            said += (
                f"; {inverted} inverted and {partially} partially inverted vertices: the surface may be "
                "crumpled"
            )
        return said + "".join(self._beside(other) for other in self.others)

    @property
    def _takes_length_errors(self) -> bool:
        """Whether there are error bars of such surfaces."""
        return self.triangulation.is_sphere and self.space.is_euclidean

    def _noting_rounded_lengths(self) -> Self:
        """The same smooth surface; if its lengths look rounded, the message says how to have error bars."""
        rounding = self.metric.rounding
        if rounding is None or not (self.converged and self._takes_length_errors):
            return self
        if self.surface.rough_edges.any():
            return self
        error = rounding * self.metric.mean_length
        return self._with_message(
            f"{self.message}; the lengths look rounded: length_errors={error:.2g} gives error bars"
        )

    def _beside(self, other: Embedding) -> str:
        """Clause on the distance and the shape of another realization."""
        first, second = self.surface, other.surface
        if second.concave_edges.any() and not first.concave_edges.any():
            kind = "not convex"
        else:
            kind = "smoother" if second.fine_roughness < first.fine_roughness else "rougher"
        said = (
            f"; these lengths have another realization too, {self.distance(other):.1g} mean edge lengths "
            f"from this one and {kind}"
        )
        mirrored = mirrored_dents(self.metric, self.mean_curvature, other.mean_curvature)
        if mirrored:
            these = "one dent of one is a bump" if mirrored == 1 else f"{mirrored} dents of one are bumps"
            said += f", a mirror choice: {these} of the other"
        return said

    if not TYPE_CHECKING:  # checkers refuse the old names

        def __getattr__(self, name):
            """Old names, with a `DeprecationWarning` that says where they went."""
            return moved(self, name)
