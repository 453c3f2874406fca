"""Inputs of honesty.py that are grids in theta and phi."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from honesty_truth import (
    ENERGIES,
    INTRINSIC,
    Ellipsoid,
    Placing,
    StarEllipsoid,
    boosted,
    isotropic,
    kerr_horizon,
    kerr_sphere,
    kinked,
    peaked,
    rotation,
    schwarzschild,
    spinning,
    wave,
)
from isoembed.relativity import SurfaceData, embed_surface
from isoembed.relativity.energies.smooth_energies import intrinsic_energies

SIZES = (4, 5, 6, 8, 9, 12, 16, 24, 33, 65)
NODES = ("cell-centered", "poles", "inner", "gauss")
NOISE = (1e-10, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2)
FINE = 40  # heights of the grid whose embedding others start from
AROUND = 3.0  # the first angle phi of every other grid


@dataclass(frozen=True)
class Case:
    """One input: how its energies are found, and what they are."""

    kind: str
    name: str
    truth: dict
    solve: Callable
    metric_only: bool = False
    sought: tuple = ENERGIES


@dataclass(frozen=True)
class Arrays:
    """What a user would have of a surface."""

    theta: np.ndarray
    phi: np.ndarray
    q: list
    k: np.ndarray | None
    p: np.ndarray | None
    marginal: bool
    j: list | None

    def data(self):
        data = SurfaceData.from_grid(self.theta, self.phi, self.q, self.k, self.p, self.j)
        return replace(data, marginal=self.marginal)


def nodes(kind, n, m, first=0.0, closed=False):
    """The angles of a grid of one of the kinds."""
    theta = {
        "cell-centered": (np.arange(n) + 0.5) * np.pi / n,
        "poles": np.linspace(0.0, np.pi, n),
        "inner": np.linspace(0.0, np.pi, n + 2)[1:-1],
        "gauss": np.arccos(np.polynomial.legendre.leggauss(n)[0])[::-1],
    }[kind]
    return theta, first + np.arange(m + closed) * (2.0 * np.pi / m)


def arrays(body, placing, theta, phi):
    k = None if body.k is None else placing.values(body, body.k, theta, phi)
    p = None if k is None else placing.values(body, body.p, theta, phi)
    p = None if p is None or not p.any() else p
    j = placing.one_form(body, theta, phi) if getattr(body, "j", None) else None
    return Arrays(theta, phi, placing.components(body, theta, phi), k, p, body.marginal, j)


@cache
def start(name, unit, rotation, warp, fold, phase):
    """The embedding of a body on a fine grid, by what it depends on."""
    body, placing = _known[name], Placing(unit, np.array(rotation), warp, fold, phase)
    return embed_surface(arrays(body, placing, *nodes("cell-centered", FINE, 2 * FINE)).data())


_known = {}


def case(kind, name, body, placing, angles, disturbed=None, embedded=True, metric_only=False):
    """A body on a grid; `disturbed` changes the arrays."""
    _known[body.name] = body

    def solve():
        given = arrays(body, placing, *angles)
        data = (disturbed(given) if disturbed else given).data()
        if not embedded:
            return intrinsic_energies(data)
        turned = tuple(map(tuple, placing.rotation.tolist()))
        near = start(body.name, placing.unit, turned, placing.warp, placing.fold, placing.phase)
        return embed_surface(data, start=near).energies

    return Case(
        kind,
        f"{body.name}, {name}, {len(angles[0])} x {len(angles[1])}",
        placing.scaled(truth(body)),
        solve,
        metric_only,
        ENERGIES if embedded else INTRINSIC,
    )


@cache
def truth(body):
    return body.truth()


def on_nodes():
    """Closed forms on nodes of every kind, phi starting anywhere, end point repeated, one angle."""
    bodies = (
        kerr_horizon(0.8),
        kerr_sphere(3.0, 0.8),
        isotropic(2.0, 0.5),
        schwarzschild(4.0, "kerr-schild"),
    )
    around = ((lambda n: 2 * n, 0.0, False), (lambda n: 1, 0.0, False), (lambda n: n + 4, AROUND, True))
    for i, body in enumerate(bodies):
        for j, kind in enumerate(NODES):
            for n in SIZES:
                m, first, closed = around[(i + j + n) % 3]
                placing = Placing()
                yield case(
                    "nodes", kind, body, placing, nodes(kind, n, m(n), first, closed), metric_only=True
                )


def in_units():
    for unit in (1e-3, 1.0, 1e6):
        for body in (kerr_sphere(3.0, 0.8), kerr_horizon(0.5)):
            for n in (6, 9, 16):
                angles = nodes("cell-centered", n, 2 * n)
                yield case("units", f"{unit:g}", body, Placing(unit), angles, metric_only=True)


def rotated():
    """Bodies rotated or warped against the grid."""
    placings = [
        *((body, "rotated", Placing(rotation=rotation(1))) for body in (kerr_sphere(3.0, 0.8),)),
        (isotropic(2.0, 0.5), "rotated", Placing(rotation=rotation(2))),
        (isotropic(2.0, 0.0, 0.2), "rotated", Placing(rotation=rotation(3))),
        (kerr_horizon(0.7), "rotated", Placing(rotation=rotation(4))),
        (schwarzschild(4.0), "warped", Placing(warp=0.05)),
        (kerr_sphere(3.0, 0.5), "warped", Placing(warp=0.1)),
        (boosted(3.0, 0.4), "rotated", Placing(rotation=rotation(5))),
        (Ellipsoid("ellipsoid 1, 1.1, 1.2", (1.0, 1.1, 1.2)), "rotated", Placing(rotation=rotation(6))),
    ]
    for body, name, placing in placings:
        for n in (6, 9, 16):
            angles = nodes(NODES[n % 4], n, 2 * n, AROUND)
            yield case("rotations", f"{name}, {NODES[n % 4]}", body, placing, angles, metric_only=True)


def ellipsoids():
    """By the directions of their points: coarse grids resolve them badly, and averages well."""
    for i, axes in enumerate(
        ((1.0, 1.0, 1.3), (1.0, 1.2, 1.5), (1.2, 1.1, 1.0), (2.0, 1.5, 1.0), (3.0, 2.0, 1.0))
    ):
        body = StarEllipsoid("star ellipsoid {:g}, {:g}, {:g}".format(*axes), axes)
        for j, n in enumerate((8, 12, 16, 24, 32)):
            kind = NODES[(i + j) % 4] if j % 2 else NODES[0]
            for name, placing in (("upright", Placing()), ("rotated", Placing(rotation=rotation(10)))):
                angles = nodes(kind, n, 2 * n)
                yield case("ellipsoids", f"{name}, {kind}", body, placing, angles, metric_only=True)


def noise(rng, level, which):
    """Adds noise to q (by components along unit vectors), k, p."""

    def disturbed(a):
        shape, sin = a.q[0].shape, np.sin(a.theta)[:, None]
        q, size = a.q, a.q[0].max()
        if "q" in which:
            q = [c + level * size * sin**i * rng.normal(size=shape) for i, c in enumerate(q)]
        k, p = (
            values
            if values is None or name not in which
            else values + level * np.abs(a.k).max() * rng.normal(size=shape)
            for name, values in (("k", a.k), ("p", a.p))
        )
        j = a.j
        if "j" in which:
            size = level * np.abs(a.j).max()
            j = [c + size * sin**i * rng.normal(size=shape) for i, c in enumerate(a.j)]
        return replace(a, q=q, k=k, p=p, j=j)

    return disturbed


def spins():
    """Horizons with K(., n), from which the angular momentum and its axis are found."""
    for a in (0.1, 0.6):
        for name, placing in (
            ("upright", Placing()),
            ("rotated", Placing(rotation=rotation(9))),
            ("rotated, 1e6", Placing(1e6, rotation(9))),
        ):
            for n in (6, 9, 16):
                yield case("spin", name, spinning(a), placing, nodes("cell-centered", n, 2 * n))
        for level in NOISE:
            rng = np.random.default_rng(11)
            name, placing = f"rotated, {level:.0e} in j", Placing(rotation=rotation(9))
            disturbed = noise(rng, level, "j")
            yield case("spin", name, spinning(a), placing, nodes("cell-centered", 16, 32), disturbed)


def noisy(seeds):
    bodies = (schwarzschild(4.0, "kerr-schild"), kerr_sphere(3.0, 0.8))
    for seed in range(seeds):
        for body in bodies:
            for n in (12, 24):
                for level in NOISE:
                    for which in ("k", "p", "kp", "q", "qkp", "qkp of 1 %"):
                        if "p" in which and not body.p(np.ones(1)).any():
                            continue
                        rng = np.random.default_rng([seed, n])
                        q = "q" in which
                        disturbed = noise(rng, level, which[:3])
                        if which.endswith("%"):  # k and p a hundred times noisier than q
                            disturbed = then(noise(rng, 0.01 * level, "q"), noise(rng, level, "kp"))
                        yield case(
                            "noise",
                            f"{level:.0e} in {which}",
                            body,
                            Placing(),
                            nodes("cell-centered", n, 2 * n),
                            disturbed,
                            embedded=not q or n == 12,
                        )
        body = kerr_sphere(3.0, 0.8)
        for level in NOISE:  # noise that is symmetric about z
            rng = np.random.default_rng([seed, 7])
            for which in ("q", "k"):
                angles = nodes("gauss", 32, 1)
                yield case(
                    "noise", f"{level:.0e} in {which}", body, Placing(), angles, noise(rng, level, which)
                )


def then(first, second):
    return lambda a: second(first(a))


def with_kinks():
    for power, of_k in ((3, False), (5, False), (1, True), (3, True)):
        body = kinked(power, 0.05, of_k)
        for n in (8, 16, 33, 64):
            for name, placing in (("upright", Placing()), ("rotated", Placing(rotation=rotation(7)))):
                angles = nodes(NODES[n % 4], n, 2 * n)
                yield case("kinks", name, body, placing, angles, embedded=name == "upright")


def in_single_precision():
    def values(a):
        single = [None if x is None else x.astype(np.float32) for x in (*a.q, a.k, a.p)]
        return replace(a, q=single[:3], k=single[3], p=single[4])

    def angles(a):
        return replace(values(a), theta=a.theta.astype(np.float32), phi=a.phi.astype(np.float32))

    for body in (kerr_sphere(3.0, 0.8), schwarzschild(4.0, "kerr-schild"), kerr_horizon(0.5)):
        for n in (8, 16, 32):
            for name, cast in (("values", values), ("angles, too", angles)):
                yield case("float32", name, body, Placing(), nodes("cell-centered", n, 2 * n), cast)


def aliased():
    """Waves around the axis that the angles phi do not, or hardly, resolve."""
    for fold, ms, n in ((8, (16, 20, 24), 24), (4, (8, 10, 12), 16)):
        for m in ms:
            for phase in (0.0, 0.3, 0.7 * np.pi / fold):
                angles = nodes("cell-centered", n, m)
                name = f"{fold}-fold, phase {phase:.2f}"
                moved = Placing(warp=0.01, fold=fold, phase=phase)
                cheap = fold == 4 and phase > 0.3
                yield case("aliasing", name, schwarzschild(4.0), moved, angles, embedded=cheap)
                yield case("aliasing", name, kerr_sphere(3.0, 0.8), moved, angles, embedded=False)
                k = Ellipsoid(
                    f"k of {name}", (2.0, 2.0, 2.0), lambda u, f=fold, s=phase: 1.0 + 0.2 * wave(u, f, s)
                )
                yield case("aliasing", "round", k, Placing(), angles)


def rough_k():
    """A round metric, and k that the grid resolves badly, or that is given the wrong way round."""
    for width in (0.1, 0.3):
        peak = Ellipsoid(
            f"peak {width}",
            (2.0, 2.0, 2.0),
            peaked(width),
        )
        for n in (6, 8, 12, 16, 24, 32, 48):
            yield case("rough k", "round", peak, Placing(), nodes("cell-centered", n, 2 * n))

    def transposed(a):
        return replace(a, k=a.k.T)

    for body in (isotropic(2.0, 0.5), kerr_sphere(3.0, 0.8)):
        yield case("rough k", "transposed", body, Placing(), nodes("cell-centered", 24, 24), transposed)


def outliers():
    """One node of k, or of q, that is wrong."""

    def one(at, size, of_k):
        def disturbed(a):
            k, q = a.k.copy(), [c.copy() for c in a.q]
            if of_k:
                k[at] *= 1.0 + size
            else:
                q[0][at] *= 1.0 + size
            return replace(a, q=q, k=k)

        return disturbed

    for body in (schwarzschild(4.0), isotropic(2.0, 0.5)):
        for at in ((0, 3), (8, 5), (15, 31)):
            for size in (1e-4, 1e-2, 0.2):
                angles = nodes("cell-centered", 16, 32)
                name = f"{size:g} at {at[0]}, {at[1]}"
                yield case("outliers", f"k by {name}", body, Placing(), angles, one(at, size, True))
                yield case(
                    "outliers", f"q by {name}", body, Placing(), angles, one(at, size, False), embedded=False
                )


def cases(seeds):
    """All of them."""
    yield from on_nodes()
    yield from in_units()
    yield from rotated()
    yield from ellipsoids()
    yield from spins()
    yield from noisy(seeds)
    yield from with_kinks()
    yield from in_single_precision()
    yield from aliased()
    yield from rough_k()
    yield from outliers()
