"""The Wang-Yau energy against what is known of it, its optimal time functions, and what they cost.

    python benchmarks/wang_yau.py [--only PART ...] [--json FILE]

Parts.  "spheres": tau = b r cos theta on spheres of Schwarzschild's spacetime, against the closed form, and
the second variation at tau = 0 in harmonics of degree l.  "minkowski": a surface of Minkowski space, whose
energy vanishes for its own time function and is to be found from 0; "no boost" is by how much the time
function that is found is none that a boost makes of its own.  "boosted": coordinate spheres around a hole of
speed .6; E(0) and the least E with their differences from W M and M (W Lorentz's factor), times R over M^2.
"kerr": surfaces r = const; tau = 0 is critical there, E(0) stands beside the Brown-York energy, and the least
second derivative, times r, says whether it is a minimum.  "extreme": r -> r_+ for spins near M; the curvature
at the poles, and the energy or what is said instead.  "pair": coordinate spheres around two boosted holes
that meet head-on, superposed (no solution of the constraints), and the optimal tau over R.  "horizon":
surfaces of constant expansion c that tend to a horizon, R its areal radius.  "grid": a surface without
symmetry around two holes in motion, in their slice on Cartesian grids of three spacings: errors as root mean
squares over three places of the grid, and the rates at which they fall.

Each number stands beside its error, where the true one is known, and the error that was estimated.  Seconds
are those of the processor; "in embeddings" counts them in cold embeddings of the same surface.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from isoembed import NotEmbedded
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import (
    BrillLindquist,
    CartesianGrid,
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    SurfaceData,
    TimeFunction,
    constant_expansion,
    embed_surface,
    find_horizon,
    wang_yau,
)
from isoembed.relativity.energies.second_variation import SecondVariation
from isoembed.relativity.energies.wang_yau_functional import Functional
from isoembed.relativity.spacetimes.schwarzschild import BoostedSchwarzschild, Superposed
from isoembed.smooth import Harmonics, PulledBack, embed_smooth
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import orthonormal_frame, projected

PARTS = ("spheres", "minkowski", "boosted", "kerr", "extreme", "pair", "horizon", "grid")
SPHERES = ((4.0, 0.0), (4.0, 0.5), (4.0, 1.0), (4.0, 2.0), (1000.0, 1.0))
TABLE = {10.0: (1.21576, 1.04726), 100.0: (1.24423, 1.00473), 1000.0: (1.24939, 1.00047)}  # known before
SPEED = 0.6
SPINS, RADII = (0.5, 0.8), (3.0, 6.0, 10.0, 30.0, 100.0)
EXTREME, BEYOND = (0.9, 0.99, 0.999), (1.01, 1.1, 1.2, 1.5, 2.0)  # r over r_+
PAIR = ((1.0, -0.4, 3.0), (0.5, 0.3, -3.0))  # mass, speed along z, z
EXPANSIONS = (1e-2, 1e-4, 1e-6)  # times R
SPACINGS, SHIFTS = (0.48, 0.36, 0.27), (0.0, 0.3, 0.7)  # and of a spacing
SMALL = 0.1  # numbers that are written as errors


def show(title, rows):
    """Print dictionaries as a table."""
    heads = list(dict.fromkeys(head for row in rows for head in row))
    cells = [[written(row.get(head)) for head in heads] for row in rows]
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]
    print(f"\n{title}\n")
    for line in (heads, ["-" * width for width in widths], *cells):
        print("| " + " | ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True)) + " |")


def written(value):
    """A cell: small numbers get few digits."""
    if value is None:
        return "-"
    if not isinstance(value, float):
        return str(value)
    return f"{value:.2e}" if 0.0 < abs(value) < SMALL else f"{value:.12g}"


def seconds_of(function, *arguments, **options):
    """Seconds of the processor, and the result."""
    start = time.process_time()
    result = function(*arguments, **options)
    return time.process_time() - start, result


def searched(data):
    """The energies of tau = 0 and of the optimal tau, and a row of what the search took."""
    cold, embedding = seconds_of(embed_smooth, data.metric)
    still = wang_yau(data, embedding=embedding)
    seconds, found = seconds_of(wang_yau, data, "optimal", embedding=embedding)
    cost = {
        "degree": found.tau.harmonics.degree,
        "embeddings": found.embeddings,
        "seconds": round(seconds, 1),
        "in embeddings": round(seconds / cold, 1),
    }
    return still, found, cost


def round_sphere(r):
    """Of areal radius r in the static slice, M = 1."""
    metric = PulledBack(lambda u: np.tile(r * np.eye(3), (len(u), 1, 1)))
    k = 2.0 * np.sqrt(1.0 - 2.0 / r) / r
    return SurfaceData(metric, mean_curvature=lambda u: np.full(len(u), k))


def closed_form(r, b):
    """E(b r cos theta) on this sphere."""
    x, weights = np.polynomial.legendre.leggauss(200)
    f = np.sqrt(1.0 - 2.0 / r)
    W = np.sqrt(1.0 + b * b * (1.0 - x * x))
    physical = 2.0 * np.hypot(f * W, b * x) - 2.0 * b * x * np.arcsinh(b * x / (f * W))
    reference = np.sqrt(1.0 + b * b) + np.arcsinh(b) / b if b else 2.0
    return 0.5 * r * reference - 0.25 * r * float(weights @ physical)


def spheres():
    """Closed forms."""
    energies, variations = [], []
    for r, b in SPHERES:
        data, tau = round_sphere(r), TimeFunction.of(lambda u, h=b * r: h * u[:, 2], 2)
        seconds, found = seconds_of(wang_yau, data, tau)
        true = closed_form(r, b)
        energies.append(
            {
                "r": f"{r:g}",
                "b": f"{b:g}",
                "E": found.energy.value,
                "error": abs(found.energy.value - true),
                "estimated": found.energy.error,
                "embeddings": found.embeddings,
                "seconds": round(seconds, 1),
            }
        )
    show("Spheres of Schwarzschild's spacetime, tau = b r cos theta", energies)
    r, c, f = 4.0, 0.2, np.sqrt(0.5)
    data = round_sphere(r)
    embedding, X, tau = embed_smooth(data.metric), Harmonics(16, 16), Harmonics(8, 8)
    functional = Functional.of(data, embedding, TimeFunction.zero(), X, tau)
    start = resized(embedding.coefficients, embedding.harmonics, X)
    hessian = 0.5 * c**2 * np.diag(SecondVariation.of(functional).at(np.zeros(tau.size - 1), start))
    for l in range(1, 9):
        found = hessian[tau.labels[0][1:] == l]
        true = c**2 * l * (l + 1) * (1.0 - 2.0 * f + l * (l + 1) / (2.0 * f)) / (16.0 * np.pi * r)
        error = float(np.abs(found / true - 1.0).max())
        variations.append({"l": l, "second variation": float(found[0]), "relative error": error})
    show("Second variation at tau = 0, r = 4 M, tau = .05 r Y_lm: the worst m", variations)
    return {"energies": energies, "variations": variations}


@dataclass(frozen=True)
class Map:
    """A map to R^3 in harmonics, coefficients (size, 3)."""

    harmonics: Harmonics
    coefficients: np.ndarray

    def values(self, u):
        return self.harmonics.values(u) @ self.coefficients

    def gradient(self, u):
        return self.harmonics.gradients(u)[1] @ self.coefficients


class Spacelike:
    """A surface (tau, X) of Minkowski space, with the frame of its normal bundle that R^3 makes."""

    def __init__(self, tau, X):
        self.tau, self.X = tau, X

    def tensor(self, u):
        """Its metric."""
        dX, g = self.X.gradient(u), self.tau.gradient(u)
        return projected(np.einsum("nic,njc->nij", dX, dX) - g[:, :, None] * g[:, None, :], u)

    def lying(self, u):
        """k, p (n,) and K(., n) (n, 3)."""
        e = orthonormal_frame(u, self.tensor(u))
        X = self.X.harmonics.along(u, e)[1] @ self.X.coefficients
        S = self.X.harmonics.second_along(u, e, self.X.coefficients)
        g = self.tau.harmonics.along(u, e)[1] @ self.tau.coefficients
        s = self.tau.harmonics.second_along(u, e, self.tau.coefficients[:, None])[..., 0]
        drift = np.einsum("nabk,nck->nabc", S, X) - s[..., None] * g[:, None, None, :]
        bent = np.einsum("naak->nk", S - drift @ X[:, None])
        upward = np.einsum("naa->n", s - np.einsum("nabc,nc->nab", drift, g))
        normals = np.cross(X[:, 0], X[:, 1])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        up = np.linalg.solve(np.einsum("nac,nbc->nab", X, X), g[:, :, None])[:, :, 0]
        W = np.sqrt(1.0 + (g**2).sum(axis=1))
        p = W * (-upward + np.einsum("nk,na,nak->n", bent, up, X))
        h = -np.einsum("nabk,nk->nab", S, normals)
        dual = np.linalg.inv(np.concatenate([e, u[:, None]], axis=1))[:, :, :2]
        j = np.einsum("nia,nab,nb->ni", dual, h, up) * W[:, None]
        return -(bent * normals).sum(axis=1), p, j

    def data(self):
        """For the energy."""
        return SurfaceData(
            self,
            mean_curvature=lambda u: self.lying(u)[0],
            momentum=lambda u: self.lying(u)[1],
            normal_momentum=lambda u: self.lying(u)[2],
        )


def minkowski():
    """Zero, for the surface's own tau and for the one that is found."""
    u, weights = gauss_rule(6, 12)
    x, y, z = u.T
    X = u * [1.0, 1.2, 0.9] + 0.05 * np.stack([y * z, x**2, x * y], axis=1)
    harmonics = Harmonics(2, 2)
    X = Map(harmonics, harmonics.values(u).T @ (weights[:, None] * X))
    rows = []
    for size in (0.5, 1.0):
        own = TimeFunction.of(
            lambda u, c=size: c * (0.3 * u[:, 0] * u[:, 1] + 0.15 * u[:, 2] ** 2 + 0.1 * u[:, 0]), 2
        )
        surface = Spacelike(own, X)
        data = surface.data()
        still, found, cost = searched(data)
        there = wang_yau(data, own)
        columns = np.column_stack([np.ones(len(u)), own.values(u), X.values(u)])
        tau = found.tau.values(u)
        fit = columns @ np.linalg.lstsq(columns, tau, rcond=None)[0]
        rows.append(
            {
                "size of tau": f"{size:g}",
                "E(0)": still.energy.value,
                "E(own tau)": there.energy.value,
                "gradient": there.gradient,
                "least E": found.energy.value,
                "estimated": found.energy.error,
                "no boost": float(np.abs(fit - tau).max()),
            }
            | cost
        )
    show("A surface of Minkowski space of the size 1", rows)
    return rows


