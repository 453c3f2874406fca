"""``isoembed deviation``: what errors of the lengths do to a surface in a file."""

import numpy as np
import pytest

import discs
import isoembed
import zoo
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.io import read_surface, write_metric
from strict_json import strict


@pytest.fixture
def peanut():
    """A surface, s.npz."""
    vertices, faces = triangulate(CassiniPeanut(), 50)
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


def test_what_holds_a_boundary(call):
    points, faces = discs.hexagonal(3)
    x = discs.round_cap(points, 1.0)
    metric = isoembed.PolyhedralMetric.from_mesh(x, faces)
    [loop] = metric.triangulation.boundaries
    write_metric("cap.npz", metric)
    np.save("curve.npy", x[loop])
    np.save("heights.npy", x[loop, 2])
    for name in ("free", "plane", "curve.npy", "heights.npy"):
        assert call("embed", "cap.npz", "--boundary", name, "-o", "c.npz", "--quiet")[0] == 0
        status, out, _ = call("deviation", "c.npz", "--length-error", "1e-4", "--boundary", name, "--json")
        given = np.load(name) if name.endswith("npy") else name
        expected = isoembed.Sensitivity(isoembed.embed(metric, boundary=given)).deviation(1e-4).report
        found = strict(out)
        assert status == 0 and (found["volume"] is None) == (name == "free")
        assert found["vertices_rms"] == pytest.approx(expected["vertices_rms"], rel=1e-6)
        assert found["integrated_mean_curvature"] == pytest.approx(expected["integrated_mean_curvature"])
    out = call("deviation", "c.npz", "--length-error", "1e-4", "--boundary", "plane")[1]
    assert "int H dA" in out and "volume" in out and "first-order estimate is not valid" not in out


def test_conditions_that_do_not_suit(call, peanut):
    points, faces = discs.hexagonal(3)
    x = discs.round_cap(points, 1.0)
    np.savez("c.npz", vertices=x, faces=faces)
    np.save("two.npy", np.zeros(2))
    np.save("heights.npy", np.arange(18.0))
    for arguments, words in (
        (("c.npz",), "c.npz has a boundary: give its condition by --boundary"),
        (("s.npz", "--boundary", "free"), "s.npz is closed"),
        (("c.npz", "--boundary", "two.npy"), "two.npy has the shape (2,), not (18,) or (18, 3)"),
        (
            ("c.npz", "--boundary", "heights.npy"),
            "the boundary does not have the heights of 'heights': its vertex",
        ),
        (("c.npz", "--boundary", "free"), "the bending forces are balanced only to"),
    ):
        status, _, err = call("deviation", *arguments, "--length-error", "1e-4")
        assert status == 2 and words in err and err.count("\n") == 1
