"""All methods on the same triangles."""

import numpy as np
import pytest

from isoembed import InvalidParameter
from isoembed.gallery import KerrHorizon
from isoembed.relativity import KerrNewmanHorizon
from reproduction.baselines.__main__ import main
from reproduction.baselines.subjects import Subject
from reproduction.baselines.table import COLUMNS, compare, run_table

KERR = Subject("Kerr", KerrNewmanHorizon(mass=1.0, spin=0.5), KerrHorizon(spin=0.5).point)


def test_the_table_measures_all_methods_on_the_same_triangles():
    runs = compare([KERR], vertices=100, degree=6, steps=4)
    assert len({run.method for run in runs}) == len(runs) == 9
    i, j = runs[0].problem.metric.edges.T
    lengths = runs[0].problem.metric.lengths
    for run in runs:
        x = run.surface.vertices
        errors = np.abs(np.linalg.norm(x[i] - x[j], axis=1) - lengths)
        assert run.surface.residual == pytest.approx(errors.max() / lengths.mean(), rel=1e-6, abs=1e-14)
    assert {len(row) for row in run_table("all", runs).rows} == {len(COLUMNS)}
    by_method = {run.method: run for run in runs}
    assert by_method["(true surface)"].numbers["distance"] < 1e-14
    for method in ("isoembed, aim", "isoembed, paper"):
        assert by_method[method].note == "the true surface"
    for method in ("harmonics, from a sphere", "embedding flow", "isoembed, aim and harmonics"):
        assert by_method[method].numbers["distance"] < 1e-3


def test_too_few_vertices_for_the_harmonics_are_refused():
    with pytest.raises(
        InvalidParameter, match="60 vertices are too few for the 49 harmonics of degree 6: 98"
    ):
        compare([KERR], vertices=60, degree=6, steps=1)


@pytest.mark.slow
def test_the_table_is_printed(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["baselines", "--vertices", "50", "--degree", "4", "--steps", "1"])
    main()
    rows = capsys.readouterr().out.splitlines()
    assert len(rows) == 2 + 4 * 9
    assert all(row.count("|") == rows[0].count("|") for row in rows)
