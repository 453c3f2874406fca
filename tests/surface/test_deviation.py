"""Standard deviations of surfaces, against surfaces whose lengths have random errors."""

import numpy as np
import pytest

import isoembed
import solids
import zoo
from isoembed.embedding.fitted import FittedSurface
from isoembed.errors import InvalidParameter
from isoembed.gallery import CassiniPeanut, Ellipsoid, triangulate
from isoembed.linalg import SingularMatrix
from isoembed.surface import deviation
from isoembed.surface.rigidity import LengthSystem
from noisy import ARRAYS, SCALARS, differences, realized, surface


@pytest.mark.parametrize(
    "body", [CassiniPeanut(), pytest.param(Ellipsoid((3.0, 2.0, 1.0)), marks=pytest.mark.slow)]
)
def test_a_hundred_noises_are_within_two_sigma(body):
    found, rng = surface(body, 100), np.random.default_rng(5)
    errors = 1e-7 * rng.uniform(0.3, 3, len(found.metric.lengths))
    sigma, system = isoembed.Sensitivity(found).deviation(errors), LengthSystem(found.triangulation)
    within = {name: [] for name in (*ARRAYS, *SCALARS)}
    for _ in range(100):
        lengths = found.metric.lengths + errors * rng.standard_normal(len(errors))
        for name, change in differences(found, realized(found, system, lengths)).items():
            within[name].append(np.abs(change) <= 2 * getattr(sigma, name))
    for name, inside in within.items():
        assert 0.90 <= np.mean(inside) <= 0.99, name


def test_estimate_with_random_signs(monkeypatch):
    found = surface(Ellipsoid((3.0, 2.0, 1.0)), 100)
    exact = isoembed.Sensitivity(found).deviation(1e-3)
    monkeypatch.setattr(deviation, "PROBES", 200)
    rough = isoembed.Sensitivity(found).deviation(1e-3)
    assert (exact.relative_error, rough.relative_error) == (0, 0.05)
    for name in ARRAYS:
        ratio = getattr(rough, name) / getattr(exact, name)
        assert 0 < np.sqrt(np.mean((ratio - 1) ** 2)) < 1.2 * rough.relative_error
    assert [getattr(rough, name) for name in SCALARS] == [getattr(exact, name) for name in SCALARS]


def test_regular_tetrahedron():
    found = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*zoo.tetrahedron()))
    [l, *_], s = found.metric.lengths, 1e-3
    sigma, six = isoembed.Sensitivity(found).deviation(s), np.sqrt(6) * s
    assert np.isclose(sigma.area, six * found.area / (3 * l))
    assert np.isclose(sigma.volume, six * found.volume / (2 * l))
    assert np.isclose(sigma.integrated_mean_curvature, six * (np.pi - np.arccos(1 / 3)) / 2)
    assert np.allclose(sigma.correlation, 1)
    for name in ARRAYS:
        assert np.ptp(getattr(sigma, name)) < 1e-12 * getattr(sigma, name).max()


def test_equal_rounded_lengths_of_a_tetrahedron_have_one_error():
    tetrahedron, _ = zoo.tetrahedron()
    vertices = tetrahedron * 1.2345 / np.linalg.norm(tetrahedron[0] - tetrahedron[1])
    metric = isoembed.PolyhedralMetric(zoo.tetrahedron()[1], [1.2345] * 6)
    found = isoembed.Embedding(metric, vertices, method="exact", tolerance=1e-10)
    s = 1e-4 / np.sqrt(12)
    sigma = isoembed.Sensitivity(found).deviation(s)
    # Area, volume and int H dA go with the second, third and first power of the one length.
    assert np.isclose(sigma.area, 2 * found.area / 1.2345 * s)
    assert np.isclose(sigma.volume, 3 * found.volume / 1.2345 * s)
    assert np.isclose(sigma.vertices.max(), np.linalg.norm(vertices[0]) / 1.2345 * s)
    assert np.allclose(sigma.dihedral_angles, 0, atol=1e-16)
    for independent in (2 * s, 1e-6, 1e-4):  # not those of rounding to four decimals
        of_six = isoembed.Sensitivity(found).integral_deviation(independent).volume
        assert np.isclose(of_six, 3 * found.volume / 1.2345 * independent / np.sqrt(6))


