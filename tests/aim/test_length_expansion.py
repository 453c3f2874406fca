"""Lengths to second order, against the lengths themselves."""

import numpy as np
import pytest

import curved_bodies
import zoo
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from isoembed.surface.rigidity import LengthSystem

CURVED = [(-1.0, 2.0), (1.0, 1.2)]


def expansion(curvature, size):
    space = Space(curvature)
    if space.is_euclidean:
        x, faces = zoo.random_hull(30, 0)
        metric = PolyhedralMetric.from_mesh(x, faces)
    else:
        x, faces = curved_bodies.hull(space, 30, size, 0)
        metric = curved_bodies.metric_of(space, x, faces)
    return LengthExpansion(LengthSystem(metric.triangulation, space=space), x, metric.lengths)


def test_in_euclidean_space_the_expansion_is_exact():
    about = expansion(0.0, 1.0)
    d = np.random.default_rng(0).normal(size=(1, *about.vertices.shape))
    expanded = about.residuals + about.rates(d)[0] + about.bends(d, d)[0] / 2
    assert about.residuals_at(d[0]) == pytest.approx(expanded, abs=1e-12)


@pytest.mark.parametrize(("curvature", "size"), CURVED)
def test_derivatives_of_lengths_along_motions(curvature, size):
    about = expansion(curvature, size)
    motions = np.random.default_rng(0).normal(size=(2, *about.vertices.shape))
    h = 1e-4

    def errors(s, t):
        return about.residuals_at(h * (s * motions[0] + t * motions[1]))

    assert (errors(1, 0) - errors(-1, 0)) / (2 * h) == pytest.approx(
        about.rates(motions)[0], rel=1e-4, abs=1e-4
    )
    mixed = (errors(1, 1) - errors(1, -1) - errors(-1, 1) + errors(-1, -1)) / (2 * h) ** 2
    assert mixed == pytest.approx(about.bends(motions[0], motions[1]), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize(("curvature", "size"), [(0.0, 1.0), *CURVED])
def test_motions_change_the_lengths_as_asked(curvature, size):
    about = expansion(curvature, size)
    changes = np.random.default_rng(1).normal(size=(3, len(about.lengths)))
    assert about.rates(about.motions(changes)) == pytest.approx(changes, abs=1e-7)