def boosted():
    """A hole in motion."""
    hole, rows = BoostedSchwarzschild(1.0, (0.0, 0.0, SPEED)), []
    for R, (resting, least) in TABLE.items():
        still, found, cost = searched(StarSurface.sphere((0.0, 0.0, 0.0), R).data(hole))
        rows.append(
            {
                "R": f"{R:g}",
                "E(0)": still.energy.value,
                "table": resting,
                "(W - E(0)) R": R * (hole.lorentz_factor - still.energy.value),
                "least E": found.energy.value,
                "its table": least,
                "estimated": found.energy.error,
                "(least - 1) R": R * (found.energy.value - 1.0),
                "tau / R": float(found.tau.coefficients[1]) * np.sqrt(0.75 / np.pi) / R,
            }
            | cost
        )
    show(f"A hole of speed {SPEED}: E(0) -> 1.25 M, least E -> M, tau -> -.75 z", rows)
    return rows


def kerr():
    """Surfaces r = const."""
    rows = []
    for a in SPINS:
        for r in RADII:
            data = KerrNewmanSphere(r, 1.0, a).data()
            seconds, surface = seconds_of(embed_surface, data)
            taken, found = seconds_of(wang_yau, data, "optimal", embedding=surface.embedding)
            rows.append(
                {
                    "a": f"{a:g}",
                    "r": f"{r:g}",
                    "E": found.energy.value,
                    "less Brown-York": abs(found.energy.value - surface.energies.brown_york.value),
                    "estimated": found.energy.error,
                    "gradient": found.gradient,
                    "least second derivative": r * found.least_second_derivative,
                    "embeddings": found.embeddings,
                    "seconds": round(taken, 1),
                    "in embeddings": round(taken / seconds, 1),
                }
            )
    show("Kerr, r = const: tau = 0 is critical, and a minimum", rows)
    return rows


