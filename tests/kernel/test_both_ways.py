"""Whatever kernels are given in the course of an embedding, they do the same as Python and compiled."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import isoembed
from isoembed.gallery import Ellipsoid, Ergosphere, triangulate
from isoembed.intrinsic.chart import motion, toward, turn_at
from isoembed.kernel import choice
from isoembed.space.trigonometry import angle_between, apex, twice_area
from zoo import random_hull


def copied(value):
    """The same again, with arrays of its own, of the same types for numba."""
    if isinstance(value, np.ndarray):
        copy = value.copy(order="K")
        copy.flags.writeable = value.flags.writeable
        return copy
    if isinstance(value, tuple):
        return type(value)(map(copied, value)) if type(value) is tuple else type(value)(*map(copied, value))
    return value


def assert_same(first, second, name):
    """Equal, to the last bit."""
    if isinstance(first, tuple):
        assert len(first) == len(second), name
        for one, other in zip(first, second, strict=True):
            assert_same(one, other, name)
    else:
        assert (first is None) == (second is None), name
        np.testing.assert_array_equal(first, second, err_msg=name)


@pytest.fixture(scope="module", autouse=True)
def compiled():
    """Whatever numba is asked for is compiled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choice, "WHEN", "compiled")
        yield


@given(
    st.tuples(*[st.floats(0.0, 2.0)] * 3),
    st.sampled_from([angle_between, apex]),
    st.sampled_from([0.0, -1.0, 1.0, -1e-3]),
)
def test_triangles_of_all_shapes_and_of_none(sides, function, curvature):
    args = (*sides, curvature)
    assert_same(function._interpret(args), function.dispatcher(*args), function.name)
    assert_same(twice_area._interpret(sides), twice_area.dispatcher(*sides), twice_area.name)


@given(
    st.tuples(*[st.complex_numbers(max_magnitude=0.9, allow_nan=False)] * 4),
    st.sampled_from([0.0, -1.0, 1.0, -1e-3]),
)
def test_points_of_charts(points, curvature):
    assume(min(abs(points[0] - points[1]), abs(points[2] - points[3])) > 1e-6)
    for function, args in ((toward, points[:2]), (turn_at, points[:3]), (motion, points)):
        args = (*args, curvature)
        assert_same(function._interpret(args), function.dispatcher(*args), function.name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mesh", "method"),
    [
        (triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60), "aim"),
        (triangulate(Ergosphere(0.3), 60), "aim"),
        (random_hull(60, seed=1), "alexandrov"),
    ],
    ids=["ellipsoid", "ergosphere", "hull"],
)
def test_all_calls_of_an_embedding(monkeypatch, mesh, method):
    seen = set()

    def both(kernel, *args):
        if choice._THREAD.interpreting:
            return kernel.py_func(*args)
        others = copied(args)
        result = kernel._interpret(args)
        assert_same(result, kernel.dispatcher(*others), kernel.name)
        assert_same(args, others, kernel.name)  # and have made of them
        seen.add(kernel.name)
        return result

    monkeypatch.setattr(choice.Kernel, "__call__", both)
    isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*mesh), method=method)
    assert len(seen) > 20
