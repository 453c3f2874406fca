"""What a `Horizon` is made of, and what does not go together."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity import CoordinateShape, KerrNewmanHorizon, KerrSchild, horizon_data

METRIC = KerrNewmanHorizon(1.0, 0.5).data()
POINTS = CoordinateShape.star_shaped(2.0 * np.array([*np.eye(3), *-np.eye(3)]), "six points", np.zeros(3))


@pytest.mark.parametrize(
    ("found", "given", "sentence"),
    [
        (
            METRIC,
            {"geometry": KerrSchild(1.0, (0, 0, 0.5))},
            "a.npz holds a metric of its own: it needs no geometry",
        ),
        (METRIC, {"axis": (0, 0, 1)}, "a.npz holds no coordinates that an axis could be given in"),
        (POINTS, {}, "name its geometry"),
    ],
)
def test_refusals(found, given, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        horizon_data(found, name="a.npz", **given)
