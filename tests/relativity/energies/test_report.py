"""Reports of horizons that are found."""

from isoembed.relativity import (
    BrillLindquist,
    Horizon,
    IsotropicSchwarzschild,
    embed_series,
    energy_table,
    find_horizon,
    inner_horizon,
)


def test_the_text_says_whether_a_horizon_is_an_inner_one():
    one = find_horizon(IsotropicSchwarzschild(1.0))
    outer = Horizon.of(one, name="one hole")
    assert outer.facts["outer"] and abs(outer.facts["stability"] - 1.0) < 1e-9
    (found,) = embed_series([(None, one, None)], vertices=60)
    assert found.report["horizon"] == outer.facts
    shown = energy_table(found.report)
    assert "is 1 / R^2, R the areal radius: stable, as outermost horizons are" in shown
    pair = BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.35), (0.0, 0.0, -0.35)))
    inner = Horizon.of(inner_horizon(find_horizon(pair)))
    assert not inner.facts["outer"] and inner.facts["stability"] < 0.0 and inner.facts["marginal"]
    assert "unstable, and so not outermost" in energy_table({**found.report, "horizon": inner.facts})
