"""The pull-back guided by bending, and the Laplacian that measures it."""

import numpy as np
import pytest

import isoembed
import smooth
import zoo
from isoembed.aim.adaptive import Aim
from isoembed.aim.bending import cotangent_laplacian
from isoembed.gallery import CassiniPeanut, Ellipsoid, triangulate
from isoembed.metric.curvature import area
from isoembed.metric.polyhedral import PolyhedralMetric


def test_the_laplacian_is_symmetric_and_kills_constants():
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(40, 0))
    K = cotangent_laplacian(metric)
    assert np.abs(K - K.T).max() < 1e-14
    assert np.abs(K @ np.ones(40)).max() < 1e-12
    assert np.linalg.eigvalsh(K.toarray())[1] > 0


def test_the_energy_of_the_coordinates_is_twice_the_area():
    # Half the integral of |grad x|^2, exactly, where no weight is clamped.
    vertices, faces = zoo.icosphere(2)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    energy = np.sum(vertices * (cotangent_laplacian(metric) @ vertices))
    assert energy == pytest.approx(2 * area(metric), rel=1e-13)


@pytest.mark.parametrize("surface", [CassiniPeanut(), Ellipsoid((3.0, 2.0, 1.0))])
def test_guided_alone_it_finds_the_same_surface(surface):
    vertices, faces = triangulate(surface, 200)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    found = isoembed.embed(metric, method=Aim(largest_change=1e-9))  # no step of the plain path is accepted
    assert [stage.name for stage in found.stages][-2:] == ["guided pull back", "polish"]
    assert smooth.misfit(found.vertices, vertices) < 1e-9
    assert found.residual < 1e-12


def test_it_gives_up_on_lengths_that_have_no_surface():
    vertices, faces = smooth.ellipsoid()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    noise = np.random.default_rng(0).uniform(-0.1, 0.1, len(metric.lengths))
    with pytest.raises(
        isoembed.NotEmbedded, match="guided by bending the pull-back did not reach it"
    ) as error:
        isoembed.embed(metric.with_lengths(metric.lengths * (1 + noise)))
    assert error.value.embedding.residual > 1e-10
