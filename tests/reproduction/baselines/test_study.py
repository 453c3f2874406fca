"""The section on the cited methods."""

import pytest

from reproduction.baselines.study import study


@pytest.mark.slow
def test_the_section_has_a_row_for_every_run_and_its_figures(monkeypatch):
    monkeypatch.setattr("reproduction.baselines.study.SIZES", (0.3,))
    monkeypatch.setattr("reproduction.baselines.study.HALVINGS", 3)
    section = study(vertices=60, degree=4, steps=2, seeds=1)
    runs, starts, bent = section.tables
    assert len(runs.rows) == 36
    assert len(starts.rows) == 4
    assert len(bent.rows) == 2
    assert {len(row) for row in runs.rows} == {len(runs.header)}
    assert [one.name for one in section.figures] == ["baselines-convergence", "baselines-surfaces"]
    for one in section.figures:
        one.figure.canvas.draw()
