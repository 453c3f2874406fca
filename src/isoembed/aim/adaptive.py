"""The default method, `Aim`: uniformize to convexity, embed by Alexandrov's theorem, pull back.

The paper's three steps, each of them replaced by one that does not fail:

1. uniformize, but only as far as convexity: `isoembed.aim.convexification`, in place of
   `isoembed.aim.uniformize`;
2. embed where it is easy, which for a convex metric is everywhere: the exact polyhedron of Alexandrov's
   theorem, `isoembed.alexandrov`, in place of `isoembed.aim.embedding_tree`;
3. pull back: by Newton's method at once, on the radii or the lengths; else dents are made at once, and all
   else step by step, as smooth as can be; many vertices by levels.  `isoembed.aim.adiabatic_pullback` is the
   paper's.

`isoembed.aim.strategies` lists the strategies in the order in which they are tried, those for convex metrics
before the three steps and those for what the pull-back missed behind them; `isoembed.aim.pipeline` runs them.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from isoembed.aim.decisions import DECISIONS, choose
from isoembed.aim.pipeline import Pipeline
from isoembed.aim.strategies import STRATEGIES
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.method import Method
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log


@dataclass(frozen=True)
class Aim(Method):
    """The adaptive method.

    Parameters
    ----------
    best_fit : bool
        Whether to return the smooth surface that comes nearest to the lengths, a `FittedSurface`, where none
        is found that has them.
    effort : float
        Cost limit of a failure, relative to the cost of all that was done before.  Cost is counted in
        factorizations, so that results do not depend on the machine.  Where the pull-back misses the
        lengths, a search for patches on the wrong side and the best fit follow, which together cost
        ``1 + effort`` times as much, 11 times at most; with `best_fit` the fit takes what it needs.  0 is no
        search.  Above 1, vertices on the wrong side are sought after that, for ``effort`` times the cost.
    which : {"convex", "smoothest"} or array_like, shape (V, 3), optional
        Another of the realizations that are found: the convex one; the smoothest; or the nearest to a surface
        with these vertices, of any size, from which Newton's method is started, too.  By default the answer
        is on the branch of a convex surface, or, where that is not followed, the smoothest.
    """

    best_fit: bool = False
    effort: float = 1.0
    which: str | tuple[tuple[float, ...], ...] | None = None

    name: ClassVar[str] = "aim"
    takes_curved: ClassVar[bool] = True
    takes_length_errors: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not isinstance(self.best_fit, bool):
            raise InvalidParameter(f"best_fit is {self.best_fit!r}, not True or False")
        if not 0 <= self.effort < np.inf:
            raise InvalidParameter(f"effort is {self.effort!r}, not a finite number of at least 0")
        if self.which is not None and not isinstance(self.which, str):
            object.__setattr__(self, "which", _points(self.which))
        elif self.which not in (None, "convex", "smoothest"):
            raise InvalidParameter(f'which is {self.which!r}, not "convex", "smoothest" or vertices')

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> Embedding:
        """Embed the metric.

        Returns
        -------
        Embedding
            The smoothest of the surfaces that were found to have these lengths; if there is none, the nearest
            attempt, with a diagnosis, or the best fit.  Of lengths with errors, given or shown by their
            digits, a smooth surface that agrees with them.
        """
        return Pipeline(metric, self, tolerance, log).run(STRATEGIES, choose, DECISIONS)


def _points(which: ArrayLike) -> tuple[tuple[float, ...], ...]:
    """Vertices as a tuple, which is compared and written as a whole."""
    points = np.asarray(which, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InvalidParameter(
            f"which has the shape {points.shape}, not (V, 3), or numbers that are not finite"
        )
    return tuple(map(tuple, points.tolist()))
