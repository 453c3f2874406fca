"""Surfaces without symmetry, horizons of mergers first: what is right, and what does it cost?

    python benchmarks/mergers.py [--only PART ...] [--json FILE]

Parts.  "bodies": metrics of known surfaces in poor coordinates, seen from a bad center or through maps that
bend.  "horizons": of Brill and Lindquist's slice, found there, against the shooting of mergers_horizons.py:
upright; tilted by 0.7, the pair of holes off the origin; and tilted, not found but given as a radius about
a poor center, or as a map that is seen from one.  "mass" is the relative error of the irreducible mass.
"ends": the distance at which common horizons end and that at which the waist of one has K = 0, by roots of
what is found.  "kerr": horizons in tilted Kerr-Schild slices, against quadrature; those beyond Smarr's limit
have to be refused.  "grids": Brown-York and least Wang-Yau energies of a surface without symmetry in a tilted
Kerr-Schild slice on Cartesian grids, against those in the closed form, and with which power of the spacing
they settle.  "cost": one solve each at degrees 32, 64 and 128, to the strains that an embedding asks for,
from a surface that is off by some thousandths, how often the strains' adjoint was taken, the most memory of
the process, and with which power of (L + 1)^2 the seconds grow.

True and stated errors are relative ones of int H dA = int k0 dA / 2, "ratio" is the one over the other, 0
where there is only rounding.  What is asked stands beside what was attained.  Seconds are those of the
processor.
"""

import argparse
import json
import time
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from honesty_surfaces import sampled
from honesty_truth import kerr_horizon
from isoembed import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.errors import NoHorizon
from isoembed.relativity import (
    BrillLindquist,
    KerrSchild,
    MappedSurface,
    StarSurface,
    embed_surface,
    find_horizon,
    wang_yau,
)
from isoembed.smooth import Harmonics, SmoothEmbedding, embed_smooth
from isoembed.smooth.gauss_newton import gauss_newton
from isoembed.smooth.sphere_transform import SphereTransform
from mergers_bodies import bodies
from mergers_horizons import TABLE, Holes, flat_waist, last_distance
from mergers_rows import CostRow, GridRow, Root, Row, summary

PARTS = ("bodies", "horizons", "ends", "kerr", "grids", "cost")
TILT = 0.7
AXIS = (0.36, 0.48, 0.8)  # about which it is tilted
OFF = (0.3, -0.2, 0.1)  # of the pair of holes, from the origin
ASIDE = 0.3  # of the center of a surface, over its least radius
DISTANCES = (0.7655, 0.7658, 0.766, 0.7661)  # near the end of common horizons
EMBEDDED = (0.0, 0.2, 0.4, 0.6, 0.8, 0.86, 0.865, 0.866)
REFUSED = (0.8665, 0.867, 0.87, 0.88, 0.9, 0.95, 0.99)
MAPPED = ("equal, d = 0.5, inner",)  # as rho and z by the length of the meridian
PRICED = ("ellipsoid (3, 2, 1) as r(u)", "waist without symmetry")
DEGREES, LOW, DISTURBED = (32, 64, 128), 6, 0.002
TARGET = 1e-10  # strains, as `embed_smooth` asks by default
SPIN, CENTER, REACH = 0.6, (0.2, 0.1, -0.15), 3.9  # of the surface on grids
SPACINGS = (0.4, 0.2, 0.1)


def measured(name, truth, asked, solve, mass=None):
    """A row, printed: `solve` returns int H dA, its error, the `SmoothEmbedding` and the irreducible mass."""
    started = time.process_time()
    try:
        value, error, found, irreducible = solve()
    except (InvalidMetric, InvalidParameter, NoHorizon, NotEmbedded) as why:
        row = Row(name, time.process_time() - started, asked, refusal=f"{type(why).__name__}: {why}")
    else:
        row = Row(
            name,
            time.process_time() - started,
            asked,
            abs(value / truth - 1.0),
            error / truth,
            found.residual,
            found.harmonics.degree,
            None if mass is None else abs(irreducible / mass - 1.0),
        )
    print(row, flush=True)
    return row


def of_metric(metric):
    def solve():
        found = embed_smooth(metric)
        return found.integrated_mean_curvature, found.curvature_error, found, None

    return solve


def of_surface(data):
    """`data` is called first, for its time counts."""

    def solve():
        found = embed_surface(data())
        imc = found.energies.integrated_mean_curvature
        return imc.value, imc.error, found.embedding, found.energies.irreducible_mass.value

    return solve


