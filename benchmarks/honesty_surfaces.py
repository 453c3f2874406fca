"""Inputs of honesty.py that are surfaces in slices: closed forms, points, slices on Cartesian grids."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from honesty_grids import Case, truth
from honesty_truth import (
    INTRINSIC,
    Body,
    boosted,
    isotropic,
    kerr_horizon,
    kerr_schild_sphere,
    kerr_sphere,
    rotation,
    schwarzschild,
)
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import (
    BoostedSchwarzschild,
    CartesianGrid,
    IsotropicSchwarzschild,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    embed_surface,
)
from isoembed.relativity.energies.smooth_energies import intrinsic_energies

NOISE = (1e-10, 1e-8, 1e-6, 1e-4, 1e-3)
SPACINGS = (0.4, 0.2, 0.1)
SPIN = (0.0, -0.6 * np.sin(0.4), 0.6 * np.cos(0.4))


@dataclass(eq=False)
class Scene:
    """A body as a surface of a slice; `k_known` is False where the body's k is that of another slice."""

    body: Body
    geometry: object
    radius: Callable
    center: tuple = (0.0, 0.0, 0.0)
    k_known: bool = True

    @property
    def truth(self):
        return truth(self.body) | ({} if self.k_known else {"brown_york": None})

    def data(self, surface, geometry=None):
        return surface.data(geometry or self.geometry, marginal=self.body.marginal)

    @cached_property
    def start(self):
        return embed_surface(self.data(StarSurface.from_radius(self.radius, self.center)))

    def energies(self, data, embedded):
        return embed_surface(data, start=self.start).energies if embedded else intrinsic_energies(data)


def scenes():
    """By name; one geometry each."""
    axis = rotation(8)[2]
    hole = IsotropicSchwarzschild(1.0)
    tilted = KerrSchild(1.0, SPIN)
    swift = BoostedSchwarzschild(1.0, (0.0, 0.24, 0.32))
    return {
        "tilted Kerr horizon": Scene(kerr_horizon(0.6), tilted, tilted.spheroid(tilted.horizon)),
        "tilted Kerr r = 3": Scene(kerr_sphere(3.0, 0.6), tilted, tilted.spheroid(3.0), k_known=False),
        "sphere in Kerr-Schild": Scene(
            schwarzschild(4.0, "kerr-schild"), KerrSchild(1.0, (0.0, 0.0, 0.0)), lambda u: 4.0 + 0.0 * u[:, 0]
        ),
        "sphere in Painleve-Gullstrand": Scene(
            schwarzschild(4.0, "painleve-gullstrand"), PainleveGullstrand(1.0), lambda u: 4.0 + 0.0 * u[:, 0]
        ),
        "sphere off the hole": Scene(
            isotropic(2.0, 0.5), hole, lambda u: 2.0 + 0.0 * u[:, 0], tuple(0.5 * axis)
        ),
        "egg": Scene(isotropic(2.0, 0.0, 0.2), hole, lambda u: 2.0 + 0.2 * (u @ axis) ** 2),
        "boosted": Scene(boosted(3.0, 0.4), swift, swift.spheroid(3.0)),
        "boosted throat": Scene(boosted(0.5, 0.4), swift, swift.spheroid(0.5)),
    }


def case(kind, name, scene, surface, geometry=None, embedded=True):
    def solve():
        return scene.energies(scene.data(surface(), geometry and geometry()), embedded)

    return Case(kind, name, scene.truth, solve, **({} if embedded else {"sought": INTRINSIC}))


def closed_forms():
    for name, scene in scenes().items():
        yield case("surfaces", name, scene, lambda s=scene: StarSurface.from_radius(s.radius, s.center))


def cloud(scene, n, seed, level=0.0, wrong=()):
    """A surface through n points, with noise and with some radii too large by a factor."""
    rng = np.random.default_rng([seed, n])
    u = fibonacci_directions(n)
    u = u + 0.3 / np.sqrt(n) * rng.normal(size=u.shape)
    u /= np.linalg.norm(u, axis=1)[:, None]
    r = scene.radius(u)
    r = r * (1.0 + level * rng.normal(size=n))
    for i, factor in wrong:
        r[i] *= factor
    return StarSurface.from_points(np.array(scene.center) + r[:, None] * u, scene.center)


