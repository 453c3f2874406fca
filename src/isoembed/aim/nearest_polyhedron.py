"""Polyhedron of a nearby convex metric, the start of the pull-back; polishing of convex results."""

import numpy as np

from isoembed.aim.acceptance import PLACED, REALIZED, is_near
from isoembed.aim.convexification import FAR_MARGIN
from isoembed.aim.pipeline import Pipeline
from isoembed.aim.problem import Problem
from isoembed.aim.stage_seconds import POLYHEDRON, PULL_BACK
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, NotEmbedded


def fresh(problem: Problem) -> Problem:
    """Copy of the problem with an unused convexification."""
    return Problem(problem.metric, problem.tolerance, problem.name, problem.work)


def nearest_polyhedron(problem: Problem, pipeline: Pipeline) -> Floats:
    """Vertices of the polyhedron of a nearby convex metric, (V, 3), or an approximation of it."""
    from isoembed.alexandrov.method import convex_polyhedron
    from isoembed.metric.conformal_sphere import conformal_sphere
    from isoembed.metric.curvature import area
    from isoembed.metric.delaunay import delaunay
    from isoembed.metric.polyhedral import PolyhedralMetric
    from isoembed.surface.measures import outward

    metric, log = problem.metric, pipeline.log
    log.expect(POLYHEDRON | PULL_BACK)
    with log.stage("waypoint") as recorder:
        convex = problem.convexification.metric(FAR_MARGIN, recorder)
    if convex is not None:
        try:
            found = convex_polyhedron(convex.normalized, PLACED, log)
            return problem.in_original_order(convex.unit * found.vertices)
        except NotEmbedded as failure:
            nearest = failure.embedding.vertices[: problem.numbers.size]
            return problem.in_original_order(convex.unit * nearest)
        except InvalidMetric:  # too thin: fewer than three deficits beyond rounding
            pass
    with log.stage("sphere") as recorder:
        x = outward(metric.faces, conformal_sphere(delaunay(metric), recorder).points)
        return x * np.sqrt(area(metric) / area(PolyhedralMetric.from_mesh(x, metric.faces)))


def polished_polyhedron(vertices: Floats, pipeline: Pipeline) -> Embedding:
    """The polyhedron of a convex metric on the given triangles, polished to rounding if possible."""
    found = pipeline.problem.surface(vertices)
    if found.residual <= REALIZED or not is_near(found):
        return found
    with pipeline.log.stage("polish") as recorder:
        polished = pipeline.problem.annealed(vertices, recorder)
    return found if polished.surface.concave_edges.any() else polished
