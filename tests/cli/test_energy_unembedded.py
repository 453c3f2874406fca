"""``isoembed energy`` of what does not embed: its band, and the best fit."""

import os
from functools import partial

import numpy as np
import pytest

from isoembed.smooth import solve
from strict_json import strict


@pytest.fixture
def run(call):
    """Call ``isoembed energy`` in an empty folder."""
    return partial(call, "energy")


def kerr(surface, spin, *more):
    return ["--spacetime", "kerr", "--spin", spin, "--surface", surface, "--vertices", 60, *more]


def check(found, **exact):
    """Every number is within its error, and its error is small."""
    for name, value in exact.items():
        if value is None:
            assert found[name] is None
        else:
            assert abs(found[name] - value) <= found["errors"][name] <= 1e-10 * max(1.0, value)


@pytest.fixture
def few(monkeypatch):
    """Fewer degrees: more do not help here."""
    monkeypatch.setattr(solve, "DEGREES", (8, 12, 16))


def test_beyond_smarrs_limit(run):
    """With all degrees that there are."""
    status, out, err = run(*kerr("horizon", 0.9, "--json", "-o", "a.vtk"))
    assert status == 3 and os.listdir() == []
    assert err.startswith("isoembed: error: no surface of revolution has this metric for theta < 0.561403")
    assert "84.6509 % of the area" in err.splitlines()[0]
    found = strict(out)
    assert found["status"] == "not embedded" and found["message"] in err
    assert found["evidence"] == "searched"
    assert found["basis"].startswith(
        "only surfaces of revolution were considered, and it is proved that none has"
    )
    assert found["brown_york"] is found["liu_yau"] is found["integrated_mean_curvature"] is None
    r = 1.0 + np.sqrt(1.0 - 0.81)
    check(found, dimensionless_spin=0.9)
    spin = found["spin"]
    assert abs(spin["J"] - 0.9) <= spin["error"] <= 1e-12
    assert np.hypot(*spin["axis"][:2]) <= spin["axis_error"] <= 1e-12
    assert spin["method"].endswith("symmetric about this axis")
    check(
        found, area=4.0 * np.pi * (r**2 + 0.81), christodoulou_mass=1.0, hawking=np.sqrt((r**2 + 0.81) / 4.0)
    )


def test_in_text_too(run, few):
    status, out, err = run(*kerr("horizon", 0.9))
    assert status == 3 and err.startswith("isoembed: error: no surface of revolution")
    assert err.splitlines()[1:] == [
        "isoembed: try: --space hyperbolic, which embeds the whole surface",
        "isoembed: try: --band FILE, which writes the band that embeds",
    ]
    assert "irreducible mass" in out and "Brown-York" not in out


def test_the_band_that_embeds_is_written(run, few):
    status, _, err = run(*kerr("horizon", 0.9, "--band", "band.npz", "-o", "whole.npz"))
    assert status == 3 and "whole.npz not written: there is no surface" in err
    assert os.listdir() == ["band.npz"]
    with np.load("band.npz") as archive:
        vertices, faces = archive["vertices"], archive["faces"]
    corners = vertices[faces]
    areas = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    )
    r = 1.0 + np.sqrt(1.0 - 0.81)
    assert areas.sum() == pytest.approx(0.846509 * 4.0 * np.pi * (r**2 + 0.81), rel=5e-3)
    a, b, c = np.sort(faces, axis=1).T
    _, counts = np.unique(np.concatenate([np.c_[a, b], np.c_[b, c], np.c_[a, c]]), axis=0, return_counts=True)
    assert set(counts) == {1, 2}  # it has a boundary


def test_the_best_fit(run, few):
    status, out, err = run(*kerr("horizon", 0.9, "--best-fit", "--json", "-o", "fit.vtk"))
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["status"] == "best fit" and os.listdir() == ["fit.vtk"]
    assert any("a best fit, not an embedding" in note for note in found["notes"])
    assert found["errors"]["brown_york"] > 1e-8
