"""``isoembed deviation``: what errors of the lengths do to a surface in a file."""

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.io import read_surface
from strict_json import strict


@pytest.fixture
def peanut():
    """A surface, s.npz."""
    vertices, faces = triangulate(CassiniPeanut(), 100)
    np.savez("s.npz", vertices=vertices, faces=faces)
    return read_surface("s.npz")


def test_numbers(call, peanut):
    status, out, err = call("deviation", "s.npz", "--length-error", "1e-4")
    sigma = isoembed.Sensitivity(peanut).deviation(1e-4)
    assert (status, err) == (0, "")
    assert f"area        {peanut.area:.12g} +- {sigma.area:.2g}\n" in out
    assert f"(at vertex {np.argmax(sigma.vertices)})\n" in out
    assert strict(call("deviation", "s.npz", "--length-error", "1e-4", "--json")[1]) == sigma.report


def test_errors_of_each_edge(call, peanut):
    np.save("e.npy", np.linspace(0, 1e-4, len(peanut.metric.edges)))
    found = strict(call("deviation", "s.npz", "--length-error", "e.npy", "--json")[1])
    assert found == isoembed.Sensitivity(peanut).deviation(np.load("e.npy")).report


def test_surface_and_picture(call, peanut):
    assert call("deviation", "s.npz", "--length-error", "1e-4", "-o", "d.npz")[0] == 0
    written, sigma = np.load("d.npz"), isoembed.Sensitivity(peanut).deviation(1e-4)
    assert np.allclose(written["vertex_deviation"], sigma.vertices)
    assert np.allclose(written["mean_curvature_deviation"], sigma.mean_curvature)
    assert call("deviation", "s.npz", "--length-error", "1e-4", "-o", "d.svg")[0] == 0


def test_bounds(call, peanut):
    status, out, err = call("deviation", "s.npz", "--length-error", "1e-10", "--bound")
    bound = isoembed.Sensitivity(peanut).deviation_bound(1e-10)
    assert (status, err) == (0, "")
    assert f"volume      {peanut.volume:.17g} +- {1.06 * bound.volume:.2g}\n" in out
    assert out.splitlines()[-1].startswith("proven: ")
    found = strict(call("deviation", "s.npz", "--length-error", "1e-10", "--bound", "--json")[1])
    assert found == bound.report and found["reason"] == ""
    status, out, err = call("deviation", "s.npz", "--length-error", "1e-2", "--bound", "-o", "no.npz")
    assert (status, err) == (3, "")
    assert out.startswith("not proven, because the residuals are too large: h = ")
    with pytest.raises(FileNotFoundError):
        np.load("no.npz")


@pytest.mark.parametrize(
    ("given", "sentence"),
    (
        ("much", "--length-error much is neither a number nor a .npy file"),
        ("-1", "the error of edge 0 is -1.0, which is negative"),
        ("nan", "the errors at [0] are nan, which is not finite"),
        ("none.npy", "none.npy"),
    ),
)
def test_errors_that_are_refused(call, peanut, given, sentence):
    status, out, err = call("deviation", "s.npz", "--length-error", given)
    assert (status, out) == (2, "") and sentence in err and err.count("\n") == 1


def test_flat_vertex(call):
    x, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    split = np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])
    np.savez("flat.npz", vertices=np.vstack([x, x[faces[0]].mean(axis=0)]), faces=split)
    status, out, err = call("deviation", "flat.npz", "--length-error", "1e-4")
    assert (status, out) == (2, "") and "is not infinitesimally rigid" in err
