"""The embedding flow: where it stays, and its order."""

import numpy as np
import pytest

from isoembed import InvalidParameter
from isoembed.gallery import KerrHorizon
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import Harmonics, PulledBack
from reproduction.baselines.embedding_flow import embedding_flow
from reproduction.baselines.subjects import Subject
from reproduction.baselines.uniformization import uniformized
from smooth_bodies import misfit

ROUND = PulledBack(lambda u: np.broadcast_to(2.0 * np.eye(3), (len(u), 3, 3)))
KERR = Subject("Kerr", KerrNewmanHorizon(mass=1.0, spin=0.5), KerrHorizon(spin=0.5).point)


def test_the_flow_leaves_a_sphere_alone():
    start = uniformized(ROUND, Harmonics(4, 4))
    found = embedding_flow(ROUND, start, steps=1, order=1)
    u = fibonacci_directions(50)
    assert found.strain < 1e-7  # the curvature has eight digits
    assert misfit(found.points(u), 2.0 * u) < 1e-7


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_flow_has_the_order_of_its_steps(order):
    start = uniformized(KERR.metric, Harmonics(16, 1))
    u = fibonacci_directions(100)
    errors = [
        misfit(embedding_flow(KERR.metric, start, steps, order).points(u), KERR.point(u)) for steps in (4, 8)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def test_flows_that_cannot_be_are_refused():
    start = uniformized(ROUND, Harmonics(2, 2))
    with pytest.raises(InvalidParameter, match="the order is 3, not one of 1, 2 and 4"):
        embedding_flow(ROUND, start, steps=4, order=3)
    with pytest.raises(InvalidParameter, match="the number of steps is 0"):
        embedding_flow(ROUND, start, steps=0)
