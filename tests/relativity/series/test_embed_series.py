"""Series from Python: what moments are, chunks, folders and executors."""

import os
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from horizons import shape_text
from isoembed.errors import InvalidParameter
from isoembed.relativity import (
    IsotropicSchwarzschild,
    KerrNewmanHorizon,
    Moment,
    StarSurface,
    SurfaceData,
    embed_series,
    find_horizon,
)
from isoembed.relativity.series import horizon_task
from isoembed.relativity.series.source import HeldShape
from isoembed.runs import Store
from isoembed.smooth import GridMetric, PulledBack
from slice_files import write_slice

SPHERE = StarSurface.sphere((0.0, 0.0, 0.0), 1.0)
TIMES = [0.0, 0.5]


def spinning_up(t):
    """The metric of a Kerr horizon on a grid."""
    return SurfaceData(GridMetric.sampled(KerrNewmanHorizon(1.0, 0.5 + 0.1 * t), 24, 1), marginal=True)


def moments():
    return [(t, spinning_up(t), None) for t in TIMES]


@pytest.fixture(scope="module")
def alone():
    """The results, one of which began from the other."""
    starts = []
    restored = horizon_task.Start.restored
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(horizon_task.Start, "restored", lambda arrays: starts.append(1) or restored(arrays))
        results = list(embed_series(iter(moments()), vertices=60))
    assert len(starts) == 1
    return results


def test_each_is_embedded_from_the_one_before(alone):
    assert [result.label for result in alone] == [f"horizon.T{t:g}" for t in TIMES]
    for t, result in zip(TIMES, alone, strict=True):
        assert result.report["moment"]["time"] == t
        area = KerrNewmanHorizon(1.0, 0.5 + 0.1 * t).area
        assert abs(result.report["area"] - area) <= result.report["errors"]["area"] < 1e-6


def test_what_was_interrupted_comes_to_the_same_bits(tmp_path, alone, monkeypatch):
    begun = embed_series(moments(), vertices=60, folder=tmp_path / "run")
    next(begun)
    begun.close()
    assert len(os.listdir(tmp_path / "run/results")) == 1
    computed = []
    embed_surface = horizon_task.embed_surface
    monkeypatch.setattr(
        horizon_task, "embed_surface", lambda *a, **o: computed.append(1) or embed_surface(*a, **o)
    )
    results = list(embed_series(moments(), vertices=60, folder=tmp_path / "run"))
    assert len(computed) == 1
    for result, other in zip(results, alone, strict=True):
        assert result.report == other.report
        for name, array in other.arrays.items():
            np.testing.assert_array_equal(result.arrays[name], array)
    assert len(list(Store(tmp_path / "run"))) == 2


@pytest.mark.slow
def test_an_executor_gives_the_same(alone):
    with ThreadPoolExecutor(1) as pool:
        results = {result.label: result for result in embed_series(moments(), vertices=60, executor=pool)}
    assert {label: result.report for label, result in results.items()} == {
        result.label: result.report for result in alone
    }


def test_a_failure_does_not_end_a_series(alone):
    first, second = moments()
    results = list(embed_series([first, (0.25, SPHERE, None), second], vertices=60))
    assert [result.status for result in results] == ["embedded", "refused", "embedded"]
    assert "name its geometry" in results[1].message
    # It starts from the first one.
    value, error = (results[2].report[key] for key in ("liu_yau", "errors"))
    assert abs(value - alone[1].report["liu_yau"]) <= error["liu_yau"] + alone[1].report["errors"]["liu_yau"]


def test_a_moment_is_taken_as_it_is():
    with pytest.warns(UserWarning, match=r"inner\.t7, is refused"):
        (found,) = embed_series([Moment("inner", 1.0, 7, HeldShape(SPHERE))], vertices=60)
    assert found.label == "inner.t7" and found.status == "refused"


