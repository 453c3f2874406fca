"""Surfaces of revolution from their metrics, against closed forms, the gallery and direct quadrature."""

from dataclasses import dataclass, replace
from functools import cache
from math import acos, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gallery import CassiniPeanut, Ergosphere, KerrHorizon
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.two_metric import AngleMetric, from_angles
from isoembed.space import Hyperbolic

THETA = np.linspace(0.0, pi, 61)


@dataclass(frozen=True)
class Induced:
    """The metric of a surface of revolution of the gallery."""

    surface: object

    def tensor(self, u):
        _, profile, _, _, speed = self.surface._meridian(u)
        unit = self.surface._unit
        return from_angles(u, speed**2, np.zeros(len(u)), profile.p**2) * unit * unit


def directions(theta, phi=0.3):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def spheroid(a, c):
    """The spheroid x^2/a^2 + y^2/a^2 + z^2/c^2 = 1 with its parametric angle."""
    return AxisymmetricEmbedding.from_components(
        lambda t: (a * np.cos(t)) ** 2 + (c * np.sin(t)) ** 2, lambda t: (a * np.sin(t)) ** 2
    )


def with_squared_slope(G):
    """The metric with rho = sin(theta) and (dz/dx)^2 = G(x), x = cos(theta)."""
    return AxisymmetricEmbedding.from_components(
        lambda t: np.cos(t) ** 2 + np.sin(t) ** 2 * G(np.cos(t)), lambda t: np.sin(t) ** 2
    )


@cache
def window():
    """Not a surface of revolution for .3 < x < .6."""
    return with_squared_slope(lambda x: (x - 0.3) * (x - 0.6))


@pytest.mark.parametrize(
    ("a", "c", "area", "imc"),
    [
        (1.0, 1.0, 12.56637061435917295, 12.56637061435917295),
        (1.0, 2.0, 21.47843532788373680, 17.34376540669010325),
        (2.0, 1.0, 34.68753081338020650, 21.47843532788373680),
        (5.0, 1.0, 171.7804219217564969, 50.19251018313683124),
        (1.0, 10.0, 99.15103054409205990, 64.72202505854832063),
    ],
)
def test_spheroids(a, c, area, imc):
    e = spheroid(a, c)
    assert e.embeds and "is that of a surface of revolution" in e.explanation
    assert e.area == pytest.approx(area, rel=4e-15)
    assert e.integrated_mean_curvature == pytest.approx(imc, rel=1e-14)
    np.testing.assert_allclose(e.rho(THETA), a * np.sin(THETA), atol=1e-14 * a)
    np.testing.assert_allclose(e.z(THETA), c * np.cos(THETA), atol=1e-13 * max(a, c))
    k2 = c / (a * np.hypot(a * np.cos(THETA), c * np.sin(THETA)))
    k1 = k2**3 * a**4 / c**2
    np.testing.assert_allclose(e.mean_curvature(THETA), 0.5 * (k1 + k2), rtol=1e-8)
    np.testing.assert_allclose(e.gaussian_curvature(THETA), k1 * k2, rtol=1e-8)
    assert e.negative_curvature == ()


@pytest.mark.parametrize(
    "surface",
    [
        CassiniPeanut(0.9, 1.0),
        CassiniPeanut(0.99, 1.0),
        KerrHorizon(spin=0.8),
        KerrHorizon(spin=0.866025),  # its curvature at the poles is almost zero
        KerrHorizon(spin=np.sqrt(3.0) / 2.0),  # and is zero
        Ergosphere(1e-2),
        Ergosphere(0.5),
    ],
    ids=str,
)
def test_the_gallery_from_its_metrics(surface):
    e = AxisymmetricEmbedding.of(Induced(surface))
    assert e.embeds
    assert e.area == pytest.approx(surface.area, rel=1e-14)
    assert e.integrated_mean_curvature == pytest.approx(surface.integrated_mean_curvature, rel=3e-14)
    u = np.concatenate([directions(THETA), directions(THETA, 2.0)])
    size = np.abs(surface.point(u)).max()
    np.testing.assert_allclose(e.points(u), surface.point(u), atol=1e-12 * size)
    K = surface.gaussian_curvature(directions(THETA))
    np.testing.assert_allclose(e.gaussian_curvature(THETA), K, atol=1e-8 * np.abs(K).max())
    H = surface.mean_curvature(directions(THETA))
    np.testing.assert_allclose(e.mean_curvature(THETA), H, atol=1e-6 * np.abs(H).max())
    negative = surface.gaussian_curvature(directions(np.linspace(0.0, pi, 20001))) < -1e-12
    fraction = sum(stop - start for start, stop in e.negative_curvature) / pi
    assert fraction == pytest.approx(negative.mean(), abs=2e-4)


