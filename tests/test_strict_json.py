"""JSON without NaN and infinity."""

import numpy as np

from isoembed.strict_json import plain, strict_json
from strict_json import strict


def test_what_is_not_finite_is_null():
    document = {
        "max": np.inf,
        "row": (1, np.float64("nan"), True, None, "inf"),
        "table": np.array([[1.5, -np.inf], [2.0, 3.0]]),
        "inner": {2: np.int64(7), "flag": np.bool_(False)},
    }
    found = {
        "max": None,
        "row": [1, None, True, None, "inf"],
        "table": [[1.5, None], [2.0, 3.0]],
        "inner": {"2": 7, "flag": False},
    }
    assert plain(document) == found
    assert strict(strict_json(document)) == found
    assert strict(strict_json(document, indent=2)) == found


def test_finite_numbers_keep_all_digits():
    values = [0.1, 1e-320, 1.7976931348623157e308, -0.0, 10**30]
    assert strict(strict_json(values)) == values
