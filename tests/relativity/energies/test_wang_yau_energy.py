"""The Wang-Yau energy: closed forms of spheres, what is refused, reports, searches that fail."""

import json
from dataclasses import replace

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NoMinimum, NotEmbedded
from isoembed.relativity import KerrNewmanSphere, TimeFunction, wang_yau
from isoembed.relativity.energies import wang_yau_search
from isoembed.smooth import Harmonics, embed_smooth
from spacelike import directions, minkowski, nothing, round_sphere, static

EAST = np.sqrt(4.0 * np.pi / 3.0)  # times the harmonic of degree 1 is z


@pytest.fixture
def few_harmonics(monkeypatch):
    """Fewer harmonics of X than by default, which are enough here."""
    monkeypatch.setattr(wang_yau_search, "DEGREES", (12, 12))


def closed_form(r, b):
    """E(b r cos theta) on a sphere of Schwarzschild's spacetime, M = 1."""
    x, weights = np.polynomial.legendre.leggauss(200)
    f, g = np.sqrt(1.0 - 2.0 / r), np.sqrt(1.0 + b * b)
    W = np.sqrt(1.0 + b * b * (1.0 - x * x))
    physical = 2.0 * np.hypot(f * W, b * x) - 2.0 * b * x * np.arcsinh(b * x / (f * W))
    reference = g + np.arcsinh(b) / b if b else 2.0
    return (4.0 * np.pi * r * reference - 2.0 * np.pi * r * weights @ physical) / (8.0 * np.pi)


@pytest.mark.parametrize(
    ("r", "b", "expected"),
    [
        (4.0, 0.0, 1.171572875254),
        (4.0, 0.5, 1.327628657545),
        (4.0, 1.0, 1.711712605346),
        (4.0, 2.0, 2.755494723472),
        (1000.0, 1.0, 1.415039452595),
    ],
)
def test_spheres_in_closed_form(request, r, b, expected):
    if b <= 1.0:
        request.getfixturevalue("few_harmonics")
    data, embedding = static()
    if r != 4.0:
        data = round_sphere(r)
        embedding = embed_smooth(data.metric, vertices=100)
    found = wang_yau(data, lambda u: b * r * u[:, 2], embedding=embedding).energy
    assert closed_form(r, b) == pytest.approx(expected, rel=1e-12 * r)
    assert found.value == pytest.approx(closed_form(r, b), rel=1e-11 * r)
    assert abs(found.value - closed_form(r, b)) <= 3.0 * found.error + 1e-15 * r


@pytest.mark.usefixtures("few_harmonics")
def test_a_constant_has_no_consequences():
    data, embedding = static()
    one, other = (
        wang_yau(data, lambda u, c=c: 2.0 * u[:, 2] + c, embedding=embedding).energy.value
        for c in (0.0, 50.0)
    )
    assert one == pytest.approx(other, rel=1e-13)


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.slow
def test_inadmissible_time_functions(monkeypatch):
    data, embedding = static()

    def saddle(c):
        return TimeFunction.of(lambda u: c * u[:, 0] * u[:, 1], 2)

    monkeypatch.setattr(wang_yau_search, "SHORTEST_STEP", 0.03)
    with pytest.raises(
        NotEmbedded, match=r"is not embedded beyond 0.\d+ times the given tau: there K \+ det"
    ):
        wang_yau(data, saddle(4.8), embedding=embedding)
    # Just beyond: K < 0 at a few points, and X still follows.
    beyond = wang_yau(data, saddle(4.26), embedding=embedding)
    assert beyond.admissible < 0.0
    assert len(beyond.notes) == 1 and "tau is not admissible: K + det D^2 tau / W^2 is -" in beyond.notes[0]
    assert not wang_yau(data, saddle(2.0), embedding=embedding).notes