def test_an_egg_is_not_symmetric():
    # rho = sin (1 + .3 cos), z = cos + .1 cos^2
    def slopes(t):
        return np.cos(t) + 0.3 * np.cos(2.0 * t), -np.sin(t) * (1.0 + 0.2 * np.cos(t))

    def rho(t):
        return np.sin(t) * (1.0 + 0.3 * np.cos(t))

    e = AxisymmetricEmbedding.from_components(
        lambda t: slopes(t)[0] ** 2 + slopes(t)[1] ** 2, lambda t: rho(t) ** 2
    )
    np.testing.assert_allclose(e.rho(THETA), rho(THETA), atol=1e-14)
    z = np.cos(THETA) + 0.1 * np.cos(THETA) ** 2
    np.testing.assert_allclose(e.z(THETA), z - 0.5 * (z[0] + z[-1]), atol=1e-13)

    def integrand(t):
        (r1, z1), r2, z2 = slopes(t), -np.sin(t) - 0.6 * np.sin(2.0 * t), -np.cos(t) - 0.2 * np.cos(2.0 * t)
        v = np.hypot(r1, z1)
        return pi * rho(t) * v * ((z1 * r2 - r1 * z2) / v**3 - z1 / (rho(t) * v))

    imc, _ = quad(integrand, 0.0, pi, epsabs=1e-13)
    assert e.integrated_mean_curvature == pytest.approx(imc, rel=1e-13)


def test_what_does_not_embed_in_the_middle():
    e = window()
    assert not e.embeds
    ((start, stop),) = e.obstruction
    assert (start, stop) == pytest.approx((acos(0.6), acos(0.3)), abs=1e-13)
    north, south = e.bands
    assert (north.start, north.stop, south.start, south.stop) == (0.0, start, stop, pi)
    assert north.area + south.area < e.area
    for band, x in ((north, (0.6, 1.0)), (south, (-1.0, 0.3))):
        height, _ = quad(lambda y: np.sqrt((y - 0.3) * (y - 0.6)), *x, epsabs=1e-14)
        assert band.height == pytest.approx(height, rel=1e-12)
        z = band.z([band.start, band.stop])
        np.testing.assert_allclose(z, [0.5 * height, -0.5 * height], atol=1e-12)
    sentence = e.explanation
    assert "no surface of revolution has this metric for 0.927295 < theta < 1.2661: there q_tt < " in sentence
    assert "theta < 0.927295 and theta > 1.2661 embeds, " in sentence
    with pytest.raises(InvalidMetric, match=r"no surface of revolution .* 0\.927295 < theta < 1\.2661"):
        e.z(0.1)
    with pytest.raises(InvalidMetric, match="no surface of revolution"):
        _ = e.integrated_mean_curvature


def test_an_obstruction_is_told_from_the_error_of_the_metric():
    surface = window()
    (interval,) = surface.obstruction
    small, large = np.sin(interval)
    length, _ = quad(
        lambda t: np.sqrt(np.cos(t) ** 2 + np.sin(t) ** 2 * (np.cos(t) - 0.3) * (np.cos(t) - 0.6)), *interval
    )
    error = (large - small - length) / (large + small + length)
    assert surface.is_obstructed_beyond(0.999 * error)
    assert not surface.is_obstructed_beyond(1.001 * error)
    enough = Hyperbolic(-1.001 * surface.greatest_curvature)
    assert not replace(surface, space=enough).is_obstructed_beyond(0.0)


def test_the_total_curvature_of_the_cap_that_does_not_embed_is_zero_at_its_edge():
    # rho' = sqrt(q_tt) there; between the edges it is negative.
    e = with_squared_slope(lambda x: 0.9 - x**2)  # K < 0 at both poles
    edge = acos(np.sqrt(0.9))
    np.testing.assert_allclose(e.obstruction, [(0.0, edge), (pi - edge, pi)], atol=1e-12)
    negative = e.negative_curvature[0]
    assert negative[0] == 0.0 and 0.0 < negative[1] < edge

    def total(theta):
        x = np.cos(theta)
        return quad(
            lambda t: e.gaussian_curvature(t)[0] * np.sin(t) * np.sqrt(density(np.cos(t))), 0.0, acos(x)
        )[0]

    def density(x):
        return x**2 + (1.0 - x**2) * (0.9 - x**2)

    assert total(edge) == pytest.approx(0.0, abs=1e-11)
    assert total(negative[1]) < total(0.5 * (negative[1] + edge)) < -1e-3


