"""Reports of horizons that are found, and of the parts of J where there is a charge."""

import re
from dataclasses import replace

import pytest

from isoembed.relativity import (
    BrillLindquist,
    IsotropicSchwarzschild,
    KerrNewmanHorizon,
    embed_series,
    embed_surface,
    energy_table,
    find_horizon,
    horizon_data,
    inner_horizon,
)


def test_the_text_says_whether_a_horizon_is_an_inner_one():
    one = find_horizon(IsotropicSchwarzschild(1.0))
    outer = horizon_data(one, name="one hole")[1].report
    assert outer["outer"] and abs(outer["stability"] - 1.0) < 1e-9
    (found,) = embed_series([(None, one, None)], vertices=60)
    assert found.report["horizon"] == outer
    shown = energy_table(found.report)
    assert "is 1 / R^2, R the areal radius: stable, as outermost horizons are" in shown
    pair = BrillLindquist((0.5, 0.5), ((0.0, 0.0, 0.35), (0.0, 0.0, -0.35)))
    inner = horizon_data(inner_horizon(find_horizon(pair)))[1].report
    assert not inner["outer"] and inner["stability"] < 0.0 and inner["marginal"]
    assert "unstable, and so not outermost" in energy_table({**found.report, "horizon": inner})


def test_the_parts_of_the_angular_momentum_of_a_charged_horizon():
    report = embed_surface(KerrNewmanHorizon(1.0, 0.4, 0.8).data()).report
    spin, shown = report["spin"], energy_table(report)
    assert spin["total"] == pytest.approx(0.4, abs=1e-12)
    assert spin["J"] + spin["electromagnetic"] == spin["total"] and spin["electromagnetic"] > 0.1
    assert re.search(
        r"\nJ of K_ij +0\.28\d+ .*\nJ electromagnetic +0\.119\d+ .*\nangular momentum J +0\.[34]", shown
    )
    assert report["notes"] == []


def test_an_electromagnetic_part_that_is_not_known():
    horizon = KerrNewmanHorizon(1.0, 0.4, 0.8).data()
    known = replace(horizon, angular_momentum=None)
    assert embed_surface(known).energies.dimensionless_spin.value == pytest.approx(0.4, abs=1e-12)
    found = embed_surface(replace(known, electromagnetic_angular_momentum=None))
    assert found.report["spin"]["total"] is None
    assert re.search("\nJ electromagnetic +not known\n", energy_table(found.report))
    (note,) = found.energies.notes
    assert note.startswith("the electromagnetic part of J is unknown")
    assert "electromagnetic" not in embed_surface(KerrNewmanHorizon(1.0, 0.4).data()).report["spin"]
