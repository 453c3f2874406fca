"""A metric whose surface is sought by the adaptive method, and what all ways to it share."""

from functools import cached_property

from isoembed.aim.accuracy import REALIZED
from isoembed.aim.convexification import Convexification
from isoembed.aim.radii_newton import newton_on_radii_at_once
from isoembed.alexandrov.newton import Analyses
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log

PLACED = 1e-10  # mean edge lengths: residual asked of the convex polyhedron
NEARLY = 1e-6  # mean edge lengths: the largest residual between two realizations
FIT = 36  # factorizations of the best fit, as a rule
PATCH_EFFORT = 10.0  # for patches and the best fit: more does not make them better


# Seconds that stages take as a rule, 40,000 vertices, for the time left.
AT_ONCE = {"radii": 1.0}


class Search:
    """A metric whose surface is sought, and what all ways to it share.

    Parameters
    ----------
    metric : PolyhedralMetric
    tolerance : float
    log : Log
    name : str
        Of the method, which the surfaces bear.

    Attributes
    ----------
    good : float
        Residual of a surface that is taken.
    numbers : ndarray of int, shape (V,)
        The vertices in the order of the `convexification`, in which what is near is near in memory.
    """

    def __init__(self, metric: PolyhedralMetric, tolerance: float, log: Log, name: str) -> None:
        self.metric, self.tolerance, self.log, self.name = metric, tolerance, log, name
        self.good = max(tolerance, REALIZED)  # below that, the tolerance is beyond rounding
        tables = GluedMetric.of(metric).half_edges(directed=False)
        self.numbers = tables.order_in_memory()
        self.convexification = Convexification(GluedMetric.flipped(tables.in_order(self.numbers)))

    @cached_property
    def analyses(self) -> Analyses:
        """What factorizations for the radii share."""
        return Analyses.of(self.convexification.given.half_edges(directed=False))

    @property
    def is_nearly_convex(self) -> bool:
        """Whether a body of pyramids may have this metric."""
        # Of 4 pi: negative curvature of a metric that may be nearly convex.
        return self.convexification.negative_curvature < 0.03

    def surface(self, vertices: Floats) -> Embedding:
        """The surface with these vertices."""
        return Embedding(self.metric, vertices, method=self.name, tolerance=self.tolerance)

    def realized_at_once(self) -> Embedding | None:
        """Realize a metric that is convex or nearly so at once; None where that cannot be trusted."""
        begun = self.log.begun
        if begun not in (None, *AT_ONCE) or not self.is_nearly_convex:  # it was in vain, or would be
            return None
        self.log.expect(AT_ONCE)
        given = self.convexification.given
        vertices = newton_on_radii_at_once(given, self.analyses, self.log, self.numbers)
        if vertices is None:
            return None
        found = self.surface(vertices)
        return found if found.residual <= self.good else None
