"""The one verb: embed a metric by a method."""

from __future__ import annotations

import math
import numbers
from typing import Protocol

from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.stages import Listener, Log
from isoembed.surface.embedding import Embedding


class Method(Protocol):
    """A configured method, such as `isoembed.Aim` or `isoembed.Paper`."""

    @property
    def name(self) -> str:
        """What ``method=`` calls it."""
        ...

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> Embedding:
        """Embed the metric as well as it can."""
        ...


def embed(
    metric: PolyhedralMetric,
    *,
    method: str | Method = "aim",
    tolerance: float = 1e-10,
    progress: Listener | None = None,
) -> Embedding:
    """Find the surface in R^3 that realizes a polyhedral metric.

    Parameters
    ----------
    metric : PolyhedralMetric
    method : {"aim", "paper"} or a configured method
        ``"aim"``, the default, is `isoembed.Aim`; ``"paper"`` is `isoembed.Paper`, AIM as printed.  Both keep
        the given triangles.  Pass an `Aim` or a `Paper` to set parameters.
    tolerance : float
        Largest ``| |x_a - x_b| - l_ab |`` over the mean edge length.
    progress : callable, optional
        Receives an `isoembed.stages.Progress` as the computation goes.

    Returns
    -------
    Embedding
        Its residual, measured on the vertices that it holds, is within the tolerance.

    Raises
    ------
    NotEmbedded
        No such surface was found; the exception holds the best attempt.
    InvalidParameter
        The method is unknown, the tolerance not positive, or a parameter does not fit the metric.

    Examples
    --------
    >>> tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    >>> round(embed(tetrahedron).volume, 12)  # sqrt(2) / 12
    0.117851130198
    """
    if not isinstance(metric, PolyhedralMetric):
        raise InvalidParameter(
            f"the metric is a {type(metric).__name__}: make it PolyhedralMetric(faces, lengths, edges)"
        )
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance < math.inf:
        raise InvalidParameter(f"the tolerance is {tolerance!r}, not a positive finite number")
    embedding = configured(method).run(metric, tolerance, Log(progress))
    if not embedding.converged:
        raise NotEmbedded(embedding.message, embedding)
    return embedding


def configured(method: str | Method) -> Method:
    """The method of this name with its default parameters, or the given method itself.

    Raises
    ------
    InvalidParameter
        There is no such method.
    """
    from isoembed.aim.adaptive import Aim
    from isoembed.aim.paper import Paper

    if isinstance(method, type):
        raise InvalidParameter(f"the method is the class {method.__name__}: make one, {method.__name__}()")
    if not isinstance(method, str):
        return method
    known = {"aim": Aim, "paper": Paper}
    if method not in known:
        raise InvalidParameter(f"there is no method {method!r}; there are {', '.join(known)}")
    return known[method]()