def extreme():
    """Toward the horizons of spins near M."""
    rows, north = [], np.array([[0.0, 0.0, 1.0]])
    for a in EXTREME:
        horizon = 1.0 + np.sqrt((1.0 - a) * (1.0 + a))
        for ratio in BEYOND:
            surface = KerrNewmanSphere(ratio * horizon, 1.0, a)
            row = {
                "a": f"{a:g}",
                "r / r_+": f"{ratio:g}",
                "r": round(surface.r, 4),
                "K r^2 at the poles": float(surface.gaussian_curvature(north)[0]) * surface.r**2,
            }
            try:
                found = wang_yau(surface.data(), "optimal", degrees=(2, 4))
                row |= {
                    "E": found.energy.value,
                    "estimated": found.energy.error,
                    "least second derivative": surface.r * found.least_second_derivative,
                    "said": "; ".join(found.notes),
                }
            except (NotEmbedded, InvalidParameter) as error:
                row["said"] = str(error).partition(":")[0]
            rows.append(row)
    show("Kerr, r -> r_+ near the extreme spin", rows)
    return rows


def pair():
    """Two holes that meet."""
    holes = Superposed([BoostedSchwarzschild(mass, (0, 0, v), (0, 0, z)) for mass, v, z in PAIR])
    factors = [1.0 / np.sqrt(1.0 - v * v) for _, v, _ in PAIR]
    energy = sum(W * m for W, (m, _, _) in zip(factors, PAIR, strict=True))
    momentum = sum(W * m * v for W, (m, v, _) in zip(factors, PAIR, strict=True))
    rows = []
    for R in (8.0, 12.0, 20.0, 50.0):
        still, found, cost = searched(StarSurface.sphere((0.0, 0.0, 0.0), R).data(holes))
        l, m = found.tau.harmonics.labels
        rows.append(
            {"R": f"{R:g}", "E(0)": still.energy.value, "least E": found.energy.value}
            | {"estimated": found.energy.error, "least second derivative": R * found.least_second_derivative}
            | {f"tau_{n}0 / R": float(found.tau.coefficients[(l == n) & (m == 0)][0]) / R for n in (1, 2, 3)}
            | cost
        )
    mass = np.sqrt(energy**2 - momentum**2)
    show(
        f"Two holes, head-on: energy {energy:.5f}, momentum {momentum:.5f}, mass {mass:.5f} far away, "
        f"where tau_10 -> {-momentum / mass * np.sqrt(4.0 * np.pi / 3.0):.5f} R",
        rows,
    )
    return rows


