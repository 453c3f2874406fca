"""The examples write files of simulations, and what comes out of these agrees with closed forms."""

import importlib
import os
import runpy
import sys

import numpy as np
import pytest

from isoembed.relativity import embed_series, moments
from isoembed.relativity.series.carpet_files import carpet_slices
from isoembed.relativity.series.matching import matched
from isoembed.relativity.series.shape_files import shapes_in_files
from places import ROOT

pytest.importorskip("h5py")
MASSES = {0.5: 0.998248418}  # of the common horizon, by shooting, by the distance
LIU_YAU = {0.5: 2.01920982}


@pytest.fixture
def example(monkeypatch):
    """An example by its name."""
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    return importlib.import_module


def within(report, name, exact, largest):
    assert abs(report[name] - exact) <= report["errors"][name] <= largest


def listed(folder, layout):
    """Moments of what was written."""
    shapes = sorted(folder.glob("h.*.gp"))
    if layout == "carpet":  # a simulation in a folder takes kuibit
        return matched(shapes_in_files(shapes), carpet_slices(folder.iterdir()))
    geometry = {"files": folder / "slices/slice.{iteration}.h5", "axis": folder / "slices.h5"}
    return moments(shapes, str(geometry[layout]))


def check_kerr(report, a):
    """Of a Kerr hole of mass 1 on a grid."""
    spin = float(np.linalg.norm(a))
    r = 1.0 + np.sqrt(1.0 - spin**2)
    within(report, "area", 4.0 * np.pi * (r**2 + spin**2), 0.1)
    within(report, "christodoulou_mass", 1.0, 2e-3)
    assert np.linalg.norm(np.array(report["spin"]["vector"]) - a) < 2e-3
    assert report["horizon"]["marginal"]


@pytest.mark.parametrize(
    ("layout", "files"),
    [
        ("files", ["BH_diagnostics.ah1.gp", "h.t0.ah1.gp", "h.t800.ah1.gp", "slices"]),
        ("axis", ["BH_diagnostics.ah1.gp", "h.t0.ah1.gp", "h.t800.ah1.gp", "slices.h5"]),
        ("carpet", ["BH_diagnostics.ah1.gp", "gxx.xyz.h5", "h.t0.ah1.gp", "h.t800.ah1.gp", "kzz.xyz.h5"]),
    ],
)
def test_files_of_a_precessing_hole(example, tmp_path, layout, files):
    spins = example("precessing_hole").write(tmp_path, 2, layout, spacing=0.2)
    assert set(files) <= set(os.listdir(tmp_path))
    there = listed(tmp_path, layout)
    assert [(moment.time, moment.iteration) for moment in there] == [(0.0, 0), (100.0, 800)]
    exact = example("isoembed.relativity").KerrSchild(1.0, spins[800])
    x = np.array([[1.9, 0.5, 0.2], [0.1, -0.5, 1.9]])
    read = there[1].slice.read(x.min(axis=0), x.max(axis=0))
    np.testing.assert_allclose(read.metric(x), exact.metric(x), atol=1e-3)
    np.testing.assert_allclose(read.extrinsic_curvature(x), exact.extrinsic_curvature(x), atol=1e-3)


@pytest.mark.slow
def test_a_precessing_hole_from_end_to_end(example, tmp_path):
    spins = example("precessing_hole").write(tmp_path, 3, "axis", spacing=0.2)
    results = list(embed_series(listed(tmp_path, "axis"), vertices=60))
    assert [result.label for result in results] == ["ah1.t0", "ah1.t400", "ah1.t800"]
    for result in results:
        check_kerr(result.report, spins[result.report["moment"]["iteration"]])


def test_horizons_of_a_pair(example):
    """A common one appears at d = 0.766197428."""
    pair = example("approaching_pair")
    assert pair.Pair.at(0.0) == pair.Pair(0.9, 0.0)
    assert abs(pair.Pair.at(pair.DURATION).distance - 0.5) < 1e-12
    for distance, names in ((0.7663, ["ah1", "ah2"]), (0.7661, ["ah1", "ah2", "ah3"])):
        one = pair.Pair(distance, 0.8)
        surfaces = one.horizons()
        assert list(surfaces) == names
        for name, surface in surfaces.items():
            u = np.random.default_rng(1).normal(size=(50, 3))
            u /= np.linalg.norm(u, axis=1)[:, None]
            assert np.abs(surface.expansion(one.geometry, u)).max() < 1e-6, name


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["files", "carpet"])
def test_a_pair_from_end_to_end(example, tmp_path, layout):
    pairs = example("approaching_pair").write(tmp_path, 2, layout, spacings=(0.025, 0.0125))
    results = {result.label: result for result in embed_series(listed(tmp_path, layout), vertices=60)}
    assert list(results) == ["ah1.t0", "ah1.t2048", "ah2.t0", "ah2.t2048", "ah3.t2048"]
    assert all(result.status == "embedded" for result in results.values())
    common = results["ah3.t2048"].report
    within(common, "irreducible_mass", MASSES[0.5], 1e-5)
    within(common, "liu_yau", LIU_YAU[0.5], 1e-4)
    for label in ("ah1.t0", "ah2.t0"):
        surface = pairs[0].horizons()[label[:3]]
        exact = surface.data(pairs[0].geometry, marginal=True)
        area = example("isoembed.relativity").embed_surface(exact, vertices=60).energies.area.value
        within(results[label].report, "area", area, 1e-2 * area)


@pytest.mark.parametrize("name", ["approaching_pair", "precessing_hole"])
def test_the_scripts_say_what_they_take(name, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    with pytest.raises(SystemExit, match="0"):
        runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    assert "isoembed series FOLDER" in capsys.readouterr().out
