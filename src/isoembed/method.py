"""Base class of embedding methods; `solve` checks metric and result, normalizes the unit, and runs one.

A method declares its capabilities, so that no code depends on its name.
"""

import math
import numbers
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import Interrupted, InvalidMetric, InvalidParameter, NotEmbedded, warn_of_mesh
from isoembed.evidence import Evidence
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.precision import rounded_unit
from isoembed.metric.vertex_links import NO_LINK, link_gaps, without_link
from isoembed.progress.checkpoints import Checkpoint, Checkpoints
from isoembed.progress.fingerprint import Fingerprint
from isoembed.progress.stages import Listener, Log
from isoembed.threads import reserve_threads

TOLERANCE = 1e-10
"""Largest residual that counts as converged, unless another is given."""
ONLY_EUCLIDEAN = "surfaces with boundary or handles are embedded in R^3 only, with flat triangles"


class Method(ABC):
    """Embedding method with its parameters, an argument ``method=`` of `embed`.

    Derive a frozen dataclass from it.  Its fields, each with a default, are the parameters, which the command
    sets with ``--parameter NAME=VALUE``.  A package makes its method known by an entry point of the group
    ``isoembed.methods``.

    Attributes
    ----------
    name : str
        Name in ``method=`` and in reports.
    keeps_triangles : bool
        Whether the surface has the given triangles; otherwise it has the metric on triangles of its own.
    takes_glued : bool
        Whether the metric may be a `GluedMetric`, whose triangles need not be a simplicial complex.
    takes_doubly_covered : bool
        Whether the metric may be two triangles, whose surface is a doubly covered triangle.
    takes_curved : bool
        Whether the metric may be of triangles of hyperbolic or spherical space, in which the surface then is.
    takes_boundary : bool
        Whether the metric may be on a surface with boundary, or of higher genus.
    takes_length_errors : bool
        Whether errors of the lengths take part in the choice of the surface or of its faces.  Otherwise those
        of the metric give error bars, or are unused if the surface has none.
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
        """Copy of the method with all length-valued parameters multiplied by a factor."""
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
            Records the stages; its `Checkpoints` contain the state of an interrupted run, to resume from.

        Returns
        -------
        Embedding

        Raises
        ------
        InvalidMetric
            The method does not take this metric.
        NotEmbedded
            No surface was found; the exception holds the best attempt.
        """


@reserve_threads()
def solve(
    metric: PolyhedralMetric | GluedMetric,
    method: Method,
    *,
    tolerance: float = TOLERANCE,
    length_errors: ArrayLike | None = None,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Check a metric and a method against each other, normalize the unit, and run the method."""
    if isinstance(metric, GluedMetric) and not method.takes_glued:
        raise InvalidParameter(
            f"the method {method.name!r} keeps the given triangles, and the triangles of a glued "
            'metric need not form a simplicial complex: use the method "alexandrov", or '
            "glued.simplicial()"
        )
    if isinstance(metric, GluedMetric):
        metric.check_sphere()
    mesh = metric.triangulation if isinstance(metric, PolyhedralMetric) else None
    if mesh and mesh.n_faces == 2 and mesh.is_closed and not method.takes_doubly_covered:
        raise InvalidParameter(
            f"the metric is a doubly covered triangle, which the method {method.name!r} does not embed: "
            'take the method "alexandrov"'
        )
    if mesh and not method.takes_boundary:
        try:
            mesh.check_sphere()
        except InvalidMetric as error:
            caps = "" if mesh.is_closed else ", boundary='plane' for convex caps"
            if metric.curvature:
                raise InvalidMetric(f"{error}; {ONLY_EUCLIDEAN}") from None
            raise InvalidMetric(f"{error}; boundary='free' is for such surfaces{caps}") from None
    if metric.curvature and not method.takes_curved:
        if mesh and not mesh.is_sphere:
            raise InvalidParameter(f"the metric has the curvature {metric.curvature:.6g}; {ONLY_EUCLIDEAN}")
        raise InvalidParameter(
            f"the metric has the curvature {metric.curvature:.6g}, and the method {method.name!r} embeds in "
            'Euclidean space only: take the method "aim" or "alexandrov"'
        )
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance < math.inf:
        raise InvalidParameter(f"the tolerance is {tolerance!r}, not a positive finite number")
    if length_errors is not None:
        if isinstance(metric, GluedMetric):
            raise InvalidParameter("length_errors are not supported for a GluedMetric")
        metric = metric.with_length_errors(length_errors)
        if metric.length_errors is not None and not method.takes_length_errors:
            if method.takes_boundary:
                raise InvalidParameter("for a surface with boundary, length_errors requires boundary='plane'")
            raise InvalidParameter(
                f"the method {method.name!r} takes lengths as exact: embed without length_errors, and take "
                "embedding.with_length_errors(errors) for error bars"
            )
    shown = None
    if isinstance(metric, PolyhedralMetric) and not method.takes_length_errors:
        metric, shown = _exact(metric, method)
    unit = metric.normalized
    fingerprint = Fingerprint.of(metric.tables, method, tolerance)
    if resume is not None:
        if not isinstance(resume, Checkpoint):
            raise InvalidParameter(
                f"resume is a {type(resume).__name__}, not a Checkpoint: isoembed.io.read_checkpoint has one"
            )
        fingerprint.check(resume.fingerprint)
    checkpoints = Checkpoints(resume, fingerprint)
    log = Log(progress, checkpoints)
    try:
        found = method.scaled(1 / metric.unit).run(unit, tolerance, log)
    except NotEmbedded as failure:
        attempt = failure.embedding._in_unit_of(metric)
        raise NotEmbedded(str(failure), attempt, failure.evidence) from None
    except KeyboardInterrupt as interruption:
        raise Interrupted(checkpoints.last, log.stages) from interruption
    if not isinstance(found, Embedding):
        kind = type(found).__name__
        raise InvalidParameter(f"the method {method.name!r} returned {kind}, not an Embedding")
    if method.keeps_triangles and not np.array_equal(found.metric.lengths, unit.lengths):
        raise InvalidParameter(f"the method {method.name!r} returned an Embedding of a different metric")
    if found.tolerance != tolerance:
        raise InvalidParameter(
            f"the method {method.name!r} returned an Embedding with the tolerance {found.tolerance:g}, "
            f"not the given {tolerance:g}"
        )
    embedding = found._in_unit_of(metric)
    if not embedding.is_answer:
        if isinstance(metric, PolyhedralMetric) and method.keeps_triangles and metric.length_errors is None:
            gaps = link_gaps(metric)
            v = int(np.argmax(gaps))
            if gaps[v] > 0:
                message = f"{without_link(metric, v)}. {embedding.message[:1].upper()}{embedding.message[1:]}"
                raise NotEmbedded(message, embedding, Evidence("proved", NO_LINK))
        raise NotEmbedded(embedding.message, embedding)
    if shown is not None:
        return embedding.with_length_errors(shown)
    return embedding._noting_rounded_lengths()


def _exact(metric: PolyhedralMetric, method: Method) -> tuple[PolyhedralMetric, Floats | None]:
    """Metric without its length errors, and those from which the embedding has error bars, if it can."""
    errors = metric.length_errors
    if errors is None:
        return metric, None
    if method.keeps_triangles and not method.takes_boundary:
        return metric.exact, errors
    of_digits = rounded_unit(metric.lengths, errors) is not None
    unused = "the errors of their digits" if of_digits else "their errors"
    warn_of_mesh(f"the method {method.name!r} takes lengths as exact: {unused} are unused")
    return metric.exact, None