@pytest.mark.parametrize(
    ("moment", "sentence"),
    [
        (3.0, r"moment 0 is a float, not a Moment or \(time, shape, geometry\)"),
        ((0.0, None), "moment 0 is a tuple, not a Moment"),
        ("abc", "moment 0 is a str, not a Moment"),
    ],
)
def test_what_is_no_moment(moment, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        next(embed_series([moment]))


@pytest.mark.parametrize(
    ("moment", "sentence"),
    [
        ((None, [1.0], None), "moment 0: expected a horizon, not list"),
        ((None, SPHERE, 1.0), "moment 0: expected a slice, not float"),
    ],
)
def test_what_is_no_horizon_and_no_slice(moment, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        next(embed_series([moment]))


def test_files_are_read_when_it_is_their_turn(tmp_path):
    geometry = IsotropicSchwarzschild(1.0)
    write_slice(tmp_path / "slice.npz", geometry, 1.0, 32)
    (tmp_path / "h.gp").write_text(shape_text(lambda u: np.full(len(u), 0.5)))
    (tmp_path / "bad.gp").write_text("# N_patches = 6\n# origin = 0 0 0\n")
    given = [
        (0.0, str(tmp_path / "h.gp"), tmp_path / "slice.npz"),
        (1.0, tmp_path / "bad.gp", geometry),
        (3.0, tmp_path / "no.gp", geometry),
        (4.0, SPHERE, tmp_path / "no.npz"),
    ]
    results = list(embed_series(given, vertices=60))
    assert [result.status for result in results] == ["embedded", "refused", "refused", "refused"]
    report = results[0].report
    assert abs(report["irreducible_mass"] - 1.0) <= report["errors"]["irreducible_mass"] < 1e-3
    assert report["name"] == str(tmp_path / "h.gp") == report["moment"]["shape"]
    assert report["moment"]["slice"] == str(tmp_path / "slice.npz")
    assert results[2].message == f"there is no file {tmp_path / 'no.gp'}"
    assert results[3].message == f"there is no file {tmp_path / 'no.npz'}"


def test_two_of_the_same_time():
    with pytest.raises(InvalidParameter, match=r"moment 1 has the label of an earlier one, horizon\.T0\.5"):
        list(embed_series([(0.5, SPHERE, None), (0.5, SPHERE, None)]))


def test_local_functions_are_kept_but_not_sent(tmp_path):
    sphere = SurfaceData(PulledBack(lambda u: np.broadcast_to(np.eye(3), (len(u), 3, 3))))
    given = [(0.0, sphere, None)]
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.warns(UserWarning, match="all horizons are refused or failed"),
    ):
        (found,) = embed_series(given, vertices=60, folder=tmp_path, executor=pool)
    assert found.status == "failed" and "cannot be sent to another process" in found.message
    assert next(embed_series(given, vertices=60, folder=tmp_path)).answered
    assert len(list(Store(tmp_path))) == 1


def test_a_horizon_that_was_found_with_its_slice():
    geometry = IsotropicSchwarzschild(1.0)
    horizon = find_horizon(geometry)
    results = list(embed_series([(0.0, horizon, geometry), (1.0, horizon, None)], vertices=60))
    for result in results:
        assert result.report["horizon"]["residual"] == horizon.residual
        assert abs(result.report["irreducible_mass"] - 1.0) < 1e-9


def test_a_series_of_refused_horizons_warns():
    with pytest.warns(
        UserWarning, match=r"all horizons are refused or failed; the first one, horizon\.T0, is refused: .*"
    ):
        (found,) = embed_series([(0.0, SPHERE, None)])
    assert found.report["notes"] == [] and "name its geometry" in found.message


def test_what_the_disk_does_not_take_is_said(tmp_path, monkeypatch):
    found = embed_series([(0.0, SPHERE, None)], folder=tmp_path)
    (tmp_path / "results").rmdir()
    with pytest.warns(UserWarning, match="cannot write"):
        assert next(found).status == "refused"
