"""Embedding a metric by a method: `embed`, and what a `Method` is.

A method says what it keeps and takes, so that nobody needs to know it by name.  Besides the three of this
package there are those of installed packages, under the entry points ``isoembed.methods``, and those that are
passed as they are.
"""

import math
import numbers
import os
from abc import ABC, abstractmethod
from importlib.metadata import EntryPoint, entry_points
from inspect import isabstract
from typing import Any, ClassVar, Self

from numpy.typing import ArrayLike

from isoembed.errors import Interrupted, InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.fingerprint import Fingerprint
from isoembed.progress.stages import Checkpoint, Listener, Log
from isoembed.surface.embedding import Embedding

METHODS = {
    "aim": "isoembed.aim.adaptive:Aim",
    "paper": "isoembed.aim.paper:Paper",
    "alexandrov": "isoembed.alexandrov.method:Alexandrov",
    "sheet": "isoembed.sheets.method:Sheet",
}
"""Where the methods of this package are; they are imported on first use."""

DEFAULT = "aim"
"""The method of surfaces without boundary."""

GROUP = "isoembed.methods"
"""The entry points under which other packages bring theirs."""


class Method(ABC):
    """A way to embed metrics, with its parameters: what `embed` takes as ``method=``.

    Derive a frozen dataclass from it.  Its fields, each with a default, are the parameters, which the command
    sets with ``--parameter NAME=VALUE``.  A package makes its method known by an entry point of the group
    ``isoembed.methods``.

    Attributes
    ----------
    name : str
        What ``method=`` and reports call it.
    keeps_triangles : bool
        Whether the surface has the given triangles; otherwise it has the metric on triangles of its own.
    takes_glued : bool
        Whether the metric may be a `GluedMetric`, whose triangles need not be a simplicial complex.
    takes_doubly_covered : bool
        Whether the metric may be two triangles, of which the surface is one covered twice.
    takes_curved : bool
        Whether the metric may be of triangles of hyperbolic or spherical space, in which the surface then is.
    takes_boundary : bool
        Whether the metric may be on a surface with boundary, or of higher genus.
    takes_length_errors : bool
        Whether errors of the lengths take part in the choice of the surface.
    shows_path : bool
        Whether there always are surfaces before the last, which `StageRecorder.show` has been given.
    """

    name: ClassVar[str]
    keeps_triangles: ClassVar[bool] = True
    takes_glued: ClassVar[bool] = False
    takes_doubly_covered: ClassVar[bool] = False
    takes_curved: ClassVar[bool] = False
    takes_boundary: ClassVar[bool] = False
    takes_length_errors: ClassVar[bool] = False
    shows_path: ClassVar[bool] = False

    def scaled(self, factor: float) -> Self:
        """The method with every parameter that has the unit of the lengths times a factor."""
        return self

    @abstractmethod
    def run(self, metric: Any, tolerance: float, log: Log) -> Embedding:
        """Embed a metric as well as it can; the answer may miss the tolerance, and says so.

        Parameters
        ----------
        metric : PolyhedralMetric, or GluedMetric if it takes one
            Normalized: its mean edge length is between 1 and 2.  The caller restores the unit.
        tolerance : float
            Largest residual to count as converged.
        log : Log
            Records the stages, and has what an interrupted run kept, to go on from.

        Returns
        -------
        Embedding

        Raises
        ------
        InvalidMetric
            The metric is none that the method takes.
        NotEmbedded
            No surface was found; the exception holds the best attempt.
        """


