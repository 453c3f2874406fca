"""``--length-error`` of commands that embed: error bars of what is integrated."""

import csv
from pathlib import Path

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.cli.summary import measure
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import write_metric
from isoembed.relativity import mesh_deviation
from rocks import in_millimeters, rock
from strict_json import strict

BARS = ("area", "volume", "integrated_mean_curvature")


@pytest.fixture
def metric():
    """An ellipsoid, m.npz."""
    found = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3.0, 2.0, 1.0)), 50))
    write_metric("m.npz", found)
    return found


def test_report_and_summary(call, metric):
    status, out, err = call("embed", "m.npz", "--length-error", "1e-4", "--report", "r.json")
    sigma = isoembed.Sensitivity(isoembed.embed(metric, length_errors=1e-4)).integral_deviation(1e-4)
    assert (status, err) == (0, "")
    for name in BARS:
        assert f" +- {getattr(sigma, name):.2g}" in out
    report = strict(Path("r.json").read_text())
    assert report["deviation"] == pytest.approx({"length_error_rms": 1e-4, **sigma.report}, rel=1e-6)
    plain = strict(call("embed", "m.npz", "--json")[1])
    assert plain.keys() | {"deviation", "measured"} == report.keys()
    assert not {"deviation", "measured"} & plain.keys()


def test_errors_of_each_edge_and_the_page(call, metric):
    errors = np.linspace(1e-5, 1e-3, len(metric.lengths))
    np.save("e.npy", errors)
    assert call("embed", "m.npz", "--length-error", "e.npy", "--html", "p.html", "--report", "r.json")[0] == 0
    found = strict(Path("r.json").read_text())["deviation"]
    assert found["length_error_rms"] == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert "length error rms" in Path("p.html").read_text(encoding="utf-8")
    errors[3] = 0
    np.save("e.npy", errors)
    status, _, err = call("embed", "m.npz", "--length-error", "e.npy")
    assert status == 2 and "the length error of edge 3" in err


def test_zero_insists_on_the_digits(call):
    """Lengths in whole millimeters, for which the exact surface is crumpled, as the default answer is not."""
    vertices, faces = rock([102, 80])
    write_metric("rock.npz", in_millimeters(vertices, faces))
    exact = strict(call("embed", "rock.npz", "--length-error", "0", "--json")[1])
    assert "measured" not in exact and exact["residual"]["max"] < 1e-10
    assert strict(call("embed", "rock.npz", "--json")[1])["measured"]["chi_square"] > 1e-3


def test_suspects_have_a_line(call):
    """The exact surface of lengths with a blunder is returned, and a closing line says what to check."""
    metric = in_millimeters(*rock(2, rough=0.5))
    lengths = metric.lengths.copy()
    lengths[30] += 30.0
    write_metric("rock.npz", metric.with_lengths(lengths))
    status, out, _ = call("embed", "rock.npz", "-o", "s.ply")
    assert status == 0
    assert "check these lengths first" in out.splitlines()[1]


def test_several_files(call, metric):
    write_metric("n.npz", metric)
    assert call("embed", "m.npz", "n.npz", "-o", "all", "--length-error", "1e-4", "--jobs", "1")[0] == 0
    sigma = isoembed.Sensitivity(isoembed.embed(metric, length_errors=1e-4)).integral_deviation(1e-4)
    assert strict(Path("all/n.json").read_text())["deviation"]["volume"] == pytest.approx(sigma.volume)
    with open("all/table.csv", newline="", encoding="utf-8") as file:
        row = next(csv.DictReader(file))
    for name in BARS:
        assert float(row[f"{name}_deviation"]) == pytest.approx(getattr(sigma, name))
    assert 0 < float(row["chi_square"]) < len(metric.lengths)
    np.save("e.npy", np.zeros(len(metric.lengths)))
    status, _, err = call("embed", "m.npz", "n.npz", "-o", "all", "--length-error", "e.npy")
    assert (status, err) == (2, "isoembed: error: --length-error must be a number for several files\n")


def test_energies(call, metric):
    np.save("k.npy", np.full(50, 1.5))
    given = ("energy", "m.npz", "--mean-curvature", "k.npy", "--lengths", "chord", "--length-error", "1e-4")
    sigma = mesh_deviation(isoembed.embed(metric), 1e-4, np.full(50, 1.5), lengths="chord")
    status, out, err = call(*given)
    assert (status, err) == (0, "")
    assert f", +- {sigma['brown_york']:.1e} by the lengths\n" in out
    report = strict(call(*given, "--json")[1])
    known = {name: value for name, value in report["deviation"].items() if value is not None}
    assert known == pytest.approx({name: value for name, value in sigma.items() if value is not None})
    assert "deviation" not in strict(call(*given[:-2], "--json")[1])


def test_a_flat_vertex(call):
    x, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    split = np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])
    flat = np.vstack([x, x[faces[0]].mean(axis=0)])
    write_metric("flat.npz", isoembed.PolyhedralMetric.from_mesh(flat, split))
    status, out, _ = call("embed", "flat.npz", "--length-error", "1e-4")
    assert status == 0
    assert "+- not determined: the surface is not infinitesimally rigid" in out
    exact = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(flat, split))
    assert isoembed.Sensitivity(exact).integral_deviation(1e-4).volume == np.inf
    status, _, err = call("energy", "flat.npz", "--length-error", "1e-4")
    assert status == 2 and "the surface of flat.npz is not infinitesimally rigid" in err


@pytest.mark.parametrize(
    ("given", "sentence"),
    (
        (("1e-4", "--best-fit"), "--length-error does not go with --best-fit"),
        (("-1",), "the length error of edge 0"),
        (("much",), "--length-error much is neither a number nor a .npy file"),
    ),
)
def test_what_is_refused(call, metric, given, sentence):
    status, out, err = call("embed", "m.npz", "--length-error", *given)
    assert (status, out) == (2, "") and sentence in err


def test_smooth_surfaces_have_no_lengths(call):
    status, _, err = call("energy", "--spacetime", "kerr", "--surface", "sphere", "--length-error", "1")
    assert status == 2 and "--length-error does not go with a --spacetime" in err


def test_the_report_is_made_once(call, metric, monkeypatch):
    """Error bars in the report and in the closing lines are the same numbers."""
    made = []
    own = isoembed.Sensitivity.integral_deviation
    monkeypatch.setattr(
        isoembed.Sensitivity, "integral_deviation", lambda *given: made.append(given) or own(*given)
    )
    arguments = "--length-error", "1e-4", "-o", "s.ply", "--report", "r.json", "--verbose"
    assert call("embed", "m.npz", *arguments)[0] == 0
    assert len(made) == 1


def test_numbers_with_an_infinite_deviation():
    assert (
        measure({"volume": 2.0, "deviation": {"volume": None, "volume_nonlinearity": None}}, "volume")
        == "2 +- not determined: the surface is not infinitesimally rigid"
    )
    undetermined = {"volume": 6996620.69941, "deviation": {"volume": None, "volume_nonlinearity": 0.8}}
    assert measure(undetermined, "volume") == (
        "7e+06 +- not determined: the errors of the lengths, or one of them, are too large for a first-order "
        "estimate"
    )
    assert measure({"volume": 2.123456, "deviation": {"volume": 0.012}}, "volume") == "2.123 +- 0.012"
    assert measure({"volume": None, "deviation": {"volume": 1.0}}, "volume").endswith(" +- 1")
    assert measure({"volume": 2.0}, "volume") == "2"
