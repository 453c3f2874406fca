"""Discs of the hyperbolic plane with two, three and more waves: sheets against surfaces in closed form.

    python benchmarks/hyperbolic_discs.py [--radii R ...] [--waves N ...] [--vertices N ...]

For every radius and number of waves n it prints int k1^2 + k2^2 dA of the sheet of least bending found
from a saddle with these waves; the waves that it has; that of the periodic Amsler surface, an isometric
immersion of the disc that consists of 2 n sectors between straight lines [1]_; and the bound
2 int abs(K) dA = 4 pi (cosh R - 1).

References
----------
.. [1] J. A. Gemmer and S. C. Venkataramani, "Shape selection in non-Euclidean plates", Physica D 240 (2011).
"""

import argparse

import numpy as np
from scipy.integrate import solve_ivp

from isoembed import NotEmbedded, embed
from isoembed.smooth import AngleMetric, ChartMetric, triangulate_metric

HYPERBOLIC = AngleMetric(lambda r, phi: (1.0, 0.0, np.sinh(r) ** 2))
START = 1e-9  # of the series of the angle at the center


def amsler(waves, radius, lines=40):
    """The energy and the area of the disc on a periodic Amsler surface; infinite beyond its singular edge.

    In asymptotic coordinates u, v from the center the angle between asymptotic lines is psi(u v), with
    z psi'' + psi' = sin(psi) and psi(0) = pi / waves.  k1^2 + k2^2 = 2 + 4 cot^2 psi, dA = sin(psi) du dv.
    A line of constant u starts at the distance u from the center, with the angle psi(0), and has the geodesic
    curvature u psi'; it is followed to the distance `radius`.
    """
    slope = np.sin(np.pi / waves)

    def flat(z, y):
        return y[0] - np.pi

    def arrived(v, y):
        return y[0] - radius

    flat.terminal = arrived.terminal = True
    angle = solve_ivp(
        lambda z, y: [y[1], (np.sin(y[0]) - y[1]) / z],
        (START, 100.0),
        [np.pi / waves + slope * START, slope],
        rtol=1e-10,
        atol=1e-12,
        dense_output=True,
        events=flat,
    )
    edge, total = angle.t[-1], np.zeros(2)
    nodes, weights = np.polynomial.legendre.leggauss(lines)
    for u, weight in zip(0.5 * radius * (nodes + 1.0), 0.5 * radius * weights, strict=True):

        def along(v, y, u=u):
            psi, rate = angle.sol(max(u * v, START))
            dA = np.sin(psi)
            bent = (2.0 + 4.0 / np.tan(psi) ** 2) * dA
            return [np.cos(y[1]), u * rate - np.sin(y[1]) / np.tanh(y[0]), bent, dA]

        line = solve_ivp(
            along,
            (0.0, edge / u * (1.0 - 1e-9)),
            [u, np.pi / waves, 0.0, 0.0],
            rtol=1e-8,
            atol=1e-10,
            events=arrived,
        )
        if not line.t_events[0].size:
            return np.inf, np.nan
        total += weight * line.y[2:, -1]
    return tuple(2 * waves * total)


def waves_of(sheet):
    """The strongest harmonic of the height along the boundary."""
    x = sheet.vertices - sheet.vertices.mean(axis=0)
    height = x @ np.linalg.svd(x)[2][2]
    return 1 + int(np.abs(np.fft.rfft(height[sheet.triangulation.boundaries[0]]))[1:8].argmax())


def sheet_of(radius, waves, vertices):
    """The sheet that is found from a saddle with some waves."""
    mesh = triangulate_metric(HYPERBOLIC, vertices, zone=(0.0, radius))
    x, y = ChartMetric.coordinates(mesh.directions).T
    start = np.stack([x, y, 0.5 * (x * x + y * y) * np.cos(waves * np.arctan2(y, x))], axis=1)
    return embed(mesh.metric, boundary="free", start=start)


def main():
    """Print a line for every disc."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--radii", type=float, nargs="+", default=[1.0, 1.5, 2.0])
    parser.add_argument("--waves", type=int, nargs="+", default=[2, 3])
    parser.add_argument("--vertices", type=int, nargs="+", default=[60, 100, 160])
    options = parser.parse_args()
    for radius in options.radii:
        print(f"radius {radius:g}: at least {4 * np.pi * (np.cosh(radius) - 1):.4f}")
        for waves in options.waves:
            print(f"  {waves} waves: Amsler {amsler(waves, radius)[0]:.4f}", flush=True)
            for vertices in options.vertices:
                try:
                    found = sheet_of(radius, waves, vertices)
                except NotEmbedded as error:
                    print(f"    {vertices} vertices: {error}", flush=True)
                    continue
                print(
                    f"    {vertices} vertices: {found.second_form_energy:.4f}, {waves_of(found)} waves, "
                    f"imbalance {found.imbalance:.0e}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