def embed(
    metric: PolyhedralMetric | GluedMetric | Any,
    *,
    method: str | Method = DEFAULT,
    tolerance: float = 1e-10,
    length_errors: ArrayLike | None = None,
    boundary: ArrayLike | str | None = None,
    start: ArrayLike | None = None,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Find the surface that realizes a polyhedral metric, in the space whose curvature its triangles have.

    Parameters
    ----------
    metric : PolyhedralMetric, GluedMetric, or a mesh
        Of curvature 0, unless it says otherwise: the surface then is in R^3.  Of a mesh, which is a tuple
        (vertices, faces), a ``trimesh.Trimesh``, a ``pyvista.PolyData`` or a surface of this package, the
        lengths are taken and the coordinates thrown away.
    method : {"aim", "paper", "alexandrov", "sheet"}, the name of an installed method, or a Method
        ``"aim"``, the default, is `isoembed.Aim`; ``"paper"`` is `isoembed.Paper`, AIM as printed.  Both keep
        the given triangles.  ``"alexandrov"`` is `isoembed.Alexandrov`, the exact convex polyhedron of a
        convex metric, on triangles of its own; a `GluedMetric` needs it.  ``"sheet"`` is `isoembed.Sheet`,
        for which `boundary` stands.  Pass an `Aim`, a `Paper`, an `Alexandrov`, a `Sheet` or a `Method` of
        your own to set parameters.
    tolerance : float
        Largest ``| |x_a - x_b| - l_ab |`` over the mean edge length; in curved space, of distances there.
    length_errors : float or array_like, shape (E,), optional
        Standard deviations of the lengths, whose errors are independent, in their unit: one for all, or one
        for each edge.  The surface then is a `MeasuredSurface`, a smooth one whose lengths agree with these
        within the errors, by a chi-square test, which is what converged then means.  Errors of zero take the
        lengths as exact, even if their digits show that they were rounded.
    boundary : {"free", "plane"} or array_like, shape (B,) or (B, 3), optional
        Of a surface with boundary or of higher genus, in the place of a method: ``"free"`` for one of least
        bending, ``"plane"`` for the convex cap, heights or positions of the boundary; see `isoembed.Sheet`.
        The surface then is a `SheetEmbedding`.
    start : array_like, shape (V, 3), optional
        A surface to start from, with `boundary`.
    progress : callable, optional
        Receives an `isoembed.progress.stages.Progress` as the computation goes, which holds the checkpoint
        by then.  If it raises an exception, that ends the computation; a `KeyboardInterrupt` does as Ctrl-C
        does.
    resume : Checkpoint, optional
        Where an interrupted run with the same metric, method and tolerance is to go on.

    Returns
    -------
    Embedding
        Its residual, measured on the vertices that it holds, is within the tolerance.  With
        ``Aim(best_fit=True)`` it may be a `FittedSurface` instead, whose status is ``"best fit"``.

    Raises
    ------
    InvalidMetric
        The method is ``"alexandrov"`` and the metric is not convex; the message names the vertex.
    NotEmbedded
        No such surface was found; the exception holds the best attempt.
    InvalidParameter
        The method is unknown or does not take errors of lengths, the tolerance is not positive, a parameter
        does not fit the metric, or what is to be resumed was something else.
    Interrupted
        On Ctrl-C; a `KeyboardInterrupt` that holds the checkpoint to go on from.

    Examples
    --------
    >>> tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    >>> round(embed(tetrahedron).volume, 12)  # sqrt(2) / 12
    0.117851130198
    """
    metric = _metric(metric)
    if boundary is not None and method != DEFAULT:
        raise InvalidParameter("a boundary takes the place of a method: give no method beside it")
    chosen = configured(method) if boundary is None else _sheet(boundary, start)
    if start is not None and boundary is None:
        raise InvalidParameter(
            "a start is for surfaces with boundary or of higher genus: give boundary='free'"
        )
    if isinstance(metric, GluedMetric) and not chosen.takes_glued:
        raise InvalidParameter(
            f"the method {chosen.name!r} keeps the given triangles, and those of a glued metric need not be "
            'a simplicial complex: take the method "alexandrov", or glued.simplicial()'
        )
    mesh = metric.triangulation if isinstance(metric, PolyhedralMetric) else None
    if mesh and mesh.n_faces == 2 and mesh.is_closed and not chosen.takes_doubly_covered:
        raise InvalidParameter(
            f"the metric is a triangle covered twice, which the method {chosen.name!r} does not embed: "
            'take the method "alexandrov"'
        )
    if mesh and not chosen.takes_boundary:
        try:
            mesh.check_sphere()
        except InvalidMetric as error:
            raise InvalidMetric(
                f"{error}; boundary='free' is for such surfaces, and 'plane' for convex caps"
            ) from None
    if metric.curvature and not chosen.takes_curved:
        raise InvalidParameter(
            f"the metric has the curvature {metric.curvature:.6g}, and the method {chosen.name!r} embeds in "
            'Euclidean space only: take the method "aim" or "alexandrov"'
        )
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance < math.inf:
        raise InvalidParameter(f"the tolerance is {tolerance!r}, not a positive finite number")
    if length_errors is not None:
        if isinstance(metric, GluedMetric):
            raise InvalidParameter(
                "errors of the lengths of a glued metric do not take part in its embedding"
            )
        metric = metric.with_length_errors(length_errors)
    if getattr(metric, "length_errors", None) is not None and not chosen.takes_length_errors:
        after = (
            "" if chosen.takes_boundary else ", and take embedding.with_length_errors(errors) for error bars"
        )
        raise InvalidParameter(
            f"the method {chosen.name!r} takes lengths as exact: embed without length_errors{after}"
        )
    unit = metric.normalized
    fingerprint = Fingerprint.of(unit.tables, chosen, tolerance)
    if resume is not None:
        if not isinstance(resume, Checkpoint):
            raise InvalidParameter(
                f"resume is a {type(resume).__name__}, not a Checkpoint: isoembed.io.read_checkpoint has one"
            )
        fingerprint.check(resume.fingerprint)
    log = Log(progress, resume, fingerprint)
    try:
        embedding = chosen.scaled(1 / metric.unit).run(unit, tolerance, log).in_unit_of(metric)
    except NotEmbedded as failure:
        attempt = failure.embedding.in_unit_of(metric)
        raise NotEmbedded(str(failure), attempt, failure.evidence) from None
    except KeyboardInterrupt as interruption:
        raise Interrupted(log.checkpoint, log.stages) from interruption
    if embedding.status == "not converged":
        raise NotEmbedded(embedding.message, embedding)
    return embedding


def _metric(given: Any) -> PolyhedralMetric | GluedMetric:
    """The metric itself, or that of a mesh.

    Raises
    ------
    InvalidParameter
        It is neither.
    """
    if isinstance(given, PolyhedralMetric | GluedMetric):
        return given
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        return PolyhedralMetric.from_trimesh(given)
    if hasattr(given, "points") and hasattr(given, "faces"):
        return PolyhedralMetric.from_pyvista(given)
    if isinstance(given, tuple) and len(given) == 2:
        return PolyhedralMetric.from_mesh(*given)
    instead = "isoembed.io.read_metric(path)" if isinstance(given, str | os.PathLike) else "a mesh"
    raise InvalidParameter(
        f"the metric is a {type(given).__name__}: make it PolyhedralMetric(faces, lengths, edges), or take "
        f"{instead}"
    )


def _sheet(boundary: ArrayLike | str, start: ArrayLike | None) -> Method:
    """The method for surfaces with boundary, or of higher genus."""
    kind: Any = configuration("sheet")
    method: Method = kind(boundary, start)
    return method


def configured(method: str | Method) -> Method:
    """The method of this name with its default parameters, or the given method itself.

    Raises
    ------
    InvalidParameter
        There is no such method.
    """
    if isinstance(method, str):
        kind = configuration(method)
        try:
            return kind()
        except TypeError as error:  # a parameter without a default
            raise InvalidParameter(f"the method {method!r} needs parameters: {error}") from None
    if isinstance(method, type):
        raise InvalidParameter(f"the method is the class {method.__name__}: make one, {method.__name__}()")
    if not isinstance(method, Method):
        raise InvalidParameter(f"the method is a {type(method).__name__}: derive it from isoembed.Method")
    return method


def configuration(name: str) -> type[Method]:
    """The class of the method of this name.

    Raises
    ------
    InvalidParameter
        There is none, or the package that brings it has an entry point that leads to none.
    """
    if name in METHODS:
        found = EntryPoint(name, METHODS[name], GROUP)
    else:
        brought = tuple(entry_points(group=GROUP, name=name))
        if not brought:
            raise InvalidParameter(f"there is no method {name!r}; there are {', '.join(method_names())}")
        found = brought[0]
    try:
        kind = found.load()
    except Exception as error:  # whatever a module of others raises
        raise InvalidParameter(
            f"the method {name!r} cannot be loaded from {found.value}: {type(error).__name__}: {error}"
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Method)):
        raise InvalidParameter(
            f"the method {name!r} is {found.value}, which is not derived from isoembed.Method"
        )
    if isabstract(kind) or not isinstance(getattr(kind, "name", None), str):
        raise InvalidParameter(f"the method {name!r} is {found.value}, which lacks a name or the method run")
    return kind


def method_names() -> tuple[str, ...]:
    """The names that ``method=`` may be: of this package's methods, then of those that others bring."""
    return tuple(dict.fromkeys([*METHODS, *sorted(entry_points(group=GROUP).names)]))