@pytest.mark.parametrize("decimals", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_error_bars_of_rounded_designs(decimals):
    inside = []
    for name in (*solids.ARCHIMEDEAN[:6], "dodecahedron"):
        points = solids.uniform(name) * 30.7
        exact = isoembed.PolyhedralMetric.from_mesh(points, solids.polygons(points))
        metric = exact.with_lengths(np.round(exact.lengths, decimals))
        found = isoembed.embed(metric, length_errors=10.0**-decimals / np.sqrt(12))
        true = isoembed.Embedding(exact, points, method="exact", tolerance=1.0)
        sigma = isoembed.Sensitivity(found).integral_deviation(found.length_errors)
        inside += [abs(getattr(found, n) - getattr(true, n)) <= 2 * getattr(sigma, n) for n in SCALARS]
    assert np.mean(inside) > 0.9


def test_integrals_alone():
    found = surface(CassiniPeanut(), 60)
    errors = np.random.default_rng(2).uniform(0, 1e-3, len(found.metric.lengths))
    alone, whole = (
        isoembed.Sensitivity(found).integral_deviation(errors),
        isoembed.Sensitivity(found).deviation(errors),
    )
    for name in (*SCALARS, "correlation"):
        assert np.allclose(getattr(alone, name), getattr(whole, name), rtol=1e-12)


def test_report_of_a_surface_with_length_errors():
    found = surface(CassiniPeanut(), 60)
    noisy = found.with_length_errors(1e-5)
    assert "deviation" not in isoembed.report(found)
    assert isoembed.report(noisy)["deviation"] == {
        "length_error_rms": pytest.approx(1e-5),
        **isoembed.Sensitivity(found).integral_deviation(1e-5).report,
    }
    large = found.metric.scaled(8.0)
    assert (noisy._in_unit_of(large).length_errors == large.unit * noisy.length_errors).all()
    fit = FittedSurface(found.metric, found.vertices, method="given", tolerance=1e-10, noise=0, weight=0)
    with pytest.raises(InvalidParameter, match="a best fit does not follow the errors of its lengths"):
        fit.with_length_errors(1e-3)


def test_one_wrong_length():
    found = surface(CassiniPeanut(), 60)
    errors = np.zeros(len(found.metric.lengths))
    errors[7] = 2e-4
    sigma, moved = (
        isoembed.Sensitivity(found).deviation(errors),
        isoembed.Sensitivity(found).variation(errors),
    )
    assert np.allclose(sigma.vertices, np.linalg.norm(moved.velocity, axis=1), rtol=1e-9)
    assert np.allclose(sigma.dihedral_angles, np.abs(moved.dihedral_rates), rtol=1e-9)
    for name in SCALARS:
        assert np.isclose(getattr(sigma, name), abs(getattr(moved, name)[0]), rtol=1e-9)


@pytest.mark.parametrize("unit", (1e-100, 1e90))
def test_unit(unit):
    found = surface(CassiniPeanut(), 60)
    same = isoembed.Embedding(
        found.metric.scaled(unit), unit * found.vertices, method="given", tolerance=1e-10
    )
    a, b = isoembed.Sensitivity(found).deviation(1e-3), isoembed.Sensitivity(same).deviation(unit * 1e-3)
    assert np.allclose(a.correlation, b.correlation, rtol=1e-8)
    bound, other = (
        isoembed.Sensitivity(found).deviation_bound(1e-11),
        isoembed.Sensitivity(same).deviation_bound(unit * 1e-11),
    )
    powers = {"vertices": 1, "normals": 0, "dihedral_angles": 0, "mean_curvature": -1}
    for name, power in (powers | {"area": 2, "volume": 3, "integrated_mean_curvature": 1}).items():
        assert np.allclose(getattr(b, name) / unit**power, getattr(a, name), rtol=1e-8), name
        assert np.allclose(getattr(other, name) / unit**power, getattr(bound, name), rtol=1e-3), name


def test_what_is_refused():
    found = surface(CassiniPeanut(), 60)
    with pytest.raises(InvalidParameter, match=r"the error of edge 3 is -0\.1, which is negative"):
        isoembed.Sensitivity(found).deviation(np.where(np.arange(174) == 3, -0.1, 1.0))
    with pytest.raises(InvalidParameter, match=r"errors have the shape \(5,\)"):
        isoembed.Sensitivity(found).deviation(np.ones(5))
    with pytest.raises(InvalidParameter, match="not finite"):
        isoembed.Sensitivity(found).deviation(np.nan)
    x, faces = triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60)
    curved = isoembed.PolyhedralMetric.from_mesh(x / 9, faces, curvature=-1)
    with pytest.raises(InvalidParameter, match="deviations need surfaces in R"):
        isoembed.Sensitivity(isoembed.Embedding(curved, x / 9, method="given", tolerance=1e-10)).deviation(
            1e-3
        )
    x, faces = zoo.tetrahedron()
    flat = np.vstack([x, x[faces[0]].mean(axis=0)])
    a, b, c = faces[0]
    split = np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])
    metric = isoembed.PolyhedralMetric.from_mesh(flat, split)
    split = isoembed.Embedding(metric, flat, method="given", tolerance=1e-10)
    with pytest.raises(SingularMatrix):
        isoembed.Sensitivity(split).deviation(1e-3)
    alone = isoembed.Sensitivity(split).integral_deviation(1e-3)
    assert alone.volume == np.inf and 0 < alone.area < 1 and 0 < alone.integrated_mean_curvature < 1
