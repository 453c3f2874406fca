"""Surfaces with boundary by the command."""

import json
from pathlib import Path

import numpy as np
import pytest

import discs
from isoembed import PolyhedralMetric
from isoembed.io import write_metric
from strict_json import strict


@pytest.fixture
def cap():
    """A round cap, cap.npz, and its boundary, curve.npy."""
    points, faces = discs.hexagonal(4)
    x = discs.round_cap(points, 1.0)
    metric = PolyhedralMetric.from_mesh(x, faces)
    write_metric("cap.npz", metric)
    np.save("curve.npy", x[metric.triangulation.boundaries[0]])
    np.save("start.npy", x)
    return metric


def test_boundaries(call, cap):
    for condition in ("plane", "free", "curve.npy"):
        status, out, _ = call("embed", "cap.npz", "--boundary", condition, "--json")
        report = strict(out)
        assert (status, report["status"], report["method"]) == (0, "converged", "sheet")
        assert report["residual"]["max"] < 1e-12
        assert report["sheet"]["boundaries"] == [24]
        assert (report["volume"] is None) == (condition == "free")
    status, out, _ = call("embed", "cap.npz", "--boundary", "free", "--start", "start.npy")
    assert status == 0
    assert "boundary free, of 24 edges, genus 0" in out
    assert "volume" not in out


def test_a_mesh_gives_the_boundary_and_the_start(call, cap):
    """Its triangles may have another orientation and order."""
    x = np.load("start.npy")
    np.savez("truth.npz", vertices=x + 7.0, faces=cap.faces[::-1, ::-1])
    arguments = ("embed", "cap.npz", "--boundary", "truth.npz", "--start", "truth.npz", "-o", "found.npz")
    status, said, _ = call(*arguments)
    assert status == 0 and "\nint k1^2 + k2^2 dA " in said
    np.testing.assert_allclose(np.load("found.npz")["vertices"], x + 7.0, atol=1e-9)
    np.savez("other.npz", vertices=x, faces=cap.faces[1:])
    status, _, err = call("embed", "cap.npz", "--boundary", "other.npz")
    assert status == 2
    assert "is not in other.npz: --boundary takes a mesh of the same triangles" in err
    status, _, err = call("embed", "cap.npz", "truth.npz", "--boundary", "truth.npz", "-o", "folder")
    assert (status, err) == (2, "isoembed: error: the mesh truth.npz as --boundary is for a single input\n")


def test_files_and_pictures(call, cap):
    options = ("--boundary", "plane", "-o", "cap.ply", "--picture", "cap.png")
    assert call("embed", "cap.npz", *options)[0] == 0


def test_what_to_type_is_said(call, cap):
    assert "not closed; --boundary free is for such surfaces" in call("embed", "cap.npz")[2]
    assert (
        "the method 'sheet', not 'paper'"
        in call("embed", "cap.npz", "--boundary", "free", "--method", "paper")[2]
    )
    assert "none of 'free', 'plane'" in call("embed", "cap.npz", "--boundary", "flat")[2]
    Path("heights.txt").write_text("0\n0\n")
    assert "heights.txt is not a .npy file" in call("embed", "cap.npz", "--boundary", "heights.txt")[2]
    assert call("certify", "cap.npz", "cap.npz")[0] == 2


def test_inspection(call, cap):
    status, out, _ = call("inspect", "cap.npz")
    assert status == 0
    assert (
        "genus 0, 1 boundary of 24 edges; 21 motions keep the lengths: a boundary in a plane, at given "
        "heights or along a given curve fixes them, or least bending" in out
    )
    assert "sum = 2 pi to " in out
    assert "degree 3" not in out  # corners of the boundary
    surface = {"genus": 0, "boundaries": 1, "free_motions": 21}
    kinds = ["plane", "heights", "curve", "free"]
    assert json.loads(call("inspect", "cap.npz", "--json")[1])["surface"] == surface | {"fixed_by": kinds}


def test_conditions_that_suit(call):
    points, faces = discs.hexagonal(2)
    saddle = np.column_stack([points, points[:, 0] ** 2 - points[:, 1] ** 2])
    flat = np.column_stack([points, 0 * points[:, 0]])
    for name, mesh, fixed in (
        ("saddle.npz", (saddle, faces), ["curve", "free"]),
        ("flat.npz", (flat, faces), ["plane", "curve", "free"]),
        ("torus.npz", discs.torus(8, 6), []),
    ):
        write_metric(name, PolyhedralMetric.from_mesh(*mesh))
        assert json.loads(call("inspect", name, "--json")[1])["surface"]["fixed_by"] == fixed


def test_certificates(call, cap):
    assert call("embed", "cap.npz", "--boundary", "plane", "-o", "cap.ply")[0] == 0
    status, out, _ = call("certify", "cap.ply", "cap.npz", "--boundary", "plane")
    assert (status, "it is the convex cap" in out) == (0, True)
    status, out, _ = call("certify", "cap.ply", "cap.npz")
    assert (status, "in a family with 21 parameters" in out) == (0, True)
    np.save("heights.npy", np.arange(24.0))
    status, out, _ = call("certify", "cap.ply", "cap.npz", "--boundary", "heights.npy")
    assert (status, "misses its height" in out) == (3, True)
    np.save("heights.npy", np.arange(3.0))
    status, _, err = call("certify", "cap.ply", "cap.npz", "--boundary", "heights.npy")
    assert (status, "heights.npy has the shape (3,), not (24,)" in err) == (2, True)


def test_a_scan_in_single_precision_is_inspected(call):
    points, faces = discs.hexagonal(4)
    x = discs.round_cap(points, 1.0).astype(np.float32)
    np.savez("scan.npz", vertices=x, faces=faces)
    status, out, _ = call("inspect", "scan.npz")
    assert status == 0
    assert "rounded to" in out


def test_curvature_is_that_inside(call, cap):
    """Exterior angles of the boundary are no curvature."""
    status, out, _ = call("inspect", "cap.npz", "--json")
    found = strict(out)["gaussian_curvature"]
    assert status == 0
    assert 0.9 < found["min"] < found["max"] < 1.1


@pytest.mark.parametrize("options", [["--parameter", "a=1"], ["--length-error", "0.01"]])
def test_options_that_do_not_apply(call, cap, options):
    status, _, error = call("embed", "cap.npz", "--boundary", "free", *options)
    assert status == 2
    assert options[0] in error


def test_a_cap_within_errors(call, cap):
    status, out, _ = call("embed", "cap.npz", "--boundary", "plane", "--length-error", "1e-4", "--json")
    assert status == 0
    found = strict(out)
    assert found["sheet"]["condition"] == "plane" and 0 < found["deviation"]["area"] < 0.01 * found["area"]
    assert found["measured"]["chi_square"] <= found["measured"]["chi_square_limit"]
    status, _, error = call("embed", "cap.npz", "--method", "sheet", "--length-error", "1e-4")
    assert status == 2 and "--length-error with the method 'sheet' needs --boundary plane" in error


def test_errors_of_zero_go_with_any_boundary(call, cap):
    status, out, _ = call("embed", "cap.npz", "--boundary", "free", "--length-error", "0", "--json")
    assert status == 0 and "deviation" not in strict(out)