def horizon():
    """Toward horizons in slices with and without K_ij."""
    axis, rows = np.array([0.0, np.sin(0.7), np.cos(0.7)]), []
    slices = {"Kerr, spin .5": KerrSchild(1.0, (0.3, 0.0, 0.4))}
    for d in (0.5, 0.7):
        slices[f"Brill-Lindquist, d = {d}"] = BrillLindquist((0.5, 0.5), (0.5 * d * axis, -0.5 * d * axis))
    for name, slice_ in slices.items():
        found = find_horizon(slice_)
        R = np.sqrt(found.area / (4.0 * np.pi))
        surface = embed_surface(found.data())
        limit = wang_yau(surface.data, "optimal", embedding=surface.embedding).energy
        for c in EXPANSIONS:
            data = constant_expansion(slice_, c / R, found.surface).data()
            near = embed_surface(data, start=surface)
            taken, least = seconds_of(wang_yau, data, "optimal", embedding=near.embedding)
            rows.append(
                {
                    "horizon": name,
                    "c R": f"{c:g}",
                    "Liu-Yau": near.energies.liu_yau.value,
                    "Wang-Yau": least.energy.value,
                    "stated": least.energy.error,
                    "limit less that": limit.value - least.energy.value,
                    "tau / R": float(np.abs(least.tau.coefficients).max() / R),
                    "seconds": round(taken, 1),
                }
            )
        rows.append({"horizon": name, "c R": "0", "Wang-Yau": limit.value, "stated": limit.error})
    show("Surfaces of constant expansion c that tend to a horizon", rows)
    return rows


