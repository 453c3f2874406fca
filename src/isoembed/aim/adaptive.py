"""The default method, `Aim`: uniformize to convexity, embed by Alexandrov's theorem, pull back.

Each of the paper's three steps is replaced by one that does not fail:

1. uniformize, but only as far as convexity: `isoembed.aim.convexification`, in place of
   `isoembed.aim.uniformize`;
2. embed the convex metric: the exact polyhedron of Alexandrov's theorem, `isoembed.alexandrov`, in place of
   `isoembed.aim.embedding_tree`;
3. pull back: in one step by Newton's method on the radii or the lengths, or by reflecting the dents;
   otherwise along a path of smooth surfaces, multilevel for many vertices.  The paper's is
   `isoembed.aim.adiabatic_pullback`.

`isoembed.aim.strategies` lists the strategies in order: those for convex metrics, the three steps, and
searches after a failed pull-back; `isoembed.aim.pipeline` runs them.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from isoembed.aim.choice import no_convex
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
        Whether to return the smooth least-squares surface, a `FittedSurface`, if no surface with the lengths
        is found.
    effort : float
        Cost limit of the searches after a failed pull-back, relative to the cost up to there.  Cost is
        counted in factorizations, so that results do not depend on the machine.  The search for patches on
        the wrong side and the best fit together cost at most ``1 + effort`` times as much, and never more
        than 11 times; with `best_fit` the fit is not limited.  0 means no search.  Above 1, a search for
        vertices on the wrong side follows, at ``effort`` times the cost.
    which : {"convex", "smoothest"} or array_like, shape (V, 3), optional
        Choice among the realizations: the convex one; the smoothest; or the nearest to a surface with the
        given vertices, at any scale.  Newton's method starts from it; the other strategies follow unless it
        ends within 0.05 mean edge lengths.  By default the answer is on the branch of a convex surface, or,
        if that branch is not followed, the smoothest.
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
            The smoothest surface found with these lengths; if none is found, the nearest attempt, with a
            diagnosis, or the best fit.  For lengths with errors, given or inferred from their digits, a
            smooth surface that agrees with them.
        """
        found = Pipeline(metric, self, tolerance, log).run(STRATEGIES, choose, DECISIONS)
        if self.which == "convex" and found.converged and found.surface.concave_edges.any():
            raise no_convex(found)
        return found


def _points(which: ArrayLike) -> tuple[tuple[float, ...], ...]:
    """Vertices as a tuple, so that methods can be compared and written."""
    points = np.asarray(which, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InvalidParameter(
            f"which has the shape {points.shape}, not (V, 3), or numbers that are not finite"
        )
    return tuple(map(tuple, points.tolist()))