@pytest.mark.parametrize("which", [0, 1])
def test_the_mean_curvature_of_a_band_is_finite_and_right(which):
    band = window().bands[which]
    metric, length = band.metric, band.stop - band.start
    edge_first = which == 1

    def integrand(r):  # theta - edge = r^2: H is like 1 / r
        theta = band.start + r * r if edge_first else band.stop - r * r
        density = np.sin(theta) * np.sqrt(np.cos(theta) ** 2 + np.sin(theta) ** 2 * G(np.cos(theta)))
        return 4.0 * pi * r * density * metric.mean_curvature(theta)[0]

    def G(x):
        return (x - 0.3) * (x - 0.6)

    imc, _ = quad(integrand, 1e-6, np.sqrt(length), epsabs=1e-12)
    # What was left out next to the edge: H dA is like a constant times dr.
    imc += 1e-6 * integrand(1e-3)
    assert band.integrated_mean_curvature == pytest.approx(imc, rel=1e-8)
    edge = band.start if edge_first else band.stop
    # The cap's meridian turns back to horizontal, the band's begins so.
    assert (1.0 if edge_first else -1.0) * metric.mean_curvature(edge)[0] > 1e5
    assert np.isnan(metric.mean_curvature(acos(0.45))[0])


def test_heights_near_an_edge_are_right_to_rounding():
    # z falls from the edge like a power 3/2 of the distance.
    band = window().bands[1]
    for d in (1e-2, 1e-4, 1e-6):
        x = np.cos(band.start + d)
        fallen, _ = quad(lambda r: 2.0 * r * r * np.sqrt(0.3 + r * r), 0.0, np.sqrt(0.3 - x), epsabs=1e-17)
        z = band.z([band.start, band.start + d])
        assert z[0] - z[1] == pytest.approx(fallen, abs=1e-13)


@given(exponent=st.integers(-70, 70))
def test_no_length_is_special(exponent):
    scale = 10.0**exponent
    one, other = spheroid(2.0, 1.0), spheroid(2.0 * scale, scale)
    assert other.area / scale / scale == pytest.approx(one.area, rel=1e-14)
    assert other.integrated_mean_curvature / scale == pytest.approx(one.integrated_mean_curvature, rel=1e-14)
    np.testing.assert_allclose(other.z(THETA) / scale, one.z(THETA), atol=1e-14)
    np.testing.assert_allclose(other.mean_curvature(THETA) * scale, one.mean_curvature(THETA), rtol=1e-9)


@pytest.mark.parametrize("scale", [1e-100, 1.0, 1e100])
def test_obstructions_have_no_unit(scale):
    e = AxisymmetricEmbedding.from_components(
        lambda t: scale * (np.cos(t) ** 2 + np.sin(t) ** 2 * (0.9 - np.cos(t) ** 2)),
        lambda t: scale * np.sin(t) ** 2,
    )
    np.testing.assert_allclose(
        e.obstruction, with_squared_slope(lambda x: 0.9 - x**2).obstruction, atol=1e-12
    )


def test_a_metric_with_noise_is_taken_for_what_it_is():
    clean = spheroid(1.0, 2.0)
    noisy = AxisymmetricEmbedding.from_components(
        lambda t: (np.cos(t) ** 2 + 4.0 * np.sin(t) ** 2) * (1.0 + 1e-9 * np.sin(t) ** 2 * np.sin(1e7 * t)),
        lambda t: np.sin(t) ** 2,
    )
    assert 1e-11 < noisy.resolution < 1e-7
    assert noisy.embeds
    assert noisy.area == pytest.approx(clean.area, rel=1e-8)
    assert noisy.integrated_mean_curvature == pytest.approx(clean.integrated_mean_curvature, rel=1e-6)


def boundary(faces):
    """The directed edges that no other face has in the other direction."""
    edges = {tuple(map(int, e)) for f in faces for e in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))}
    assert len(edges) == 3 * len(faces)
    return [e for e in edges if e[::-1] not in edges]