def grid():
    """A slice with K_ij on grids."""
    holes = Superposed(
        [
            BoostedSchwarzschild(1.0, (0.0, 0.2, 0.3), (0.3, 0.0, -0.9)),
            BoostedSchwarzschild(0.6, (0.1, -0.3, -0.2), (-0.4, 0.2, 1.1)),
        ]
    )
    center = np.array([0.2, -0.1, 0.3])

    def radius(u):
        x, y, z = u.T
        return 4.5 * (1.0 + 0.05 * x * y + 0.04 * z**3 - 0.05 * (x**4 - y**3 * z) + 0.03 * x)

    def sampled(h, shift):
        axes = [np.arange(c - 6.0 + shift * h, c + 6.0 + h, h) for c in center]
        x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        tensors = (tensor(x.reshape(-1, 3)).T for tensor in (holes.metric, holes.extrinsic_curvature))
        return CartesianGrid(x[0, 0, 0], h, *(tensor.reshape(3, 3, *x.shape[:3]) for tensor in tensors))

    surface = StarSurface.from_radius(radius, center=center)
    true = embed_surface(surface.data(holes))

    def energies(found):
        least = wang_yau(found.data, "optimal", embedding=found.embedding, degrees=(2, 4)).energy
        return found.energies.brown_york, found.energies.liu_yau, least

    rows, before = [], None
    names, exact = ("Brown-York", "Liu-Yau", "Wang-Yau"), energies(true)
    for h in SPACINGS:
        there = [energies(embed_surface(surface.data(sampled(h, shift)), start=true)) for shift in SHIFTS]
        off = np.array([[e.value - t.value for e, t in zip(one, exact, strict=True)] for one in there])
        stated = np.array([[e.error for e in one] for one in there])
        error = np.sqrt(np.mean(off**2, axis=0))
        for k, name in enumerate(names):
            row = {"spacing": f"{h:g}", "energy": name, "error": float(error[k])}
            row |= {"stated": float(stated[:, k].min()), "held": bool(np.all(np.abs(off) <= stated))}
            if before is not None:
                row["rate"] = round(float(np.log(before[k] / error[k]) / np.log(4.0 / 3.0)), 1)
            rows.append(row)
        before = error
    show("Two holes in motion, a surface without symmetry on Cartesian grids", rows)
    return rows


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows to this file")
    options = parser.parse_args()
    parts = {
        "spheres": spheres,
        "minkowski": minkowski,
        "boosted": boosted,
        "kerr": kerr,
        "extreme": extreme,
        "pair": pair,
        "horizon": horizon,
        "grid": grid,
    }
    embed_smooth(round_sphere(4.0).metric)  # compiles, or loads what was compiled
    result = {}
    for part in PARTS:
        if part in options.only:
            seconds, result[part] = seconds_of(parts[part])
            print(f"\n{part}: {seconds:.0f} s", flush=True)
    if options.json:
        options.json.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
