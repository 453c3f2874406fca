"""Error message of a failed embedding: the largest residuals, and advice."""

import numpy as np

from isoembed.aim.acceptance import PLACED
from isoembed.alexandrov.method import repair_that_succeeds
from isoembed.arrays import Mask
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.fitted import FittedSurface
from isoembed.mesh.components import connected_parts
from isoembed.metric.curvature import deficits, negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.vertex_links import link_gaps
from isoembed.progress.stages import Log
from isoembed.reprs import rounded_up

UNLIKE = 0.05  # mean edge lengths; errors of measured surfaces are smaller


def diagnosis(attempt: Embedding, fit: FittedSurface | None, effort: float) -> str:
    """Describe where the nearest surface misses the lengths, and advise the user.

    Parameters
    ----------
    attempt : Embedding
        The nearest surface found, which misses the lengths.
    fit : FittedSurface or None
        The best fit to the lengths, if there is one.
    effort : float
        Effort of the failed search.

    Returns
    -------
    str
        A few sentences.
    """
    found = (
        f"no surface with these lengths was found: the nearest misses {_worst_edge(attempt)} "
        f"by {attempt.residual:.1e} of the mean edge length"
    )
    unlike = fit is None or fit.noise > UNLIKE
    return ". ".join(
        [found, *_curvature(attempt.metric, unlike), _errors(fit), *_longer_search(attempt.metric, effort)]
    )


def _curvature(metric: PolyhedralMetric, unlike: bool) -> list[str]:
    """Sentences on negative deficits, and advice if the lengths are like those of a surface."""
    negative = negative_deficits(metric)
    if not negative.any():
        return [
            'No deficit is negative: method="alexandrov" finds the convex polyhedron, which exists by '
            "Alexandrov's theorem"
        ]
    regions = len(connected_parts(metric.triangulation.adjacency, negative))
    found = _negative(metric, negative, regions)
    if unlike:
        return [found]
    if regions * 5 <= negative.sum():  # noise makes smaller regions of negative deficits
        return [
            found,
            "Negative curvature over whole regions is unlikely to be noise, and not every metric with it has "
            "a smooth surface",
        ]
    lowest, total = deficits(metric).min(), deficits(metric)[negative].sum()
    if -total > 0.05 * 4 * np.pi:  # less may be noise on a convex body
        return [found]
    repaired = repair_that_succeeds(metric.normalized, float(rounded_up(-lowest)), PLACED, Log())
    return [found, f"If the body is convex, {repaired}, on triangles of its own"] if repaired else [found]


def _negative(metric: PolyhedralMetric, negative: Mask, regions: int) -> str:
    epsilon, count = deficits(metric), int(negative.sum())
    v = int(np.argmin(epsilon))
    around = epsilon[metric.triangulation.adjacency[[v]].indices].mean()
    number = f"{count} of {len(epsilon)} deficits {'is' if count == 1 else 'are'} negative"
    if not metric.space.is_euclidean:
        number += ", which is where the curvature of the surface is below that of space"
    where = f", in {regions} connected region{'s' if regions > 1 else ''}" if count > 1 else ""
    return (
        f"{number}{where}; the lowest is {epsilon[v]:.2g} radians at vertex {v}, "
        f"whose neighbors have {around:.2g} on average"
    )


def _errors(fit: FittedSurface | None) -> str:
    """Sentence on the errors of the lengths estimated by the best fit."""
    if fit is None:
        return "No smooth surface was found near them: check that each length belongs to its edge"
    if fit.noise > UNLIKE:
        return (
            "No smooth surface was found near them: the best fit misses them by "
            f"{fit.residual_rms:.0%} of the mean edge length (root mean square), most at "
            f"{_worst_edge(fit)}: check that each length belongs to its edge"
        )
    squares = fit.residuals**2
    at_vertices = np.bincount(fit.metric.edges.ravel(), np.repeat(squares, 2)) / fit.triangulation.degrees
    v = int(np.argmax(at_vertices))
    if at_vertices[v] > 20.0 * squares.mean():  # above the maximum for noise
        return (
            f"Smooth surfaces miss them most at the edges of vertex {v}, with "
            f"{at_vertices[v] / squares.mean():.0f} times the mean squared residual: check the lengths "
            "there, or take the best fit, method=Aim(best_fit=True)"
        )
    return (
        f"A smooth surface has them up to errors of about {fit.noise:.0e} of the mean edge length "
        "(root mean square): if yours may have such errors, take the best fit, "
        "method=Aim(best_fit=True)"
    )


def _longer_search(metric: PolyhedralMetric, effort: float) -> list[str]:
    """Advice on a longer search for exact lengths, if there is one."""
    if not (metric.space.is_euclidean and negative_deficits(metric).any()) or link_gaps(metric).max() > 0:
        return []
    more = f"{20 * max(effort, 1.0):g}"  # of 18 rocks of 120 and 200 vertices it finds all; 10 finds 11 of 15
    return [
        "If the lengths are the exact ones of a coarse or rough body, a longer search may find it: "
        f"method=Aim(effort={more})"
    ]


def _worst_edge(embedding: Embedding) -> str:
    e = int(np.argmax(embedding.residuals))
    return f"edge {e} {embedding.metric.edges[e].tolist()}"