def of_bodies():
    for body in bodies():
        truth = body.integrals(body.nodes)[1] if body.truth is None else body.truth
        yield measured(body.name, truth, 1e-10 if body.positive else 1e-6, of_metric(body))


def turn(angle=TILT):
    """The rotation by an angle about the axis, by Rodrigues's formula."""
    x, y, z = AXIS
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def seen_from(radius, at):
    """The radius about a point `at` (3,) inside of the surface r = radius(u), by Newton's method."""

    def other(u):
        t = radius(u)
        for _ in range(60):
            x = at + t[:, None] * u
            r = np.linalg.norm(x, axis=1)
            off = r - radius(x / r[:, None])
            h = 1e-6 * t
            y = at + (t + h)[:, None] * u
            s = np.linalg.norm(y, axis=1)
            step = off * h / (s - radius(y / s[:, None]) - off)
            t = t - step
            if np.abs(step).max() < 1e-15 * t.max():
                break
        return t

    return other


def slice_of(holes, rotation, origin):
    return BrillLindquist(holes.masses, [tuple(origin + h * rotation[:, 2]) for h in holes.heights])


def given(name, holes, truth, where):
    """Data of a horizon that is given: about a poor center, or mapped where no radius is smooth enough."""
    upright = where == "upright"
    rotation, origin = (np.eye(3), np.zeros(3)) if upright else (turn(), np.array(OFF))
    slice_ = slice_of(holes, rotation, origin)
    aside = ASIDE * (0.8 * rotation[:, 0] + 0.6 * rotation[:, 2]) * (where == "poor center")
    if name in MAPPED:
        across, along = truth.meridian()

        def point(u):
            v = (u + aside) @ rotation
            v /= np.linalg.norm(v, axis=1)[:, None]
            R = across(v[:, 2])
            return origin + np.stack([R * v[:, 0], R * v[:, 1], along(v[:, 2])], axis=1) @ rotation.T

        return MappedSurface.from_map(point).data(slice_, marginal=True)
    profile = truth.radius()
    aside = aside * float(profile(np.linspace(-1.0, 1.0, 999)).min())
    center = origin + 0.5 * (truth.top + truth.bottom) * rotation[:, 2]
    seen = seen_from(lambda u: profile(u @ rotation[:, 2]), aside)
    return StarSurface.from_radius(seen, tuple(center + aside)).data(slice_, marginal=True)


def searched(name, holes, truth, where):
    """Data of the horizon that is found, the outermost one or one near a sphere."""
    rotation, origin = (np.eye(3), np.zeros(3)) if where == "upright" else (turn(), np.array(OFF))
    guess = None
    if "individual" in name:
        center = origin + 0.5 * (truth.top + truth.bottom) * rotation[:, 2]
        guess = StarSurface.sphere(tuple(center), 0.5 * (truth.top - truth.bottom))
    return find_horizon(slice_of(holes, rotation, origin), guess).data()


def of_horizons():
    for name, (masses, distance, top, bottom, plane) in TABLE.items():
        holes = Holes(masses, distance)
        truth = holes.horizon(top, bottom, plane)
        asked = 1e-8 if truth.least_curvature > 0.0 else 1e-6
        for where in ("upright", "tilted", "poor center"):
            how = given if where == "poor center" or name in MAPPED else searched
            yield measured(
                f"{name}, {where}",
                truth.integrated_mean_curvature,
                1e-8 if where == "upright" else asked,
                of_surface(partial(how, name, holes, truth, where)),
                truth.irreducible_mass,
            )


def pair(distance, rotation):
    return find_horizon(slice_of(Holes((0.5, 0.5), distance), rotation, np.zeros(3)))


def of_ends():
    """The end of common horizons and the flat waist, each upright and tilted."""
    for where, rotation in (("upright", np.eye(3)), ("tilted", turn())):
        started = time.process_time()
        # The stability eigenvalue vanishes there; d is stationary as a function of it.
        d = np.array(DISTANCES)
        eigenvalues = np.array([pair(x, rotation).stability for x in d])
        powers = np.stack([eigenvalues**n for n in (0, 2, 3, 4)], axis=1)
        end = np.linalg.solve(powers, d)[0]
        yield Root(f"end of common horizons, {where}", end, last_distance()[0], time.process_time() - started)

        started = time.process_time()
        equator = rotation[:, :1].T

        def curvature(x, rotation=rotation, equator=equator):
            return float(embed_surface(pair(x, rotation).data()).embedding.gaussian_curvature(equator)[0])

        flat = brentq(curvature, 0.62, 0.635, xtol=1e-9)
        yield Root(f"K = 0 on the waist, {where}", flat, flat_waist(), time.process_time() - started)