def points(seeds):
    chosen = [scenes()[name] for name in ("tilted Kerr horizon", "sphere in Kerr-Schild", "egg")]
    names = ("tilted Kerr horizon", "sphere in Kerr-Schild", "egg")
    for seed in range(seeds):
        for name, scene in zip(names, chosen, strict=True):
            for n in (150, 600):
                for level in (0.0, *NOISE):
                    yield case(
                        "points",
                        f"{name}, {n} points, noise {level:g}",
                        scene,
                        lambda s=scene, n=n, e=level, k=seed: cloud(s, n, k, e),
                        embedded=n == 600 and name != "egg",
                    )
            for wrong in (((17, 1.2),), ((300, 0.8),), ((5, 1.05),), ((5, 1.2), (400, 1.2))):
                yield case(
                    "points",
                    f"{name}, 600 points, outliers {wrong}",
                    scene,
                    lambda s=scene, w=wrong, k=seed: cloud(s, 600, k, 1e-6, w),
                    embedded=len(wrong) == 1 and name != "egg",
                )


@cache
def sampled(geometry, spacing, reach, level):
    """A geometry on a grid, with noise of this size."""
    n = int(np.ceil(reach / spacing))
    edge = (np.arange(-n, n) + 0.5) * spacing
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = (2 * n,) * 3
    rng = np.random.default_rng(1)

    def six(tensors):
        i, j = np.triu_indices(3)
        return np.stack([tensors[:, a, b].reshape(shape) for a, b in zip(i, j, strict=True)])

    def noisy(fields):
        return fields + level * rng.normal(size=fields.shape)

    K = None if geometry.time_symmetric else noisy(six(geometry.extrinsic_curvature(x)))
    return CartesianGrid((edge[0],) * 3, spacing, noisy(six(geometry.metric(x))), K)


def slices():
    known = scenes()
    for name in ("egg", "sphere off the hole", "sphere in Kerr-Schild", "tilted Kerr horizon", "boosted"):
        scene = known[name]
        reach = float(np.abs(scene.center).max() + scene.radius(fibonacci_directions(50)).max()) + 0.3
        for spacing in SPACINGS:
            for level in (0.0, 1e-8, 1e-5, 1e-3) if spacing == 0.2 else (0.0,):
                yield case(
                    "slices",
                    f"{name}, spacing {spacing:g}, noise {level:g}",
                    scene,
                    lambda s=scene: StarSurface.from_radius(s.radius, s.center),
                    lambda s=scene, h=spacing, r=reach, e=level: sampled(s.geometry, h, r, e),
                    embedded=name in ("egg", "sphere in Kerr-Schild") and level < 1e-6,
                )


def noisy_slices(seeds):
    """A sphere about a point of a hole's tilted axis, on a coarse grid with noise in gamma_ij and K_ij."""
    axis, a, height, radius = np.array([0.48, 0.6, 0.64]), 0.55, 0.35, 2.7
    hole, spacing = KerrSchild(1.0, tuple(a * axis)), 0.35
    edge = np.arange(-4.85, 4.86, spacing) + 0.013  # no node in the center
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    gamma, K = hole.metric(x), hole.extrinsic_curvature(x)
    area = kerr_schild_sphere(a, height, radius)
    true = dict.fromkeys(INTRINSIC) | {"area": area, "irreducible_mass": np.sqrt(area / (16.0 * np.pi))}
    i, j = np.triu_indices(3)

    def noisy(tensors, rng, level):
        six = tensors[:, i, j] + level * rng.normal(size=(len(x), 6))
        return six.T.reshape(6, *[len(edge)] * 3)

    def solve(level, seed):
        rng = np.random.default_rng([3, seed])
        grid = CartesianGrid([edge[0]] * 3, spacing, noisy(gamma, rng, level), noisy(K, rng, level))
        return intrinsic_energies(StarSurface.sphere(tuple(height * axis), radius).data(grid))

    for level in (1e-5, 1e-3):
        for seed in range(20 * seeds):
            name = f"sphere in Kerr-Schild, spacing {spacing:g}, noise {level:g}, draw {seed}"
            yield Case(
                "noisy slices",
                name,
                true,
                lambda e=level, s=seed: solve(e, s),
                sought=("area", "irreducible_mass"),
            )


def cases(seeds):
    """All of them."""
    yield from closed_forms()
    yield from points(seeds)
    yield from slices()
    yield from noisy_slices(seeds)