def test_the_mesh_of_a_band():
    e = with_squared_slope(lambda x: 0.9 - x**2)
    (band,) = e.bands
    vertices, faces = band.mesh(around=24)
    assert len(boundary(faces)) == 48
    assert len(vertices) - len(faces) * 3 // 2 - 24 + len(faces) == 0  # an annulus
    rho = np.hypot(vertices[:, 0], vertices[:, 1])
    assert np.unique(faces).tolist() == list(range(len(vertices)))
    np.testing.assert_allclose(np.ptp(vertices[:, 2]), band.height, rtol=1e-12)
    np.testing.assert_allclose(np.sort(rho)[:48], np.sin(band.start), rtol=1e-12)
    middle = vertices[faces].mean(axis=1)
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    assert (normals[:, :2] * middle[:, :2]).sum(axis=1).min() > 0.0
    errors = []
    for around in (40, 80, 160):
        x, f = band.mesh(around)
        areas = np.linalg.norm(np.cross(x[f[:, 1]] - x[f[:, 0]], x[f[:, 2]] - x[f[:, 0]]), axis=1)
        errors.append(band.area - 0.5 * areas.sum())
    assert 3.3 < errors[0] / errors[1] < 4.7 and 3.3 < errors[1] / errors[2] < 4.7  # second order


def test_meshes_end_at_poles_in_one_vertex():
    (whole,) = spheroid(1.0, 2.0).bands
    vertices, faces = whole.mesh(16)
    assert boundary(faces) == []
    assert len(vertices) - len(faces) // 2 == 2
    x = vertices[faces]
    assert np.einsum("ij,ij->i", x[:, 0], np.cross(x[:, 1], x[:, 2])).sum() / 6.0 == pytest.approx(
        8.4, rel=0.05
    )
    cap, _ = window().bands
    vertices, faces = cap.mesh(16)
    assert len(boundary(faces)) == 16
    assert (np.hypot(vertices[:, 0], vertices[:, 1]) < 1e-14).sum() == 1


def test_a_turn_about_the_axis_changes_nothing_and_any_other_is_refused():
    @dataclass(frozen=True)
    class Turned:
        turn: np.ndarray

        def tensor(self, u):
            return self.turn @ Induced(KerrHorizon(spin=0.8)).tensor(u @ self.turn) @ self.turn.T

    c, s = np.cos(0.7), np.sin(0.7)
    about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    e = AxisymmetricEmbedding.of(Turned(about_z))
    assert e.integrated_mean_curvature == pytest.approx(22.730557214111993, rel=1e-14)
    about_x = np.roll(about_z, 1, axis=(0, 1))
    sentence = r"not axisymmetric about z: at theta = [\d.]+, q_.* varies with phi by 0\.\d+ of the largest"
    with pytest.raises(InvalidMetric, match=sentence):
        AxisymmetricEmbedding.of(Turned(about_x))


def test_rounded_components_are_no_cone():
    """A table of the horizon of a Kerr hole, spin 0.9, in nine digits."""
    theta, phi = (np.arange(24) + 0.5) * pi / 24, np.arange(48) * pi / 24
    r = 1.0 + np.sqrt(0.19)
    sigma = (r**2 + 0.81 * np.cos(theta) ** 2)[:, None] + 0.0 * phi
    tables = sigma, 0.0 * sigma, (2.0 * r * np.sin(theta)[:, None]) ** 2 / sigma
    rounded = (np.vectorize(lambda x: float(f"{x:.8e}"))(table) for table in (theta, phi, *tables))
    found = AxisymmetricEmbedding.of(GridMetric(*rounded))
    exact = AxisymmetricEmbedding.from_components(
        lambda t: r**2 + 0.81 * np.cos(t) ** 2,
        lambda t: (2.0 * r * np.sin(t)) ** 2 / (r**2 + 0.81 * np.cos(t) ** 2),
    )
    assert found.obstruction == pytest.approx(np.array(exact.obstruction), abs=1e-4)
    assert found.is_obstructed_beyond(found.resolution)
    assert 1e-8 < found.resolution < 1e-6


def wavy(theta, phi):
    wave = 1.0 + 1e-6 * np.sin(theta) ** 4 * np.cos(4.0 * phi)
    return 1.0 + 0.0 * theta, 0.0 * theta, wave * np.sin(theta) ** 2


