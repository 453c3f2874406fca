"""What is seen of a run at one time."""

from isoembed.plot.series.placing import PlacedHorizons
from isoembed.plot.series.scenes import evenly, scenes
from series_results import embedded, missing

HERE, THERE = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)


def seen(results, most=100):
    return [
        (
            float(scene.moment.split()[-1]),
            [horizon.row.label for horizon in scene.shown],
            [row.label for row in scene.missing],
        )
        for scene in evenly(scenes(PlacedHorizons.of(results)), most)
    ]


def test_a_series_that_is_known_less_often_is_seen_in_between():
    often = [embedded("ah1", k, k, center=HERE) for k in range(9)]
    seldom = [embedded("ah2", k, k, center=THERE) for k in (0, 4)]
    found = seen(often + seldom)
    assert [labels[-1] for _, labels, _ in found] == ["ah2.t0"] * 3 + ["ah2.t4"] * 4 + ["ah1.t7", "ah1.t8"]


def test_what_is_lost_is_told_and_not_replaced_by_its_neighbors():
    results = [embedded("ah1", k, k, center=HERE) for k in (0, 1, 3)]
    results += [missing("ah1", 2, 2.0, "not embedded", "K < 0"), embedded("ah2", 2, 2.0, center=THERE)]
    assert seen(results)[2] == (2.0, ["ah2.t2"], ["ah1.t2"])


def test_a_run_begins_and_ends_with_an_embedded_horizon():
    lost = [missing("ah1", k, k, "failed", "killed") for k in (0, 2, 4)]
    found = seen([*lost, *(embedded("ah1", k, k) for k in (1, 3)), missing("ah1", None, None, "failed", "")])
    assert found == [(1, ["ah1.t1"], []), (2, [], ["ah1.t2"]), (3, ["ah1.t3"], [])]
    assert seen(lost) == []
    assert seen([]) == []


def test_of_many_times_evenly_many_are_taken():
    results = [embedded("ah1", k, k) for k in range(21)]
    assert [at for at, *_ in seen(results, 5)] == [0, 5, 10, 15, 20]


def test_horizons_around_others_are_shells_from_the_innermost_outward():
    inner = [embedded("ah1", 0, 0, center=HERE), embedded("ah2", 0, 0, center=THERE)]
    outer = embedded("ah3", 0, 0, center=(0, 0, 0), half_axes=(5, 4, 4))
    between = embedded("ah4", 0, 0, center=(0, 0, 0), half_axes=(4, 3, 3))
    (scene,) = scenes(PlacedHorizons.of([*inner, outer, between]))
    assert [shell.row.series for shell in scene.shells] == ["ah4", "ah3"]
