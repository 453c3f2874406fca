"""What a `Horizon` is made of, and what does not go together."""

import numpy as np
import pytest

from gridded import sampled
from isoembed.errors import InvalidParameter
from isoembed.relativity import (
    CoordinateShape,
    IsotropicSchwarzschild,
    KerrNewmanHorizon,
    KerrSchild,
    StarSurface,
    find_horizon,
    horizon_data,
)

METRIC = KerrNewmanHorizon(1.0, 0.5).data()
POINTS = CoordinateShape.star_shaped(2.0 * np.array([*np.eye(3), *-np.eye(3)]), "six points", np.zeros(3))


@pytest.mark.parametrize(
    ("found", "given", "sentence"),
    [
        (
            METRIC,
            {"geometry": KerrSchild(1.0, (0, 0, 0.5))},
            "a.npz has a metric of its own: leave out the geometry",
        ),
        (METRIC, {"axis": (0, 0, 1)}, "a.npz has no coordinates, which an axis requires"),
        (POINTS, {}, "name its geometry"),
    ],
)
def test_refusals(found, given, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        horizon_data(found, name="a.npz", **given)


def test_a_surface_too_small_for_the_grid_has_a_note():
    sphere = StarSurface.sphere((0.0, 0.0, 0.0), 0.9)
    for n, said in ((22, True), (24, False)):  # 20 spacings are 1.9 and 1.74
        data, _ = horizon_data(sphere, sampled(KerrSchild(1.0, (0.0, 0.0, 0.0)), n, 1.0))
        assert any("the grid resolves horizons of at least" in note for note in data.notes) is said


def test_what_was_found_goes_with_its_own_slice_and_with_others():
    own = IsotropicSchwarzschild(1.0)
    found = find_horizon(own)
    for geometry in (None, own):
        data, facts = horizon_data(found, geometry)
        assert facts.found is found and data.marginal
    data, facts = horizon_data(found, IsotropicSchwarzschild(2.0))  # the same sphere around twice the mass
    assert facts.found is None and facts.surface is found.surface and not data.marginal
    u = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(data.mean_curvature(u), -4.0 / 27.0, rtol=1e-9)