@pytest.mark.parametrize(
    ("components", "sentence"),
    [
        (
            wavy,
            r"theta = 1.\d+, q_pp / sin\^2\(theta\) varies with phi by 1.\d+e-06 of the largest component",
        ),
        (
            lambda t, _: (1.0 + 0.21 * np.cos(0.5 * t) ** 2, 0.0, np.sin(t) ** 2),
            r"conical at the north pole: q_tt sin\^2\(theta\) / q_pp = 1\.21\d* there, not 1",
        ),
        (
            lambda t, _: (1.0 + 0.1 * np.sin(t) ** 2 * np.sin(1e7 * t), 0.0, np.sin(t) ** 2),
            "not a smooth function of theta",
        ),
    ],
)
def test_what_is_refused(components, sentence):
    with pytest.raises(InvalidMetric, match=sentence):
        AxisymmetricEmbedding.of(AngleMetric(components))
    # A larger tolerance lets the wave pass.
    if components is wavy:
        assert AxisymmetricEmbedding.of(AngleMetric(components), tolerance=1e-5).embeds


def test_a_metric_that_is_not_positive_is_refused():
    @dataclass(frozen=True)
    class Negative:
        def tensor(self, u):
            return from_angles(u, u[:, 2] ** 2 - 0.1, np.zeros(len(u)), u[:, 2] ** 2 - 0.1)

    with pytest.raises(
        InvalidMetric, match=r"= -0\.0\d+, -0\.0\d+ at theta = 1\.\d+: that is not a positive metric"
    ):
        AxisymmetricEmbedding.of(Negative())


def test_angles_that_are_refused():
    e = spheroid(1.0, 2.0)
    with pytest.raises(InvalidParameter, match=r"theta\[1\] = -0\.1 is not between 0 and pi"):
        e.rho([0.1, -0.1])
    with pytest.raises(InvalidParameter, match=r"theta\[0\] = nan is not between"):
        e.mean_curvature(np.nan)
    with pytest.raises(InvalidParameter, match=r"theta\[1\] = 1 is outside the band from 0 to 0\.9272"):
        window().bands[0].z([0.5, 1.0])
    with pytest.raises(InvalidParameter, match="around must be at least 3, not 2"):
        e.bands[0].mesh(2)


@pytest.mark.parametrize("depth", [1e-8, -1e-8])
def test_an_obstruction_between_samples_is_found(depth):
    e = with_squared_slope(lambda x: (x - 0.4567) ** 2 - depth)
    if depth < 0.0:
        assert e.embeds
    else:
        ((start, stop),) = e.obstruction
        np.testing.assert_allclose(np.cos([stop, start]), [0.4566, 0.4568], atol=1e-8)


def ridged(width, place, height):
    """Sphere with a narrow ridge: its components at theta, and the areas of ridge and sphere."""

    def factor(theta):
        return 1 + height * np.exp(-(((np.asarray(theta) - place) / width) ** 2))

    nodes, weights = np.polynomial.legendre.leggauss(200)
    theta = place + 8 * width * nodes
    ridge = 2 * np.pi * 8 * width * weights @ (np.sin(theta) * (factor(theta) - 1))
    return factor, lambda theta: np.sin(theta) ** 2 * factor(theta), ridge


@pytest.mark.parametrize("place", [0.4, 1.0, 1.2345, np.pi / 2])
@pytest.mark.parametrize("width", [0.01, 0.003, 3e-4])
def test_narrow_features_are_resolved(width, place):
    """They were between all nodes of large pieces."""
    q_tt, q_pp, ridge = ridged(width, place, 0.1 * width)
    found = AxisymmetricEmbedding.from_components(q_tt, q_pp)
    assert found.area - 4 * np.pi == pytest.approx(ridge, rel=1e-10, abs=1e-13)
    theta = np.linspace(place - 3 * width, place + 3 * width, 500)
    np.testing.assert_allclose(found.rho(theta) ** 2, q_pp(theta), rtol=1e-12)
    # z' = -sqrt(q_tt - rho'^2), with rho' as differences of the given function
    h = 1e-3 * width
    slope = (np.sqrt(q_pp(theta + h)) - np.sqrt(q_pp(theta - h))) / (2 * h)
    fall = np.sqrt(q_tt(theta) - slope**2)
    drops = np.diff(found.z(theta)), -np.diff(theta) * (fall[1:] + fall[:-1]) / 2
    np.testing.assert_allclose(*drops, rtol=1e-4)