@pytest.mark.usefixtures("few_harmonics")
def test_refuses_data():
    data, embedding = static()
    k = data.mean_curvature(directions(1))[0]
    with pytest.raises(InvalidParameter, match="needs the mean curvature k of the surface"):
        wang_yau(replace(data, mean_curvature=None), embedding=embedding)
    large = replace(data, momentum=lambda u: -0.37 * u[:, 2])
    with pytest.raises(InvalidParameter, match=r"needs the normal_momentum K\(., n\), too"):
        wang_yau(large, embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"^k = 0.3536 does not exceed \|p\| = 0.36\d* at theta = 3\."):
        wang_yau(replace(large, normal_momentum=nothing), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"k = -0.3536 does not exceed .* spacelike, outward"):
        wang_yau(replace(data, mean_curvature=lambda u: np.full(len(u), -k)), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"the mean curvature in the direction .* is nan"):
        wang_yau(replace(data, mean_curvature=lambda u: np.full(len(u), np.nan)), embedding=embedding)


@pytest.mark.parametrize("tau", [3, "best", ("optimal",)])
def test_refuses_what_is_no_time_function(tau):
    data, embedding = static()
    with pytest.raises(InvalidParameter, match='not a TimeFunction, an array, a function, "optimal" or None'):
        wang_yau(data, tau, embedding=embedding)


@pytest.mark.usefixtures("few_harmonics")
def test_report_is_plain():
    data, embedding = static()
    found = wang_yau(data, lambda u: 2.0 * u[:, 2], embedding=embedding)
    report = json.loads(json.dumps(found.report, allow_nan=False))
    assert report["wang_yau"] == found.energy.value
    assert report["error"] == found.energy.error < 1e-9
    assert report["least_second_derivative"] is None
    assert report["embeddings"] == found.embeddings >= 2
    largest = max(report["tau"], key=lambda term: abs(term["coefficient"]))
    assert (largest["degree"], largest["order"]) == (1, 0)
    assert largest["coefficient"] == pytest.approx(2.0 * EAST, rel=1e-13)
    assert len(report["tau"]) == found.tau.harmonics.size - 1


@pytest.mark.usefixtures("few_harmonics")
def test_an_array_holds_coefficients():
    data, embedding = static()
    tau = TimeFunction.of(lambda u: 2.0 * u[:, 2], 2)
    one, other = (wang_yau(data, t, embedding=embedding) for t in (tau, tau.coefficients))
    assert one.energy == other.energy
    with pytest.raises(InvalidParameter, match=r"have the shape \(5,\), not \(\(L \+ 1\)\^2,\)"):
        wang_yau(data, np.zeros(5), embedding=embedding)
    with pytest.raises(InvalidParameter, match=r"9 harmonics require as many coefficients, not \(4,\)"):
        TimeFunction(Harmonics(2, 2), np.zeros(4))


@pytest.mark.parametrize("degrees", [(), (0,), (2, -1)])
def test_degrees_that_are_none(degrees):
    data, embedding = static()
    with pytest.raises(InvalidParameter, match=r"the degrees of tau are .*: there must be at least one"):
        wang_yau(data, "optimal", embedding=embedding, degrees=degrees)


@pytest.mark.usefixtures("few_harmonics")
def test_one_degree_has_an_error_too():
    data, embedding = static()
    found = wang_yau(data, "optimal", embedding=embedding, degrees=(1,))
    assert np.isfinite(found.energy.error)
    json.dumps(found.report, allow_nan=False)


@pytest.mark.usefixtures("few_harmonics")
@pytest.mark.slow
def test_a_search_that_ends_too_early_is_no_minimum(monkeypatch):
    _, data, embedding = minkowski()
    monkeypatch.setattr(wang_yau_search, "MAX_ITERATIONS", 1)
    with pytest.raises(NoMinimum, match=r"the search ended at E = .* the predicted decrease"):
        wang_yau(data, "optimal", embedding=embedding, degrees=(2,))


def test_a_degree_that_does_not_resolve_the_surface(monkeypatch):
    monkeypatch.setattr(wang_yau_search, "DEGREES", (4, 4))
    with pytest.raises(NotEmbedded, match="harmonics up to degree 4 have an error"):
        wang_yau(KerrNewmanSphere(1.7, 1.0, 0.95).data())
