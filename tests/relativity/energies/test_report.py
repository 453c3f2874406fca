"""Reports of horizons that are found."""

from dataclasses import replace

from isoembed.relativity import (
    BrillLindquist,
    Horizon,
    IsotropicSchwarzschild,
    embed_horizons,
    find_horizon,
    inner_horizon,
)


def test_the_text_says_whether_a_horizon_is_an_inner_one():
    outer = Horizon.found(find_horizon(IsotropicSchwarzschild(1.0)), name="one hole")
    assert outer.facts["outer"] and abs(outer.facts["stability"] - 1.0) < 1e-9
    (found,) = embed_horizons([outer], vertices=60)
    assert found.report["horizon"] == outer.facts
    assert "is 1 / R^2, R the areal radius: stable, as outermost horizons are" in str(found)
    pair = BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.35), (0.0, 0.0, -0.35)))
    inner = Horizon.found(inner_horizon(find_horizon(pair)))
    assert not inner.facts["outer"] and inner.facts["stability"] < 0.0 and inner.facts["marginal"]
    other = replace(found, report={**found.report, "horizon": inner.facts})
    assert "unstable: an inner horizon" in str(other)
