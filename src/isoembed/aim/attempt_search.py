"""From a surface that nearly has its lengths to a realization of them, by the search for realizations nearby.

A search that ends where little is missed has, as a rule, a few folds on the wrong side that together cost
next to nothing: smoothness does not tell them, nor does any single motion.  Leads along groups of soft
motions (`isoembed.aim.realization_leads`) do, one of them or several in turn.  Of six bumpy bodies of 400 and
800 vertices that an effort of 10 had left at 8e-8 to 6e-4 mean edge lengths, four were found, two of them the
surface that the lengths were taken from, the others within .03 mean edge lengths of it.
"""

from dataclasses import dataclass

from isoembed.aim.realization_search import RealizationSearch
from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class AboutAttemptThresholds:
    """Thresholds of the search about an attempt."""

    motions: int = threshold(5, "count", "Motions that are taken together at most, about an attempt.")
    distance: float = threshold(
        0.12, "mean edge lengths", "How far a vertex of a realization may be from it."
    )
    largest: int = threshold(
        1_000, "vertices", "Of a surface at most: some seconds for each set of leads there."
    )


ABOUT_ATTEMPT = AboutAttemptThresholds()


def realization_near(
    metric: PolyhedralMetric, system: LengthSystem, vertices: Floats, recorder: StageRecorder, most: float
) -> Floats | None:
    """The first realization that is met about an attempt, or the smoothest of those that come with it.

    Parameters
    ----------
    metric : PolyhedralMetric
        In Euclidean space, of mean edge length 1 or so.
    system : LengthSystem
        Of its triangulation.
    vertices : ndarray, shape (V, 3)
    recorder : StageRecorder
        Counts factorizations, and is shown how much is done.
    most : float
        Factorizations after which no lead is sought or followed any more; the four sets of leads that there
        are at most cost more than these.

    Returns
    -------
    ndarray, shape (V, 3), or None
        None where none is met, or the surface is large.
    """
    if len(vertices) > ABOUT_ATTEMPT.largest:
        return None
    begun = recorder.factorizations

    def is_enough(search: RealizationSearch) -> bool:
        spent = recorder.factorizations - begun
        recorder.show(vertices=vertices, done=min(spent / most, 1.0))
        return bool(search.found) or spent >= most

    search = RealizationSearch(
        metric, system, vertices, recorder, ABOUT_ATTEMPT.motions, ABOUT_ATTEMPT.distance, is_enough
    )
    for _ in search.steps(0):
        if is_enough(search):
            break
    return search.smoothest if search.found else None
