"""``isoembed compare``: two surfaces in files."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import discs
import isoembed
import zoo
from isoembed.embedding.comparison import stated
from isoembed.io import read_surface, write_metric, write_surface
from strict_json import strict
from two_realizations import cap_outside_and_inside


@pytest.fixture(scope="module")
def realizations():
    """With a cap outside and inside."""
    return cap_outside_and_inside(0.5)


@pytest.fixture
def files(call, realizations):
    """A metric, m.npz, and two surfaces, a.ply and b.npz."""
    first, second = realizations
    write_metric("m.npz", first.metric)
    write_surface("a.ply", first)
    write_surface("b.npz", second)
    return isoembed.compare(first, second)


def test_two_realizations(call, files):
    status, out, err = call("compare", "a.ply", "b.npz", "m.npz")
    assert (status, err) == (0, "")
    assert out.startswith("proven to be two exact surfaces with these lengths, 0.32")
    assert f"volume      {stated(files.difference.volume, files.error.volume)}, " in out
    assert "area        equal\n" in out
    found = strict(call("compare", "a.ply", "b.npz", "m.npz", "--json")[1])
    assert (found["certified"], found["same"]) == (True, False)
    assert found["difference"] == pytest.approx(files.difference.report, abs=1e-10)
    assert found["distance"] > found["isolation"] > 1e6 * found["distance_error"]


def test_by_default_the_lengths_are_those_of_the_first(call, files):
    status, out, _ = call("compare", "a.ply", "b.npz")
    assert status == 0 and out.startswith("proven to be two exact surfaces")
    write_surface("same.obj", read_surface("a.ply"))
    assert call("compare", "a.ply", "same.obj")[1].startswith("proven to be the same exact surface\n")


def test_surface_and_picture(call, files):
    assert call("compare", "a.ply", "b.npz", "m.npz", "-o", "d.npz")[0] == 0
    written = np.load("d.npz")
    assert np.allclose(written["distance"], files.difference.vertices, atol=1e-10)
    assert np.allclose(written["mean_curvature_difference"], files.difference.mean_curvature, atol=1e-9)
    assert call("compare", "a.ply", "b.npz", "-o", "d.svg")[0] == 0
    status, _, err = call("compare", "a.ply", "b.npz", "-o", "b.npz")
    assert status == 2 and "the output is the input b.npz" in err


def test_what_is_not_proven(call, files, realizations):
    first, _ = realizations
    np.savez("c.npz", vertices=1.001 * first.vertices, faces=first.faces)
    status, out, err = call("compare", "a.ply", "c.npz", "m.npz")
    assert (status, err) == (3, "")
    assert "because the second is not certified, because the lengths miss the tolerance" in out
    assert "+-" not in out
    found = strict(call("compare", "a.ply", "c.npz", "--json")[1])
    assert found["error"]["volume"] is None and found["difference"]["volume"] > 0
    status, out, _ = call("compare", "a.ply", "c.npz")  # of surfaces with other lengths none can be made
    assert status == 0
    assert (
        "differences between OTHER and SURFACE, in the unit of the lengths; signed values: OTHER - SURFACE\n"
        in out
    )
    assert call("compare", "a.ply", "a.ply", "c.npz")[1].splitlines()[0].endswith("both are equally smooth")


def test_files_that_do_not_go_together(call, files):
    vertices, faces = zoo.icosahedron()
    np.savez("small.npz", vertices=vertices, faces=faces)
    status, _, err = call("compare", "a.ply", "small.npz")
    hint = "surfaces are compared on the same triangles, with the same numbers of vertices"
    assert (status, err) == (2, f"isoembed: error: small.npz has 12 vertices, a.ply has 5: {hint}\n")
    status, _, err = call("compare", "small.npz", "a.ply", "m.npz")
    assert (status, err) == (2, f"isoembed: error: small.npz has 12 vertices, m.npz has 5: {hint}\n")
    np.savez("closed.npz", vertices=vertices, faces=faces)
    np.savez("open.npz", vertices=vertices, faces=np.delete(faces, [0], axis=0))
    for pair in (("closed.npz", "open.npz"), ("open.npz", "closed.npz")):
        status, out, err = call("compare", *pair)
        assert (status, out) == (2, "")
        assert f"face 0 {faces[0].tolist()} of closed.npz is not in open.npz: surfaces are compared" in err


@given(st.floats(-1e3, 1e3), st.floats(-12, 3).map(lambda power: 10.0**power))
def test_what_is_printed_holds_what_is_proven(value, error):
    printed, printed_error = map(float, stated(value, error).split(" +- "))
    assert printed - printed_error <= value - error
    assert value + error <= printed + printed_error


def test_flat_surfaces_have_no_volume_to_compare_with(call):
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    np.savez("flat.npz", vertices=square, faces=[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    status, out, _ = call("compare", "flat.npz", "flat.npz")
    assert status == 3
    assert "\nvolume      0\n" in out


def test_caps(call):
    points, faces = discs.hexagonal(3)
    x = discs.round_cap(points, 1.0)
    write_metric("cap.npz", isoembed.PolyhedralMetric.from_mesh(x, faces))
    for name, condition in (("free", "free"), ("flat", "plane")):
        assert call("embed", "cap.npz", "--boundary", condition, "-o", f"{name}.npz")[0] == 0
    status, out, _ = call("compare", "free.npz", "flat.npz", "cap.npz")
    assert status == 0  # none was to be made
    assert "because no proof is made for surfaces with boundary" in out
    assert "int H dA" in out and "volume" not in out
    report = strict(call("compare", "free.npz", "flat.npz", "--json")[1])
    assert report["difference"]["volume"] is None
    free, flat = (read_surface(f"{name}.npz") for name in ("free", "flat"))
    found = isoembed.compare(free, flat)
    assert report["distance"] == pytest.approx(found.distance) != 0