def of_grids():
    """Energies of one surface in a slice on grids, against those in its closed form."""
    slice_ = KerrSchild(1.0, tuple(SPIN * turn()[:, 2]))
    surface = StarSurface.from_radius(lambda u: 3.0 + 0.2 * u[:, 0] * u[:, 1] + 0.1 * u[:, 2] ** 3, CENTER)

    def energies(geometry, start=None):
        data = surface.data(geometry)
        found = embed_surface(data, start=start)
        least = wang_yau(data, "optimal", embedding=found.embedding).energy
        return found, {"Brown-York": found.energies.brown_york, "Wang-Yau": least}

    start, truth = energies(slice_)
    before = {}
    for spacing in SPACINGS:
        started = time.process_time()
        _, found = energies(sampled(slice_, spacing, REACH, 0.0), start)
        seconds = time.process_time() - started
        for name, energy in found.items():
            row = GridRow(name, spacing, energy.value, truth[name].value, energy.error, seconds)
            power = np.log(before[name] / row.off) / np.log(2.0) if name in before else None
            before[name] = row.off
            yield replace(row, power=power)


def of_cost():
    """Solves of one degree each, from the true surface with its lowest harmonics disturbed."""
    for body in bodies():
        if body.name not in PRICED:
            continue
        before = None
        for L in DEGREES:
            harmonics = Harmonics(L, L)
            nodes = SphereTransform(harmonics, 2 * L, 4 * L)
            C = nodes.analysis(np.stack(body.X(*nodes.u.T), axis=1))
            rng = np.random.default_rng(L)
            low = harmonics.labels[0] <= LOW
            C[low] += DISTURBED * rng.normal(size=(low.sum(), 3)) * np.abs(C).max() / (LOW + 1)
            with counted(SphereTransform, "adjoint_gradients") as calls, peak() as memory:
                started = time.process_time()
                C = gauss_newton(body, harmonics, C, TARGET)
                seconds = time.process_time() - started
            power = np.log(seconds / before[1]) / np.log(((L + 1) / (before[0] + 1)) ** 2) if before else None
            before = L, seconds
            strain = SmoothEmbedding(body, harmonics, C, np.inf, np.inf).residual
            yield CostRow(body.name, L, seconds, len(calls), memory[0], strain, power)


@contextmanager
def counted(owner, method):
    """A list that grows with each call of a method."""
    calls, original = [], getattr(owner, method)

    def wrapped(self, *arguments):
        calls.append(1)
        return original(self, *arguments)

    setattr(owner, method, wrapped)
    try:
        yield calls
    finally:
        setattr(owner, method, original)


@contextmanager
def peak():
    """A list with the most memory that the process held meanwhile, in GB."""
    Path("/proc/self/clear_refs").write_text("5")  # of Linux
    memory = []
    yield memory
    status = Path("/proc/self/status").read_text()
    memory.append(int(status.split("VmHWM:")[1].split()[0]) / 1e6)


def of_kerr():
    axis = turn()[:, 2]
    for a in EMBEDDED + REFUSED:

        def data(a=a):
            slice_ = KerrSchild(1.0, tuple(a * axis))
            return StarSurface.from_radius(slice_.spheroid(slice_.horizon)).data(slice_, marginal=True)

        truth = kerr_horizon(a).truth()["integrated_mean_curvature"]
        asked = 0.0 if a in REFUSED else 1e-9
        yield measured(f"tilted Kerr-Schild, a = {a:g}", truth, asked, of_surface(data))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all rows")
    options = parser.parse_args()
    rows = {}
    for part in options.only:
        print(f"\n{part}\n")
        if part in ("ends", "grids", "cost"):
            rows[part] = []
            for row in {"ends": of_ends, "grids": of_grids, "cost": of_cost}[part]():
                print(row, flush=True)
                rows[part].append(vars(row))
            continue
        some = list({"bodies": of_bodies, "horizons": of_horizons, "kerr": of_kerr}[part]())
        summary(some)
        rows[part] = [{**vars(r), "ratio": r.ratio} for r in some]
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
