"""Metrics on grids in theta and phi: exact to rounding where the grid resolves them, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import directions_at, fibonacci_directions
from isoembed.smooth import double_fourier
from isoembed.smooth.double_fourier import DoubleFourier
from isoembed.smooth.grid_metric import GridMetric, sampled_on_grid
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import AngleMetric

THETA = {
    "cell-centered": lambda n: (np.arange(n) + 0.5) * np.pi / n,
    "with the poles": lambda n: np.linspace(0.0, np.pi, n),
    "without the poles": lambda n: np.arange(1, n + 1) * np.pi / (n + 1),
    "Gauss-Legendre": lambda n: np.arccos(np.polynomial.legendre.leggauss(n)[0])[::-1],
}
BAND = 0.5  # the metric below has poles in the complex plane at such a distance


def tangent(u):
    return np.eye(3) - u[:, :, None] * u[:, None, :]


def ellipsoid(u):
    """The metric of an ellipsoid in a general position: of degree 2 in theta before the projection."""
    A = np.array([[1.5, 0.2, -0.3], [0.0, 1.2, 0.4], [0.1, -0.5, 1.0]])
    P = tangent(u)
    return P @ (A.T @ A) @ P


def rational(u):
    """A metric without symmetry that is no finite series: of a graph, times a rational factor."""
    w = np.array([0.5, -0.3, 0.4])
    P = tangent(u)
    slope = P @ w
    factor = np.exp(2.0 * u @ w) / (1.0 + (u @ [0.0, 0.6, 0.8] - 0.3) ** 2 / BAND**2)
    return factor[:, None, None] * (P + slope[:, :, None] * slope[:, None, :])


def components(metric, theta, phi):
    """Coordinate components of a tensor on a grid, with the frames right at the poles, too."""
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    d_t = np.stack([np.cos(t) * np.cos(p), np.cos(t) * np.sin(p), -np.sin(t)], axis=1)
    d_p = np.stack([-np.sin(p), np.cos(p), 0.0 * p], axis=1) * np.sin(t)[:, None]
    q = metric(u)
    shape = (len(theta), len(phi))
    return [
        np.einsum("ni,nij,nj->n", a, q, b).reshape(shape) for a, b in ((d_t, d_t), (d_t, d_p), (d_p, d_p))
    ]


def grid(metric, n, m, kind="cell-centered", start=0.0, closed=False):
    theta = THETA[kind](n)
    phi = start + 2.0 * np.pi / m * np.arange(m + closed)
    return GridMetric(theta, phi, *components(metric, theta, phi))


def directions():
    """Directions all over the sphere, on the axis, and very near to it."""
    rng = np.random.default_rng(3)
    u = rng.normal(size=(2000, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    s = np.tile([0.0, 1e-300, 1e-17, 1e-9, 1e-5, 1e-3, 0.02], 2)
    phi, sign = rng.uniform(-9.0, 9.0, 14), np.repeat([1.0, -1.0], 7)
    near = np.stack([s * np.cos(phi), s * np.sin(phi), sign * np.sqrt(1.0 - s**2)], axis=1)
    return np.concatenate([u, near, np.vstack([np.eye(3), -np.eye(3)])])


U = directions()


def error(g, metric):
    exact = metric(U)
    return np.max(np.abs(g.tensor(U) - exact)) / np.max(np.abs(exact))


@pytest.mark.parametrize("kind", THETA)
@pytest.mark.parametrize("n, m", [(12, 24), (13, 25), (11, 14), (12, 9)])
def test_exact_where_the_series_is_finite(kind, n, m):
    assert error(grid(ellipsoid, n, m, kind, start=0.7), ellipsoid) < 1e-14


@pytest.mark.parametrize("kind", THETA)
def test_the_error_falls_exponentially_down_to_rounding(kind):
    sizes = np.array([12, 20, 28, 36])
    errors = [error(grid(rational, n, 2 * n + n % 8, kind), rational) for n in sizes]
    rates = -np.diff(np.log(errors)) / np.diff(sizes)
    assert np.all(rates > 0.3) and np.ptp(rates) < 0.25
    assert error(grid(rational, 96, 192, kind), rational) < 2e-14


@pytest.mark.parametrize("n", [12, 17, 24, 36, 48])
def test_truncation_estimates_the_error(n):
    g = grid(rational, n, 2 * n)
    assert 0.05 < g.truncation / error(g, rational) < 50.0


def test_truncation_in_each_direction():
    assert grid(rational, 60, 10).truncation > 1e-3
    assert grid(rational, 10, 60).truncation > 1e-3
    assert grid(rational, 90, 180).truncation < 1e-14


def horizon(a):
    """Of a Kerr black hole of mass 1, in Boyer-Lindquist angles."""
    r = 1.0 + np.sqrt(1.0 - a**2)
    return lambda u: _axial(u, r**2 + (a * u[:, 2]) ** 2, (r**2 + a**2) ** 2 / (r**2 + (a * u[:, 2]) ** 2))


def _axial(u, Qtt, Qpp):
    around = np.stack([-u[:, 1], u[:, 0], np.zeros(len(u))], axis=1)
    s2 = np.maximum(1.0 - u[:, 2] ** 2, u[:, 0] ** 2 + u[:, 1] ** 2)
    # Qtt on the tangent plane; the difference vanishes at the poles.
    difference = np.divide(Qpp - Qtt, s2, out=np.zeros(len(u)), where=s2 > 1e-20)
    return (
        Qtt[:, None, None] * tangent(u) + difference[:, None, None] * around[:, :, None] * around[:, None, :]
    )


@pytest.mark.parametrize("spin", [0.5, 0.8])
def test_horizons_on_the_usual_grid(spin):
    assert error(grid(horizon(spin), 48, 96), horizon(spin)) < 4e-15


def test_ergosphere_on_the_usual_grid():
    """It is nearly pointed at the poles, and the truncation says so."""
    a, epsilon = 0.975, 0.5

    def ergosphere(u):
        c, s2 = u[:, 2], u[:, 0] ** 2 + u[:, 1] ** 2
        root = np.sqrt(1.0 - (a * c) ** 2)
        R = 1.0 + root + epsilon
        Sigma, Delta = R**2 + (a * c) ** 2, R**2 - 2.0 * R + a**2
        slope = a**4 * s2 * c**2 / root**2  # (dR / dtheta)^2
        return _axial(u, Sigma * (1.0 + slope / Delta), R**2 + a**2 + 2.0 * a**2 * R * s2 / Sigma)

    g = grid(ergosphere, 48, 96)
    assert 1e-6 < error(g, ergosphere) < 1e-4
    assert 0.1 < g.truncation / error(g, ergosphere) < 10.0


def test_one_angle_phi_is_a_metric_symmetric_about_the_axis():
    theta = THETA["Gauss-Legendre"](32)
    g = GridMetric(theta, [0.3], *components(horizon(0.6), theta, np.array([0.3])))
    assert error(g, horizon(0.6)) < 4e-15


@pytest.mark.parametrize("m", [20, 21])
def test_a_repeated_end_point_changes_nothing(m):
    a, b = grid(rational, 20, m, start=-1.3), grid(rational, 20, m, start=-1.3, closed=True)
    assert b.q_tt.shape == (20, m + 1)
    np.testing.assert_allclose(a.tensor(U), b.tensor(U), rtol=0, atol=1e-13)


def test_pole_rows_may_hold_anything():
    theta, phi = THETA["with the poles"](16), np.arange(20) * np.pi / 10
    q = components(ellipsoid, theta, phi)
    for component in q:
        component[[0, -1]] = np.nan
    assert error(GridMetric(theta, phi, *q), ellipsoid) < 1e-14
    single = GridMetric(theta.astype(np.float32), phi.astype(np.float32), *q)  # its pi is above pi
    assert error(single, ellipsoid) < 1e-5


@given(exponent=st.integers(-140, 140), start=st.floats(-10.0, 10.0))
def test_scales_and_offsets(exponent, start):
    scale = 10.0**exponent
    theta, phi = THETA["cell-centered"](10), start + np.arange(12) * np.pi / 6
    g = GridMetric(theta, phi, *(scale**2 * c for c in components(ellipsoid, theta, phi)))
    np.testing.assert_allclose(g.tensor(U) / scale**2, ellipsoid(U), rtol=0, atol=5e-14)
    assert 0.0 <= g.truncation < 1e-14


def test_tensors_are_symmetric_and_tangent():
    q = grid(rational, 20, 40).tensor(U)
    np.testing.assert_allclose(q, q.transpose(0, 2, 1), rtol=0, atol=1e-15 * np.max(q))
    assert np.max(np.abs(np.einsum("nij,nj->ni", q, U))) < 1e-14
    assert grid(rational, 20, 40).tensor(np.empty((0, 3))).shape == (0, 3, 3)


def test_the_table_loses_nothing_against_the_series():
    """Local polynomials on the finer grid, compared with the sum of the series."""
    rng = np.random.default_rng(8)
    n, m = 10, 15
    f = DoubleFourier(THETA["cell-centered"](n), 2.0 * np.pi / m * np.arange(m), rng.normal(size=(n, m, 1)))
    theta = np.arctan2(np.hypot(U[:, 0], U[:, 1]), U[:, 2])[:, None]
    phi = np.arctan2(U[:, 1], U[:, 0])[:, None]
    total = np.zeros(len(U))
    for order in range(m // 2 + 1):
        k = np.arange(n)
        waves = np.sin((k + 1) * theta) if order % 2 else np.cos(k * theta)
        total += ((waves @ f.coefficients[:, order, 0])[:, None] * np.exp(1j * order * phi)).real[:, 0]
    # White noise is the worst case: most of it is in waves that the stencil does not quite see.
    assert np.max(np.abs(f.at(U)[:, 0] - total)) < 1e-11 * np.max(np.abs(total))


@pytest.mark.parametrize("m", [8, 9, 10])
@pytest.mark.parametrize("n", [7, 8])
def test_whatever_the_values_the_nodes_have_them(n, m):
    """The shortest wave around belongs to one mode only, if m is even."""
    theta, phi = THETA["Gauss-Legendre"](n), 0.4 + 2.0 * np.pi / m * np.arange(m)
    values = np.random.default_rng(m).normal(size=(n, m, 2))
    t, p = np.meshgrid(theta, phi, indexing="ij")
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=2).reshape(-1, 3)
    found = DoubleFourier(theta, phi, values).at(u)
    np.testing.assert_allclose(found, values.reshape(-1, 2), rtol=0, atol=1e-10)


def test_a_table_that_would_be_large_is_half_as_fine(monkeypatch):
    fine = grid(rational, 72, 144)._field
    monkeypatch.setattr(double_fourier, "LARGE", fine.table.size // 2)
    g = grid(rational, 72, 144)
    assert g._field.table.size < 0.3 * fine.table.size
    assert error(g, rational) < 2e-13


@pytest.mark.parametrize("kind", THETA)
def test_scalars_are_interpolated_alike(kind):
    """Harmonics up to a degree are finite series: exact values, though no pole has a node."""
    n, m = 14, 22
    theta, phi = THETA[kind](n), 0.1 + 2.0 * np.pi / m * np.arange(m)
    theta = theta[(theta > 0) & (theta < np.pi)]
    t, p = np.meshgrid(theta, phi, indexing="ij")
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=2)
    Y = Harmonics(8, 8)
    values = Y.values(u.reshape(-1, 3)).reshape(len(theta), m, -1)
    np.testing.assert_allclose(DoubleFourier(theta, phi, values).at(U), Y.values(U), rtol=0, atol=3e-13)


def arrays():
    theta, phi = THETA["cell-centered"](8), 2.0 * np.pi / 10 * np.arange(10)
    q_tt, q_tp, q_pp = components(ellipsoid, theta, phi)
    return {"theta": theta, "phi": phi, "q_tt": q_tt, "q_tp": q_tp, "q_pp": q_pp}


def put(name, place, value):
    def change(tables):
        tables[name][place] = value

    return change


def replace(name, value):
    def change(tables):
        tables[name] = value(tables[name])

    return change


def half(tables):
    """Only the northern half, more finely."""
    theta = tables["theta"] / 2.0
    tables.update(zip(("q_tt", "q_tp", "q_pp"), components(ellipsoid, theta, tables["phi"]), strict=True))
    tables["theta"] = theta


def closed_but_torn(tables):
    tables["phi"] = np.append(tables["phi"], 2.0 * np.pi)
    for name in ("q_tt", "q_tp", "q_pp"):
        tables[name] = np.column_stack([tables[name], tables[name][:, 0]])
    tables["q_tp"][3, 10] += 0.01


def coarse(tables):
    tables["q_tt"][:, ::2] *= 1e-4
    tables["q_pp"][:, ::2] *= 1e-4
    tables["q_tp"][:] = 0.0


BAD = {
    "nan": (
        put("q_tp", (3, 4), np.nan),
        r"nan, .* at node \[3, 4\], theta = 1.374.*, phi = 2.513.*: .*not finite",
    ),
    "not positive": (put("q_pp", (2, 7), -1.0), r"-1 at node \[2, 7\].*not a positive definite metric"),
    "indefinite": (put("q_tp", (5, 0), 9.0), r"node \[5, 0\].*not a positive definite metric"),
    "shape": (replace("q_tt", np.transpose), r"q_tt has the shape \(10, 8\) .*, not \(8, 10\)"),
    "words": (replace("q_pp", lambda q: q.astype(str)), r"q_pp has .* type <U"),
    "theta outside": (replace("theta", lambda t: t + 0.3), r"theta\[7\] = 3.245.* is not between 0 and pi"),
    "theta in degrees": (replace("theta", np.degrees), r"theta\[0\] = 11.25 is not between 0 and pi"),
    "theta decreasing": (replace("theta", lambda t: t[::-1]), r"theta\[1\] = .* is not above theta\[0\]"),
    "theta nan": (put("theta", 2, np.inf), r"theta\[2\] = inf is not finite"),
    "theta twice": (replace("theta", lambda t: np.stack([t, t])), r"theta has the shape \(2, 8\)"),
    "few": (
        replace("theta", lambda t: np.array([0.0, 1.0, np.pi])),
        "there are 1 nodes theta besides the poles",
    ),
    "half": (half, r"theta = 0.098.* \.\.\. 1.47.* do not determine a Fourier series"),
    "phi not uniform": (put("phi", 3, 1.9), r"phi\[3\] = 1.9 is not 1.8849.*: 10 uniform angles"),
    "phi on one half": (replace("phi", lambda p: p / 2.0), r"phi\[1\] = 0.314159 is not 0.628319"),
    "phi in degrees": (replace("phi", np.degrees), r"phi\[1\] = 36 is not 0.628"),
    "torn": (closed_but_torn, r"q_tp\[3, 10\] = .* is not q_tp\[3, 0\]"),
    "coarse": (coarse, r"between the 8 x 10 nodes .* not positive definite .* too coarse"),
}


@pytest.mark.parametrize("change, message", BAD.values(), ids=BAD)
def test_refusals(change, message):
    tables = arrays()
    change(tables)
    with pytest.raises(InvalidMetric, match=message):
        GridMetric(**tables)


def test_read_only_and_brief():
    given_arrays = arrays()
    g = GridMetric(**given_arrays)
    assert repr(g) == "GridMetric(8 x 10 nodes)"
    with pytest.raises(ValueError, match="read-only"):
        g.q_tt[0, 0] = 1.0
    given_arrays["q_tt"][0, 0] = np.nan  # not the metric's
    assert np.isfinite(g.q_tt).all()


def test_a_symmetric_one_form_is_interpolated_from_one_meridian():
    """Its Cartesian components turn with phi."""
    theta, phi = (np.arange(16) + 0.5) * np.pi / 16, [0.7]
    t = theta[:, None]
    grid = GridMetric(theta, phi, np.ones((16, 1)), np.zeros((16, 1)), np.sin(t) ** 2)
    u = np.random.default_rng(0).normal(size=(50, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    # (2 + z) times that of the rotation about z, and the gradient of z^2
    form = grid.one_form(-2.0 * np.cos(t) * np.sin(t), (2.0 + np.cos(t)) * np.sin(t) ** 2, "j")
    x, y, z = u.T
    expected = (2.0 + z)[:, None] * np.stack([-y, x, 0 * x], axis=1)
    expected += 2.0 * z[:, None] * (np.array([0.0, 0.0, 1.0]) - z[:, None] * u)
    np.testing.assert_allclose(form(u), expected, atol=1e-13)
    assert form.error.pointwise < 1e-12


def test_a_one_form_is_interpolated_over_the_poles():
    """That of the gradient of a polynomial, from its coordinate components."""
    n, m = 16, 24
    theta, phi = (np.arange(n) + 0.5) * np.pi / n, 2.0 * np.pi / m * np.arange(m)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    x, y, z = np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)
    # f = x y + 2 y z: components are its derivatives by theta and phi.
    x_t, y_t, z_t = np.cos(t) * np.cos(p), np.cos(t) * np.sin(p), -np.sin(t)
    along = x_t * y + x * y_t + 2.0 * (y_t * z + y * z_t)
    around_ = -y * y + x * x + 2.0 * x * z
    grid = GridMetric(theta, phi, np.ones((n, m)), np.zeros((n, m)), np.sin(t) ** 2)
    u = np.random.default_rng(0).normal(size=(50, 3))
    u = np.concatenate([u / np.linalg.norm(u, axis=1)[:, None], [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    gradient = np.stack([u[:, 1], u[:, 0] + 2.0 * u[:, 2], 2.0 * u[:, 1]], axis=1)
    expected = gradient - (gradient * u).sum(axis=1)[:, None] * u
    np.testing.assert_allclose(grid.one_form(along, around_, "j")(u), expected, atol=1e-13)
    with pytest.raises(InvalidMetric, match="j"):
        grid.one_form(along[:-1], around_, "j")


class TestAnglesInSinglePrecision:
    @pytest.mark.parametrize("kind", THETA)
    @pytest.mark.parametrize("start, closed", [(0.0, False), (0.0, True), (-np.pi + np.pi / 46, False)])
    def test_of_usual_grids_are_made_exact(self, kind, start, closed):
        exact = grid(ellipsoid, 24, 46, kind, start, closed)
        single = [angles.astype(np.float32) for angles in (exact.theta, exact.phi)]
        restored = GridMetric(*single, exact.q_tt, exact.q_tp, exact.q_pp)
        assert np.allclose(restored.theta, exact.theta, rtol=0.0, atol=1e-15)
        assert np.allclose(restored.phi, exact.phi, rtol=0.0, atol=2e-15)
        assert error(restored, ellipsoid) < 2e-14

    def test_of_other_grids_are_accepted(self):
        exact = grid(ellipsoid, 24, 46, start=0.31)
        accepted = GridMetric(exact.theta, exact.phi.astype(np.float32), exact.q_tt, exact.q_tp, exact.q_pp)
        assert error(accepted, ellipsoid) < 1e-6

    def test_numbers_that_differ_are_told_apart(self):
        exact = grid(ellipsoid, 24, 46)
        phi = exact.phi + 2.5e-6 * (np.arange(46) == 29)
        with pytest.raises(InvalidMetric, match=r"phi\[29\] = 3\.9611\d+ is not 3\.9611\d+: 46") as said:
            GridMetric(exact.theta, phi, exact.q_tt, exact.q_tp, exact.q_pp)
        assert "in radians, in eight digits or more" in str(said.value)


@pytest.mark.parametrize(("bumps", "nodes"), [(2, 96), (20, 192), (100, 768)])
def test_a_meridian_has_the_nodes_that_it_requires(bumps, nodes):
    class Wavy:
        def tensor(self, u):
            scale = np.exp(0.1 * np.cos(bumps * np.arccos(np.clip(u[:, 2], -1.0, 1.0))))
            return scale[:, None, None] * (np.eye(3) - u[:, :, None] * u[:, None, :])

    grid = sampled_on_grid(Wavy())
    assert grid.q_tt.shape == (nodes, 1)
    u = fibonacci_directions(500)
    np.testing.assert_allclose(grid.tensor(u), Wavy().tensor(u), atol=1e-12)


@pytest.mark.parametrize(("axis", "nodes"), [(1.0, 96), (0.1, 96), (100.0, 192), (1000.0, 768)])
def test_functions_of_theta_have_the_nodes_that_they_require(axis, nodes):
    """Near the south pole sin(theta) is accurate to 1e-13 only; lengths at the tips of needles are short."""

    def components(theta, phi):
        sin, cos = np.sin(theta), np.cos(theta)
        return cos**2 + axis**2 * sin**2, 0.0, sin**2

    metric = AngleMetric(components)
    grid = sampled_on_grid(metric)
    assert grid.q_tt.shape == (nodes, 1)
    theta = np.linspace(0.01, np.pi - 0.01, 300)
    u = directions_at(np.cos(theta), 1.0)
    errors, sizes = (
        np.abs(q).max(axis=(1, 2)) for q in (grid.tensor(u) - metric.tensor(u), metric.tensor(u))
    )
    assert (errors <= 2e-12 * sizes).all()
