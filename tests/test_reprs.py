"""Results are short in a prompt, and tables in a notebook."""

from dataclasses import dataclass

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import relativity
from isoembed.reprs import rounded_down, rounded_up, short_repr
from isoembed.smooth import AngleMetric, embed_smooth
from isoembed.surface.estimate import Estimate


@short_repr
@dataclass
class Result:
    x: object
    y: object = None


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1 / 3, "0.333333"),
        (3, "3"),
        (True, "True"),
        (np.zeros((7, 3)), "array of shape (7, 3)"),
        (np.array([1.0, 0.5]), "[1, 0.5]"),
        ((0.0, 1.0, 2.0), "(0, 1, 2)"),
        ([np.zeros(9)] * 5, "5 entries"),
        (Estimate(1.0, 1e-3), "1.000 +- 1e-03"),
        ("a" * 99, "'" + "a" * 57 + "'..."),
        (Result(np.zeros(9)), "Result(x=array of shape (9,))"),
    ],
)
def test_values_in_a_few_characters(value, shown):
    assert repr(Result(value)) == f"Result(x={shown})"


def test_what_is_not_there_is_left_out():
    assert repr(Result(None, ())) == "Result()"
    assert repr(Result(len, "b")) == "Result(y='b')"


def test_tables_are_escaped():
    assert '<td style="text-align: left">&#x27;&lt;b&gt;&#x27;</td>' in Result("<b>")._repr_html_()


def test_results_of_relativity():
    data = relativity.KerrNewmanHorizon(mass=1.0, spin=0.5).data()
    found = relativity.embed_surface(data)
    assert repr(found).startswith(
        "EmbeddedSurface(name='Kerr-Newman horizon of mass 1, spin 0.5, charge 0', "
    )
    for result in (found, found.energies, found.spin, found.data, found.embedding):
        assert len(repr(result)) < 400
    sphere = embed_smooth(AngleMetric(lambda theta, phi: (1.0, 0.0, np.sin(theta) ** 2)))
    assert "residual=" in repr(sphere) and "integrated_mean_curvature=12.56637061" in repr(sphere)
    grid = relativity.CartesianGrid(
        (0, 0, 0), 0.5, np.tile(np.eye(3)[:, :, None, None, None], (1, 1, 8, 9, 10))
    )
    assert (
        repr(grid)
        == "CartesianGrid(origin=(0, 0, 0), spacing=(0.5, 0.5, 0.5), gamma=array of shape (6, 8, 9, 10))"
    )
    table = found._repr_html_()
    assert table.count("<table>") == 2
    assert "hawking" in table and "brown york" in table


def test_results_on_surfaces():
    surface = isoembed.embed(zoo.random_hull(30, seed=1))
    for result in (
        isoembed.certify(surface),
        isoembed.Sensitivity(surface).deviation(1e-3),
        isoembed.Sensitivity(surface).deviation_bound(1e-12),
        isoembed.Sensitivity(surface).integral_deviation(1e-3),
        isoembed.compare(surface, surface),
        isoembed.Sensitivity(surface).variation(surface.metric.lengths),
    ):
        assert len(repr(result)) < 400
        assert result._repr_html_().startswith("<table>")


@pytest.mark.parametrize("value", [1.0, 2.3e-7, 9.99e-5, 0.0401])
@pytest.mark.parametrize("digits", [1, 2])
def test_numbers_are_rounded_outward(value, digits):
    text = rounded_up(value, digits)
    assert value <= float(text) < (1 + 1.01 * 10 ** (1 - digits)) * value
    assert value >= float(rounded_down(value, digits)) > (1 - 1.01 * 10 ** (1 - digits)) * value
    assert len(text.split("e")[0].replace(".", "")) == digits
