"""The default method in hyperbolic and spherical space: coordinates come back from lengths; flat limits."""

from functools import partial

import numpy as np
import pytest

import curved_bodies
import isoembed
import zoo
from isoembed.aim.adaptive import Aim
from isoembed.embedding.fitted import FittedSurface
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.gallery import BentTube, CassiniPeanut, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space

SIZES = [(-1.0, 0.1), (-1.0, 1.0), (-1.0, 3.0), (1.0, 0.1), (1.0, 1.0), (1.0, 1.3)]


def recovered(space, x, faces):
    """The embedding of a surface's lengths, and how far distances in it are from those in the surface."""
    surface = isoembed.embed(curved_bodies.metric_of(space, x, faces))
    return surface, curved_bodies.misfit(space, surface.vertices, x)


@pytest.mark.parametrize(("curvature", "size"), SIZES)
@pytest.mark.parametrize(("n", "seed"), [(8, 0), (60, 1)])
def test_convex_hulls_come_back_from_their_lengths(curvature, size, n, seed):
    space = Space(curvature)
    surface, error = recovered(space, *curved_bodies.hull(space, n, size, seed))
    assert surface.space == space
    assert error < 1e-12 * max(size, 1.0)
    assert not surface.surface.concave_edges.any()
    assert surface.stages[-1].name in (["radii"] if size <= 1 else ["radii", "leap"])
    assert sum(stage.factorizations for stage in surface.stages) <= 5  # two by a first try


@pytest.mark.parametrize(("curvature", "size"), [(-1.0, 0.5), (-1.0, 1.0), (1.0, 1.0)])
def test_bodies_with_less_curvature_than_space_come_back_too(curvature, size):
    space = Space(curvature)
    surface, error = recovered(space, *curved_bodies.smooth(space, CassiniPeanut(), 100, size))
    assert isoembed.report(surface)["input"]["negative_deficits"] > 10
    assert error < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("curvature", "size"), [(-1.0, 0.5), (-1.0, 1.0), (1.0, 0.5), (1.0, 1.3)])
def test_they_come_back_along_the_guided_path(curvature, size):
    space = Space(curvature)
    surface, error = recovered(space, *curved_bodies.smooth(space, BentTube(), 300, size))
    assert "guided pull back" in [stage.name for stage in surface.stages]
    assert error < 1e-6
    assert sum(stage.factorizations for stage in surface.stages) <= 45


@pytest.mark.parametrize(
    "mesh",
    [
        pytest.param(partial(zoo.random_hull, 30, 2), id="hull"),
        pytest.param(partial(triangulate, CassiniPeanut(), 80), id="peanut", marks=pytest.mark.slow),
    ],
)
def test_as_curvature_tends_to_zero_surfaces_tend_to_the_euclidean_one_linearly(mesh):
    vertices, faces = mesh()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    size = np.abs(vertices).max()

    def distances(curvature):
        curved = PolyhedralMetric(faces, metric.lengths, metric.edges, curvature=curvature / size**2)
        surface = isoembed.embed(curved)
        i, j = np.triu_indices(len(vertices), 1)
        return surface.space.distances(surface.vertices[i], surface.vertices[j]) / size

    flat = distances(0.0)
    for sign in (-1, 1):
        coarse, fine, tiny = (np.abs(distances(sign * k) - flat).max() for k in (1e-3, 1e-4, 1e-13))
        assert coarse / fine == pytest.approx(10, rel=0.02)
        assert tiny < 1e-11


def test_the_unit_does_not_matter_if_it_is_that_of_curvature_too():
    space = Space(-1.0)
    metric = curved_bodies.metric_of(space, *curved_bodies.smooth(space, CassiniPeanut(), 100, 1.0))
    surface = isoembed.embed(metric)
    for factor in (1e-120, 0.3, 1e100):
        scaled = isoembed.embed(metric.scaled(factor))
        assert scaled.space.curvature == pytest.approx(-1 / factor**2)
        assert curved_bodies.misfit(space, scaled.vertices / factor, surface.vertices) < 1e-12


def noisy(space, size):
    x, faces = curved_bodies.smooth(space, CassiniPeanut(), 100, size)
    metric = curved_bodies.metric_of(space, x, faces)
    rng = np.random.default_rng(0)
    errors = 0.02 * metric.mean_length * rng.normal(size=metric.lengths.size)
    return x, metric.with_lengths(metric.lengths + errors)


def test_lengths_without_a_surface_are_told_where():
    with pytest.raises(
        NotEmbedded, match="which is where the curvature of the surface is below that of space"
    ):
        isoembed.embed(noisy(Space(-1.0), 1.0)[1])


@pytest.mark.parametrize("curvature", [-1.0, 1.0])
def test_lengths_without_a_surface_have_a_best_fit(curvature):
    space = Space(curvature)
    x, metric = noisy(space, 1.0)
    fit = isoembed.embed(metric, method=Aim(best_fit=True))
    assert isinstance(fit, FittedSurface)
    assert fit.noise == pytest.approx(0.02, rel=0.3)
    assert curved_bodies.misfit(space, fit.vertices, x) < 0.2 * metric.mean_length


def test_methods_that_embed_in_euclidean_space_only_refuse_curved_metrics():
    space = Space(-0.25)
    metric = curved_bodies.metric_of(space, *curved_bodies.hull(space, 10, 1.0, 0))
    with pytest.raises(
        InvalidParameter, match=r"curvature -0\.25, and the method 'paper' embeds in Euclidean"
    ):
        isoembed.embed(metric, method="paper")
