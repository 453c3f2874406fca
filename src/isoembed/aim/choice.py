"""Choice among several realizations of a metric: convex, smoothest, or nearest to a given surface.

A trusted strategy ends at one realization, on the branch of the convex surface from which it started.  It is
the answer unless another one is requested, even if a nearby realization is slightly smoother.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isoembed.aim.acceptance import REALIZED, are_identical, is_realization
from isoembed.aim.polygon_planarity import has_planar_polygons
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.evidence import Evidence
from isoembed.metric.convexity import DEVIATIONS, deficit_rounding, deficit_spread
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.surface.alignment import aligned

MOTIONS = 4  # softest motions searched for other realizations
NEAR_FIT = 3.0  # displacements of a flat vertex by errors of the lengths, the roots of these
FOLDED = 0.8  # share of the volume of a convex surface below which a fit is not near it
FAR = 0.05  # mean edge lengths; rough bodies have too many realizations farther away


def smoothest(surfaces: Sequence[Embedding], is_convex: bool, searched: bool) -> Embedding:
    """The smoothest realization, with the others attached; if there is none, the nearest attempt.

    Those in which given polygons are planar precede all others, and for a convex metric the convex one.

    Parameters
    ----------
    surfaces : sequence of Embedding
        In the order of discovery.
    is_convex : bool
        Whether the metric is convex.
    searched : bool
        Whether other realizations were searched for near one of them.
    """
    different: list[Embedding] = []
    for surface in surfaces:
        if is_realization(surface) and not any(are_identical(surface, other) for other in different):
            different.append(surface)
    if not different:
        return min(surfaces, key=lambda surface: surface.residual)
    if len(different) > 1:
        different.sort(
            key=lambda s: (
                not has_planar_polygons(s),
                is_convex and s.surface.concave_edges.any(),
                s.surface.fine_roughness,
            )
        )
    others = [_turned_to(different[0], other) for other in different[1:]]
    if not searched:
        return different[0]._with_others(others)
    from isoembed.aim.nearby_realizations import NEAR, SOFTEST, sought  # not needed for convex bodies

    evidence = sought(SOFTEST, NEAR)
    found = different[0]._with_others(others, Evidence("searched", evidence))
    return found._with_message(f"{found.message}; {evidence}")


def _turned_to(answer: Embedding, other: Embedding) -> Embedding:
    """Another realization, aligned with the answer: principal axes of similar surfaces may differ."""
    return _like(other, aligned(other.vertices, answer.vertices, other.metric.space))


def _like(embedding: Embedding, vertices: Floats) -> Embedding:
    """A surface with other vertices and the same metric, method and tolerance."""
    return Embedding(embedding.metric, vertices, method=embedding.method, tolerance=embedding.tolerance)


def with_neighbors(embedding: Embedding, log: Log) -> Embedding:
    """The same surface with the realizations found along its softest motions attached."""
    from isoembed.aim.nearby_realizations import sought
    from isoembed.aim.realization_search import RealizationSearch
    from isoembed.surface.rigidity import LengthSystem

    metric, evidence = embedding.metric, sought(MOTIONS, FAR)
    with log.stage("neighbors") as recorder:
        system = LengthSystem(metric.triangulation, space=metric.space, work=log.work)
        search = RealizationSearch(metric, system, embedding.vertices, recorder, MOTIONS, FAR)
        for _ in search.steps(1):
            pass
    others = list(embedding.others)
    for vertices in search.found:
        other = _like(embedding, vertices)
        if not any(are_identical(other, known) for known in (embedding, *others)):
            others.append(other)
    found = embedding._with_others(others, Evidence("searched", evidence))
    return found._with_message(f"{found.message}; {evidence}")


def requested(embedding: Embedding, which: str | tuple[tuple[float, ...], ...]) -> Embedding:
    """The requested realization among those found, with the others attached.

    Parameters
    ----------
    embedding : Embedding
        A realization of a normalized metric.
    which : {"convex", "smoothest"} or tuple of tuple of float
        Property, or the vertices, (V, 3), of a reference surface at any scale.

    Raises
    ------
    NotEmbedded
        A convex realization was requested, and none was found.
    """
    found = [embedding, *embedding.others]
    if which == "smoothest":
        best = min(found, key=lambda surface: surface.surface.fine_roughness)
    elif which == "convex":
        convex = convex_ones(embedding)
        if not convex:
            raise no_convex(embedding)
        best = convex[0]
    else:
        target = _like(embedding, reference_vertices(embedding.metric, np.array(which)))
        best = min(found, key=target.distance)
    rest = [surface for surface in found if surface is not best]
    answer = best._with_others(rest, embedding.uniqueness)
    if which not in ("convex", "smoothest"):
        answer = answer._with_message(
            f"{answer.message}; of the realizations found it is the nearest to the given surface, "
            f"{target.distance(best):.1e} mean edge lengths from it"
        )
    return answer


def convex_ones(embedding: Embedding) -> list[Embedding]:
    """The convex surfaces among this one and the others."""
    return [each for each in (embedding, *embedding.others) if not each.surface.concave_edges.any()]


def reference_vertices(metric: PolyhedralMetric, vertices: Floats) -> Floats:
    """Vertices of a reference surface, scaled to the metric.

    Raises
    ------
    InvalidParameter
        The number of vertices is not V, all of them coincide, or space is curved.
    """
    if not metric.space.is_euclidean:
        raise InvalidParameter("which=vertices requires a Euclidean metric")
    n = metric.triangulation.n_vertices
    if len(vertices) != n:
        raise InvalidParameter(f"the reference surface has {len(vertices)} vertices, but the metric {n}")
    a, b = metric.edges.T
    size = float(np.linalg.norm(vertices[a] - vertices[b], axis=1).mean())
    if not size > 0:
        raise InvalidParameter("all vertices of the reference surface coincide")
    return metric.mean_length / size * vertices


def is_convex_within(metric: PolyhedralMetric, error: Floats | float) -> bool:
    """Whether errors of the lengths, in mean edge lengths, may cause all negative deficits."""
    t = metric.triangulation
    if not (t.is_sphere and metric.space.is_euclidean):
        return False
    spread = deficit_spread(metric.faces, metric.face_lengths, t.sides_across) * np.max(error)
    return bool((metric.deficits >= -DEVIATIONS * spread).all())


def is_preferred(exact: Embedding, fit: Embedding) -> bool:
    """Whether an exact surface is preferred to a smooth fit.

    It is if it is smoother, unless the metric may be that of a convex surface, which the fit approximates,
    and the exact one is far from the fit.  A fit that has folded the sharp rim of a convex body encloses much
    less.
    """
    metric = fit.metric
    error = np.asarray(metric.length_errors) / metric.mean_length
    may_be_convex = is_convex_within(metric, error)
    if may_be_convex and fit.volume < FOLDED * exact.volume:
        return True
    smoother = exact.surface.fine_roughness <= fit.surface.fine_roughness + REALIZED  # equal to rounding
    near = exact.distance(fit) <= NEAR_FIT * np.sqrt(np.max(error))
    return bool(smoother and (near or not may_be_convex))


def not_convex(metric: PolyhedralMetric) -> bool:
    """Whether a deficit is negative by more than rounding."""
    return bool((metric.deficits < -deficit_rounding(metric)).any())


def no_convex(embedding: Embedding) -> NotEmbedded:
    """The error that none is convex: of all surfaces with these lengths, or of those that were found."""
    if embedding.metric.length_errors is not None:  # deficits are not exact, either
        e = int(np.argmax(embedding.surface.concave_edges))
        message = (
            "the surface found that agrees with the lengths within their errors is not convex: edge "
            f"{e} {embedding.edges[e].tolist()} is concave"
        )
        return NotEmbedded(message, embedding._with(message=message, is_requested=False))
    if not_convex(embedding.metric):
        deficits = embedding.metric.deficits
        v = int(np.argmin(deficits + deficit_rounding(embedding.metric)))
        message = (
            f"no convex surface has these lengths: the deficit of vertex {v} is {deficits[v]:.2g}, which is "
            "negative"
        )
        proof = Evidence("proved", "the angles at a vertex of a convex surface sum to 2 pi at most")
        return NotEmbedded(message, embedding._with(message=message, is_requested=False), proof)
    count = 1 + len(embedding.others)
    found = f"none of the {count} realizations" if count > 1 else "the only realization"
    message = (
        f"{found} found is {'convex' if count > 1 else 'not convex'}: no deficit is negative, and "
        'method="alexandrov" finds the convex polyhedron, on triangles of its own'
    )
    return NotEmbedded(message, embedding._with(message=message, is_requested=False))
