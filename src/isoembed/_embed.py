"""The one verb: embed a metric by a method."""

from __future__ import annotations

import math
import numbers
from dataclasses import replace
from importlib import import_module
from typing import Any, Protocol

from isoembed.errors import Interrupted, InvalidParameter, NotEmbedded
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.fingerprint import Fingerprint
from isoembed.progress.stages import Checkpoint, Listener, Log
from isoembed.surface.embedding import Embedding

METHODS = {
    "aim": "isoembed.aim.adaptive:Aim",
    "paper": "isoembed.aim.paper:Paper",
    "alexandrov": "isoembed.alexandrov.method:Alexandrov",
}
"""Where each method's configuration is; they are imported on first use."""


class Method(Protocol):
    """A configured method, such as `isoembed.Aim`, `isoembed.Paper` or `isoembed.Alexandrov`."""

    @property
    def name(self) -> str:
        """What ``method=`` calls it."""
        ...

    def run(self, metric: Any, tolerance: float, log: Log) -> Embedding:
        """Embed the metric as well as it can, and go on from what was kept, if it takes that up."""
        ...


def embed(
    metric: PolyhedralMetric | GluedMetric,
    *,
    method: str | Method = "aim",
    tolerance: float = 1e-10,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Find the surface in R^3 that realizes a polyhedral metric.

    Parameters
    ----------
    metric : PolyhedralMetric or GluedMetric
    method : {"aim", "paper", "alexandrov"} or a configured method
        ``"aim"``, the default, is `isoembed.Aim`; ``"paper"`` is `isoembed.Paper`, AIM as printed.  Both keep
        the given triangles.  ``"alexandrov"`` is `isoembed.Alexandrov`, the exact convex polyhedron of a
        convex metric, on triangles of its own; a `GluedMetric` needs it.  Pass an `Aim`, a `Paper` or an
        `Alexandrov` to set parameters.
    tolerance : float
        Largest ``| |x_a - x_b| - l_ab |`` over the mean edge length.
    progress : callable, optional
        Receives an `isoembed.progress.stages.Progress` as the computation goes.  If it raises an
        exception, that ends the computation; a `KeyboardInterrupt` does as Ctrl-C does.
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
        The method is unknown, the tolerance not positive, a parameter does not fit the metric, or what is to
        be resumed was something else.
    Interrupted
        On Ctrl-C; a `KeyboardInterrupt` that holds the checkpoint to go on from.

    Examples
    --------
    >>> tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    >>> round(embed(tetrahedron).volume, 12)  # sqrt(2) / 12
    0.117851130198
    """
    chosen = configured(method)
    if isinstance(metric, GluedMetric) and chosen.name != "alexandrov":
        raise InvalidParameter(
            f"the method {chosen.name!r} keeps the given triangles, and those of a glued metric need not be "
            'a simplicial complex: take the method "alexandrov", or glued.simplicial()'
        )
    if (
        isinstance(metric, PolyhedralMetric)
        and metric.triangulation.n_faces == 2
        and chosen.name != "alexandrov"
    ):
        raise InvalidParameter(
            f"the metric is a triangle covered twice, which the method {chosen.name!r} does not embed: "
            'take the method "alexandrov"'
        )
    if not isinstance(metric, PolyhedralMetric | GluedMetric):
        raise InvalidParameter(
            f"the metric is a {type(metric).__name__}: make it PolyhedralMetric(faces, lengths, edges)"
        )
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance < math.inf:
        raise InvalidParameter(f"the tolerance is {tolerance!r}, not a positive finite number")
    if resume is not None:
        if not isinstance(resume, Checkpoint):
            raise InvalidParameter(
                f"resume is a {type(resume).__name__}, not a Checkpoint: isoembed.io.read_checkpoint has one"
            )
        Fingerprint.of(metric.tables, chosen, tolerance).check(resume.fingerprint)
    log = Log(progress, resume)
    try:
        embedding = chosen.run(metric, tolerance, log)
    except KeyboardInterrupt as interruption:
        here = Fingerprint.of(metric.tables, chosen, tolerance)
        kept = log.checkpoint and replace(log.checkpoint, fingerprint=here)
        raise Interrupted(kept, log.stages) from interruption
    if embedding.status == "not converged":
        raise NotEmbedded(embedding.message, embedding)
    return embedding


def configured(method: str | Method) -> Method:
    """The method of this name with its default parameters, or the given method itself.

    Raises
    ------
    InvalidParameter
        There is no such method.
    """
    if isinstance(method, type):
        raise InvalidParameter(f"the method is the class {method.__name__}: make one, {method.__name__}()")
    if not isinstance(method, str):
        return method
    if method not in METHODS:
        raise InvalidParameter(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    return configuration(method)()


def configuration(name: str) -> type[Any]:
    """The frozen dataclass that configures the method of this name."""
    home, _, kind = METHODS[name].partition(":")
    return getattr(import_module(home), kind)
